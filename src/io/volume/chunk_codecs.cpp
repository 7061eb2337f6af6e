// SPDX-License-Identifier: Apache-2.0
#include "io/volume/chunk_codecs.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

#include "base/text.h"
#include "io/volume/header_bytes.h"
#include "io/volume/stored_volume.h"
#include "quench/error.h"
#ifdef QUENCH_HAS_ZSTD
#include <zstd.h>
#endif
#ifdef QUENCH_HAS_BLOSC
#include <blosc.h>
#endif

namespace quench::io {
namespace {

bool inflate_chunk(std::span<const std::byte> packed, std::span<std::byte> out) {
  constexpr int kZlibOrGzip = 15 + 32;
  if (packed.size() > std::numeric_limits<uInt>::max() || out.size() > std::numeric_limits<uInt>::max()) return false;
  z_stream z{};
  if (inflateInit2(&z, kZlibOrGzip) != Z_OK) throw std::bad_alloc();
  z.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  z.avail_in = static_cast<uInt>(packed.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  const int result = inflate(&z, Z_FINISH);  // to its checksum
  inflateEnd(&z);
  return result == Z_STREAM_END && z.avail_out == 0 && z.avail_in == 0;
}

bool unpack_zstd([[maybe_unused]] std::span<const std::byte> packed, [[maybe_unused]] std::span<std::byte> out) {
#ifdef QUENCH_HAS_ZSTD
  return ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size()) == out.size();
#else
  return false;
#endif
}

bool unpack_blosc([[maybe_unused]] std::span<const std::byte> packed, [[maybe_unused]] std::span<std::byte> out) {
#ifdef QUENCH_HAS_BLOSC
  std::size_t size = 0;
  return blosc_cbuffer_validate(packed.data(), packed.size(), &size) == 0 && size == out.size() &&
         blosc_decompress_ctx(packed.data(), out.data(), out.size(), 1) == static_cast<int>(out.size());
#else
  return false;
#endif
}

}  // namespace

ChunkCodec chunk_codec(const std::filesystem::path& file, std::string_view name) {
  const auto missing = [&](const char* library) {
    throw Error(
        ErrorCode::usage,
        fmt::format("'{}' cannot be read: its chunks are packed by {}, which needs a Quench built with {}; save "
                    "it with gzip, or rebuild",
                    file.string(), name, library));
  };
  if (name == "zlib" || name == "gzip") return ChunkCodec::deflate;
  if (name == "crc32c") return ChunkCodec::crc32c;
  if (name == "zstd") {
#ifndef QUENCH_HAS_ZSTD
    missing("libzstd");
#endif
    return ChunkCodec::zstd;
  }
  if (name == "blosc") {
#ifndef QUENCH_HAS_BLOSC
    missing("libblosc");
#endif
    return ChunkCodec::blosc;
  }
  static_cast<void>(missing);
  refuse_volume(file,
                fmt::format("its chunks are packed by '{}', and Quench unpacks zlib, gzip, zstd and blosc; save it "
                            "with one of these",
                            base::plain(std::string(name.substr(0, 40)))));
}

bool unpack_chunk(std::span<const std::byte> packed, std::span<const ChunkCodec> codecs, std::span<std::byte> out) {
  constexpr std::size_t kChecksum = 4;
  std::vector<std::byte> unpacked;
  for (std::size_t k = codecs.size(); k-- > 0;) {
    if (codecs[k] == ChunkCodec::crc32c) {
      if (packed.size() < kChecksum) return false;
      const std::span<const std::byte> body = packed.first(packed.size() - kChecksum);
      std::uint32_t sum = 0;
      for (std::size_t b = kChecksum; b-- > 0;)
        sum = sum << 8 | std::to_integer<std::uint32_t>(packed[body.size() + b]);
      if (crc32c(body) != sum) return false;
      packed = body;
      continue;
    }
    // What is before it is checksums only.
    std::span<std::byte> target = out;
    if (k > 0) {
      unpacked.resize(out.size() + kChecksum * k);
      target = unpacked;
    }
    const bool good = codecs[k] == ChunkCodec::deflate ? inflate_chunk(packed, target)
                      : codecs[k] == ChunkCodec::zstd  ? unpack_zstd(packed, target)
                                                       : unpack_blosc(packed, target);
    if (!good) return false;
    packed = target;
  }
  if (packed.size() != out.size()) return false;
  if (packed.data() != out.data()) std::memcpy(out.data(), packed.data(), out.size());
  return true;
}

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  constexpr auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      std::uint32_t sum = i;
      for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0x82F63B78u : 0u);
      table[i] = sum;
    }
    return table;
  }();
  std::uint32_t sum = ~std::uint32_t{0};
  for (const std::byte b : bytes) sum = kTable[(sum ^ std::to_integer<std::uint32_t>(b)) & 0xFF] ^ sum >> 8;
  return ~sum;
}

}  // namespace quench::io
