// SPDX-License-Identifier: Apache-2.0
#include "io/volume/zarr_chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#include "base/text.h"
#include "io/volume/float16.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

std::uint64_t product(const std::vector<std::int64_t>& sides) {
  std::uint64_t count = 1;
  for (const std::int64_t side : sides) count *= static_cast<std::uint64_t>(side);
  return count;
}

/// A number of `size` bytes.
std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t at, std::size_t size, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t b = 0; b < size; ++b)
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + (big_endian ? b : size - 1 - b)]);
  return value;
}

void reverse_each(std::span<std::byte> bytes, std::size_t size) {
  for (auto at = bytes.begin(); at != bytes.end(); at += static_cast<std::ptrdiff_t>(size))
    std::reverse(at, at + static_cast<std::ptrdiff_t>(size));
}

}  // namespace

ZarrChunks::ZarrChunks(std::filesystem::path file, std::filesystem::path folder, ZarrArray array, ZarrSection section)
    : file_(std::move(file)), folder_(std::move(folder)), array_(std::move(array)), section_(std::move(section)) {}

std::array<std::int64_t, 3> ZarrChunks::sides() const {
  std::array<std::int64_t, 3> result{1, 1, 1};
  for (std::size_t g = 0; g < 3; ++g)
    if (section_.axis[g]) result[g] = array_.chunk[*section_.axis[g]];
  return result;
}

void ZarrChunks::refuse_chunk(const std::string& name, const std::string& why) const {
  refuse_volume(file_, fmt::format("its chunk '{}' {}; copy or download it again", base::plain(name), why));
}

ZarrChunks::Index ZarrChunks::index_of(const ChunkIndex& index) const {
  Index result = section_.at;
  for (std::size_t a = 0; a < array_.axes(); ++a) result[a] /= array_.chunk[a];
  for (std::size_t g = 0; g < 3; ++g)
    if (section_.axis[g]) result[*section_.axis[g]] = index[g];
  return result;
}

std::string ZarrChunks::name_of(const Index& file) const {
  std::string name = array_.prefix;
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (i > 0) name += array_.separator;
    name += std::to_string(file[array_.n5 ? file.size() - 1 - i : i]);
  }
  return name;
}

bool ZarrChunks::is_file(const std::string& name) const {
  std::error_code error;  // a link that leads nowhere is there, and cannot be opened
  const auto type = std::filesystem::symlink_status(folder_ / name, error).type();
  if (type == std::filesystem::file_type::not_found) return false;
  if (type == std::filesystem::file_type::none)
    throw Error(ErrorCode::failed, fmt::format("the chunk '{}' of '{}' cannot be looked at: {}", base::plain(name),
                                               file_.string(), error.message()));
  return true;
}

std::uint64_t ZarrChunks::size_of(const std::string& name) const {
  std::error_code error;
  if (const auto status = std::filesystem::status(folder_ / name, error);
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    refuse_chunk(name, "is not a regular file");
  const auto size = std::filesystem::file_size(folder_ / name, error);
  if (error)
    throw Error(ErrorCode::failed, fmt::format("the chunk '{}' of '{}' cannot be read: {}", base::plain(name),
                                               file_.string(), error.message()));
  return size;
}

std::vector<std::byte> ZarrChunks::bytes_of(const std::string& name, std::uint64_t begin, std::uint64_t size) const {
  std::ifstream in(folder_ / name, std::ios::binary);
  std::vector<std::byte> bytes(size);
  in.seekg(static_cast<std::streamoff>(begin));
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in)
    throw Error(ErrorCode::failed, fmt::format("the chunk '{}' of '{}' cannot be read; check its permissions",
                                               base::plain(name), file_.string()));
  return bytes;
}

std::vector<ZarrChunks::Part> ZarrChunks::parts_of_shard(const std::string& name, std::size_t count) const {
  constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t size = size_of(name);
  const std::uint64_t checksum = array_.index_checked ? 4 : 0;
  if (size < checksum || (size - checksum) / 16 < count) refuse_chunk(name, "is too short for its index");
  const std::uint64_t packed_size = 16 * count + checksum;
  const auto packed = bytes_of(name, array_.index_first ? 0 : size - packed_size, packed_size);
  std::vector<std::byte> index(16 * count);
  const std::vector<ChunkCodec> codecs(array_.index_checked ? 1 : 0, ChunkCodec::crc32c);
  if (!unpack_chunk(packed, codecs, index)) refuse_chunk(name, "has a damaged index (its checksum is wrong)");
  std::vector<Part> parts(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Part part{number_at(index, 16 * i, 8, false), number_at(index, 16 * i + 8, 8, false)};
    if (part.begin == kNowhere && part.size == kNowhere) continue;
    if (part.begin > size || part.size > size - part.begin || part.size == 0)
      refuse_chunk(name, "has an index that points out of it");
    parts[i] = part;
  }
  return parts;
}

ZarrChunks::Part ZarrChunks::part_of(const Index& chunk) {
  constexpr std::size_t kMostParts = std::size_t{1} << 22;  // that are kept: 64 MB
  Index shard(chunk.size());
  std::size_t at = 0, count = 1;
  for (std::size_t a = 0; a < chunk.size(); ++a) {
    const std::int64_t within = array_.shard[a] / array_.chunk[a];
    shard[a] = chunk[a] / within;
    at = at * static_cast<std::size_t>(within) + static_cast<std::size_t>(chunk[a] % within);
    count *= static_cast<std::size_t>(within);
  }
  const std::string name = name_of(shard);
  auto found = shards_.find(name);
  if (found == shards_.end()) {
    if (parts_ > kMostParts) {
      shards_.clear();
      parts_ = 0;
    }
    found = shards_.emplace(name, is_file(name) ? parts_of_shard(name, count) : std::vector<Part>()).first;
    parts_ += found->second.size() + 1;
  }
  return found->second.empty() ? Part{} : found->second[at];
}

bool ZarrChunks::exists(const ChunkIndex& index) {
  const Index chunk = index_of(index);
  return array_.shard.empty() ? is_file(name_of(chunk)) : part_of(chunk).size > 0;
}

/// Blocks of N5 say how large they are: those at the far sides may be cut.
void ZarrChunks::skip_header(const std::string& name, std::span<const std::byte>& packed,
                             std::vector<std::int64_t>& sides) const {
  const std::size_t n = sides.size(), size = 4 + 4 * n;
  if (packed.size() < size || number_at(packed, 2, 2, true) != n) refuse_chunk(name, "has a damaged header");
  const std::uint64_t mode = number_at(packed, 0, 2, true);
  if (mode != 0) refuse_chunk(name, fmt::format("is of the mode {}, which is not samples of one number each", mode));
  for (std::size_t i = 0; i < n; ++i) {
    const auto side = static_cast<std::int64_t>(number_at(packed, 4 + 4 * i, 4, true));
    if (side < 1 || side > sides[n - 1 - i]) refuse_chunk(name, "is larger than its array says, or empty");
    sides[n - 1 - i] = side;
  }
  packed = packed.subspan(size);
}

/// The samples of a chunk as they lie in it, and its sides along the axes of the array.
std::vector<std::byte> ZarrChunks::samples_of(const Index& chunk, std::vector<std::int64_t>& sides) {
  constexpr std::uint64_t kHeaders = std::uint64_t{1} << 16;
  sides = array_.chunk;
  std::string name = name_of(chunk);
  Part part;
  if (array_.shard.empty()) {
    part.size = size_of(name);
  } else {
    part = part_of(chunk);
    Index shard = chunk;
    for (std::size_t a = 0; a < chunk.size(); ++a) shard[a] /= array_.shard[a] / array_.chunk[a];
    name = name_of(shard);
  }
  // What does not shrink grows by little.
  if (part.size > 2 * product(sides) * array_.type.size() + kHeaders) refuse_chunk(name, "is larger than its samples");
  const std::vector<std::byte> bytes = bytes_of(name, part.begin, part.size);
  std::span<const std::byte> packed = bytes;
  if (array_.n5) skip_header(name, packed, sides);
  std::vector<std::byte> samples(product(sides) * array_.type.size());
  if (!unpack_chunk(packed, array_.codecs, samples))
    refuse_chunk(name, "is damaged: it does not unpack to its number of samples");
  if (array_.swapped) reverse_each(samples, array_.type.size());
  return samples;
}

void ZarrChunks::read(const ChunkIndex& index, std::span<std::byte> out) {
  std::vector<std::int64_t> held;
  const std::vector<std::byte> samples = samples_of(index_of(index), held);
  std::vector<std::int64_t> step(held.size());  // between neighbours along each axis
  std::int64_t all = 1;
  for (std::size_t i = held.size(); i-- > 0;) {
    step[array_.order[i]] = all;
    all *= held[array_.order[i]];
  }
  std::int64_t first = 0;
  for (std::size_t a = 0; a < held.size(); ++a) {
    const std::int64_t at = section_.at[a] % array_.chunk[a];
    if (at >= held[a]) refuse_chunk(name_of(index_of(index)), "does not reach the section that is read");
    first += at * step[a];
  }
  std::array<std::int64_t, 3> count{1, 1, 1}, steps{0, 0, 0};
  for (std::size_t g = 0; g < 3; ++g)
    if (section_.axis[g]) {
      count[g] = held[*section_.axis[g]];
      steps[g] = step[*section_.axis[g]];
    }
  const auto wanted = sides();
  const auto copy = [&]<class Stored, class Sample>(Stored, Sample, const auto& value) {
    const auto* from = reinterpret_cast<const Stored*>(samples.data()) + first;
    for (std::int64_t z = 0; z < count[2]; ++z)
      for (std::int64_t y = 0; y < count[1]; ++y) {
        auto* to = reinterpret_cast<Sample*>(out.data()) + (z * wanted[1] + y) * wanted[0];
        const Stored* row = from + z * steps[2] + y * steps[1];
        for (std::int64_t x = 0; x < count[0]; ++x) to[x] = value(row[x * steps[0]]);
      }
  };
  if (array_.type.half) return copy(std::uint16_t{}, float{}, [](std::uint16_t half) { return from_half(half); });
  shape::with_sample_type(array_.type.type, [&]<class T>(T) { copy(T{}, T{}, [](T sample) { return sample; }); });
}

}  // namespace quench::io
