// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "small_files.h"

/// Small arrays of Zarr and N5, after the specifications.
namespace quench::small_files {

enum class ZarrKind { zarr2, zarr3, shards, n5 };

/// An array of uint16 with its metadata file and chunks by name.
struct SmallZarr {
  ZarrKind kind = ZarrKind::zarr2;
  std::string metadata_name, metadata;
  std::vector<std::pair<std::string, std::string>> chunks;

  void write(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    put(folder / metadata_name, metadata);
    for (const auto& [name, bytes] : chunks) put(folder / name, bytes);
  }
  static void put(const std::filesystem::path& file, const std::string& bytes) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
  }
};

inline std::string crc32c_bytes(const std::string& bytes) {
  std::uint32_t sum = ~std::uint32_t{0};
  for (const char c : bytes) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0x82F63B78u : 0u);
  }
  return number(~sum, 4);
}

inline std::string json_list(const std::array<std::int64_t, 3>& values) {
  return "[" + std::to_string(values[0]) + ", " + std::to_string(values[1]) + ", " + std::to_string(values[2]) + "]";
}

/// `samples`: x fastest; `dims` and `chunk` along x, y, z. Chunks of zeros are left out. Packed by zlib; of shards two
/// by two by two chunks are in one.
inline SmallZarr small_zarr(ZarrKind kind, const std::array<std::int64_t, 3>& dims,
                            const std::array<std::int64_t, 3>& chunk, const std::vector<std::uint16_t>& samples) {
  using Sides = std::array<std::int64_t, 3>;
  const bool n5 = kind == ZarrKind::n5;
  const auto turned = [](const Sides& s) { return Sides{s[2], s[1], s[0]}; };
  const auto packed = [&](const Sides& begin) {
    std::string bytes;
    bool empty = true;
    for (std::int64_t z = begin[2]; z < begin[2] + chunk[2]; ++z)
      for (std::int64_t y = begin[1]; y < begin[1] + chunk[1]; ++y)
        for (std::int64_t x = begin[0]; x < begin[0] + chunk[0]; ++x) {
          const bool within = x < dims[0] && y < dims[1] && z < dims[2];
          const std::uint16_t value = within ? samples[static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z))] : 0;
          empty = empty && value == 0;
          bytes += number(value, 2, n5);
        }
    if (empty) return std::string();
    if (!n5) return deflated(bytes, 15 + (kind == ZarrKind::zarr2 ? 0 : 16));
    std::string header = number(0, 2, true) + number(3, 2, true);
    for (const std::int64_t side : chunk) header += number(static_cast<std::uint64_t>(side), 4, true);
    return header + deflated(bytes, 15 + 16);
  };
  const std::int64_t together = kind == ZarrKind::shards ? 2 : 1;
  const auto names = [&](const Sides& i) {
    const Sides order = n5 ? i : turned(i);
    const std::string separator = kind == ZarrKind::zarr2 ? "." : "/";
    return std::string(kind == ZarrKind::zarr3 || kind == ZarrKind::shards ? "c/" : "") + std::to_string(order[0]) +
           separator + std::to_string(order[1]) + separator + std::to_string(order[2]);
  };
  SmallZarr result{kind, {}, {}, {}};
  Sides i{};
  for (i[2] = 0; i[2] * together * chunk[2] < dims[2]; ++i[2])
    for (i[1] = 0; i[1] * together * chunk[1] < dims[1]; ++i[1])
      for (i[0] = 0; i[0] * together * chunk[0] < dims[0]; ++i[0]) {
        std::string data, index;
        for (std::int64_t inner = 0; inner < together * together * together; ++inner) {  // z slowest
          const Sides within{inner % together, inner / together % together, inner / together / together};
          Sides begin{};
          for (std::size_t a = 0; a < 3; ++a) begin[a] = (i[a] * together + within[a]) * chunk[a];
          const std::string one = packed(begin);
          index += one.empty() ? std::string(16, '\xFF') : number(data.size(), 8) + number(one.size(), 8);
          data += one;
        }
        if (kind == ZarrKind::shards && !data.empty()) data += index + crc32c_bytes(index);
        if (!data.empty()) result.chunks.emplace_back(names(i), data);
      }
  const std::string shape = json_list(n5 ? dims : turned(dims)), sides = json_list(n5 ? chunk : turned(chunk));
  if (kind == ZarrKind::zarr2) {
    result.metadata_name = ".zarray";
    result.metadata = "{\"zarr_format\": 2, \"shape\": " + shape + ", \"chunks\": " + sides +
                      ", \"dtype\": \"<u2\", \"order\": \"C\", \"fill_value\": 0, \"filters\": null, "
                      "\"compressor\": {\"id\": \"zlib\", \"level\": 6}}";
  } else if (n5) {
    result.metadata_name = "attributes.json";
    result.metadata = "{\"dimensions\": " + shape + ", \"blockSize\": " + sides +
                      ", \"dataType\": \"uint16\", \"compression\": {\"type\": \"gzip\", \"level\": -1}}";
  } else {
    Sides outer = turned(chunk);
    for (auto& side : outer) side *= together;
    std::string codecs = "[{\"name\": \"bytes\", \"configuration\": {\"endian\": \"little\"}}, {\"name\": \"gzip\"}]";
    if (kind == ZarrKind::shards)
      codecs = "[{\"name\": \"sharding_indexed\", \"configuration\": {\"chunk_shape\": " + sides +
               ", \"codecs\": " + codecs + ", \"index_codecs\": [{\"name\": \"bytes\"}, {\"name\": \"crc32c\"}]}}]";
    result.metadata_name = "zarr.json";
    result.metadata = "{\"zarr_format\": 3, \"node_type\": \"array\", \"shape\": " + shape +
                      ", \"data_type\": \"uint16\", \"chunk_grid\": {\"name\": \"regular\", \"configuration\": "
                      "{\"chunk_shape\": " +
                      json_list(outer) +
                      "}}, \"chunk_key_encoding\": {\"name\": \"default\"}, \"fill_value\": 0, \"codecs\": " + codecs +
                      "}";
  }
  return result;
}

}  // namespace quench::small_files
