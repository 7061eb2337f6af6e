// SPDX-License-Identifier: Apache-2.0
// Zarr and N5: random shapes come back, damage is refused, and what is not there costs nothing. Forms and types are
// those of volume_formats.py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "random_shapes.h"
#include "small_zarr.h"
#include "temporary_folder.h"

namespace quench {
namespace zarr_test {

using small_files::SmallZarr;
using small_files::ZarrKind;

constexpr std::array all_kinds{ZarrKind::zarr2, ZarrKind::zarr3, ZarrKind::shards, ZarrKind::n5};

/// Grey values, many of which are 0.
std::vector<std::uint16_t> random_samples(std::int64_t count, std::mt19937& random) {
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(count), 0);
  for (auto& sample : samples)
    if (random() % 3 == 0) sample = static_cast<std::uint16_t>(random());
  samples.back() = 0x5A5A;
  return samples;
}

std::string sentence_of(const std::filesystem::path& file, Context* context = nullptr) {
  try {
    const auto slices = io::open_slices(file, {.spacing = {}, .dimension = 3}, context);
    std::vector<std::byte> slice(static_cast<std::size_t>(slices->grid.dims[0] * slices->grid.dims[1]) * 8);
    for (std::int64_t z = 0; z < slices->grid.dims[2]; ++z) slices->next(slice);
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return {};
}

TEST(Zarr, RandomVolumesComeBack) {
  std::mt19937 random(29);
  const TemporaryFolder folder;
  for (int round = 0; round < 60; ++round) {
    std::array<std::int64_t, 3> dims{}, chunk{};
    for (auto& side : dims) side = 2 + static_cast<std::int64_t>(random() % 9);
    for (auto& side : chunk) side = 1 + static_cast<std::int64_t>(random() % 6);
    auto samples = random_samples(dims[0] * dims[1] * dims[2], random);
    // A chunk, and more, without anything.
    for (std::size_t i = 0; i < samples.size() / 2; ++i) samples[i] = 0;
    for (const ZarrKind kind : all_kinds) {
      const auto file = folder / fmt::format("{}_{}.zarr", round, static_cast<int>(kind));
      const SmallZarr array = small_files::small_zarr(kind, dims, chunk, samples);
      array.write(file);
      EXPECT_EQ(io::kind_of(file), io::Kind::volume);
      const Volume volume = io::read_volume(file);
      EXPECT_EQ(volume.grid.dims, dims);
      EXPECT_EQ(std::get<std::vector<std::uint16_t>>(volume.samples), samples);
      const auto slices = io::open_slices(file);
      ASSERT_TRUE(slices);
      const ForegroundOptions options{.threshold = 20000.0, .label = {}};
      EXPECT_TRUE(std::ranges::equal(foreground(*slices, options).runs(), foreground(volume, options).runs()));
    }
  }
}

/// Every byte of the metadata and of the first chunk is changed, and both end at every byte.
TEST(Zarr, DamageIsRefusedOrReadRight) {
  std::mt19937 random(30);
  const std::vector<std::uint16_t> samples = random_samples(3 * 3 * 3, random);
  const TemporaryFolder folder;
  for (const ZarrKind kind : all_kinds) {
    const SmallZarr whole = small_files::small_zarr(kind, {3, 3, 3}, {2, 2, 2}, samples);
    const auto file = folder / fmt::format("{}.zarr", static_cast<int>(kind));
    whole.write(file);
    ASSERT_EQ(sentence_of(file), "");
    for (const bool of_chunk : {false, true}) {
      const auto part = file / (of_chunk ? whole.chunks.front().first : whole.metadata_name);
      const std::string& bytes = of_chunk ? whole.chunks.front().second : whole.metadata;
      for (std::size_t at = 0; at < bytes.size(); ++at) {
        SmallZarr::put(part, bytes.substr(0, at));
        EXPECT_NE(sentence_of(file), "") << part << " of " << at << " bytes";
        for (const int change : {1, 0x80}) {
          std::string changed = bytes;
          changed[at] = static_cast<char>(changed[at] ^ change);
          SmallZarr::put(part, changed);
          Context context;
          context.memory_limit = 1 << 24;
          const std::string sentence = sentence_of(file, &context);
          if (sentence.empty() && of_chunk) {
            EXPECT_EQ(std::get<std::vector<std::uint16_t>>(io::read_volume(file).samples), samples) << at;
          }
        }
      }
      SmallZarr::put(part, bytes);
    }
  }
}

// A chunk that unpacks to more, or to less, than its number of samples is damaged; neither takes more memory.
TEST(Zarr, AChunkHasItsNumberOfSamples) {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> samples(8, 7);
  for (const ZarrKind kind : {ZarrKind::zarr2, ZarrKind::zarr3, ZarrKind::n5})
    for (const std::size_t size : {0UL, 15UL, 17UL, 32UL, std::size_t{1} << 24}) {
      SmallZarr array = small_files::small_zarr(kind, {2, 2, 2}, {2, 2, 2}, samples);
      const bool n5 = kind == ZarrKind::n5;
      array.chunks[0].second = array.chunks[0].second.substr(0, n5 ? 16 : 0) +
                               small_files::deflated(std::string(size, '\1'), 15 + (n5 ? 16 : 0));
      const auto file = folder / fmt::format("{}_{}.zarr", static_cast<int>(kind), size);
      array.write(file);
      EXPECT_NE(sentence_of(file).find("does not unpack to its number of samples"), std::string::npos);
    }
}

TEST(Zarr, AShardPointsIntoItself) {
  const TemporaryFolder folder;
  const SmallZarr whole =
      small_files::small_zarr(ZarrKind::shards, {2, 2, 2}, {1, 2, 2}, std::vector<std::uint16_t>(8, 7));
  const std::string& shard = whole.chunks[0].second;
  const std::size_t index = shard.size() - 4 - 8 * 16;
  for (const std::uint64_t begin : {std::uint64_t{0}, std::uint64_t{shard.size()}, ~std::uint64_t{0}})
    for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{shard.size()} + 1, ~std::uint64_t{0} - 1}) {
      SmallZarr changed = whole;
      std::string table = shard.substr(index, 8 * 16);
      table.replace(0, 16, small_files::number(begin, 8) + small_files::number(size, 8));
      changed.chunks[0].second = shard.substr(0, index) + table + small_files::crc32c_bytes(table);
      changed.write(folder / "v.zarr");
      EXPECT_NE(sentence_of(folder / "v.zarr").find("points out of it"), std::string::npos) << begin << ' ' << size;
    }
  SmallZarr changed = whole;
  changed.chunks[0].second[index] ^= 1;
  changed.write(folder / "v.zarr");
  EXPECT_NE(sentence_of(folder / "v.zarr").find("checksum"), std::string::npos);
}

// 64 MB of samples, of which few chunks are there: nothing is held but a slice and a layer of those.
TEST(Zarr, MemoryIsThatOfASliceAndALayerOfChunks) {
  const TemporaryFolder folder;
  SmallZarr array = small_files::small_zarr(ZarrKind::zarr2, {2000, 20, 8}, {8, 8, 8}, [] {
    std::vector<std::uint16_t> samples(2000 * 20 * 8, 0);
    for (std::size_t i = 0; i < samples.size(); i += 2000) samples[i] = 1;
    return samples;
  }());
  array.metadata.replace(array.metadata.find("[8, 20, 2000]"), 13, "[800, 20, 2000]");
  array.write(folder / "v.zarr");
  Context context;
  context.memory_limit = 1 << 18;
  const auto slices = io::open_slices(folder / "v.zarr", {}, &context);
  EXPECT_EQ(foreground(*slices, {.threshold = 1.0, .label = {}}).voxel_count(), 20 * 8);
  context.memory_limit = 1 << 17;
  EXPECT_NE(sentence_of(folder / "v.zarr", &context).find("memory"), std::string::npos);
}

TEST(Zarr, AChunkThatCannotBeOpenedIsNotTakenForAMissingOne) {
  const TemporaryFolder folder;
  const SmallZarr array =
      small_files::small_zarr(ZarrKind::zarr2, {2, 2, 2}, {2, 2, 2}, std::vector<std::uint16_t>(8, 7));
  array.write(folder / "v.zarr");
  std::filesystem::remove(folder / "v.zarr/0.0.0");
  EXPECT_EQ(sentence_of(folder / "v.zarr"), "");
  std::filesystem::create_symlink("nowhere", folder / "v.zarr/0.0.0");
  EXPECT_NE(sentence_of(folder / "v.zarr").find("cannot be read"), std::string::npos);
  std::filesystem::remove(folder / "v.zarr/0.0.0");
  std::filesystem::create_directory(folder / "v.zarr/0.0.0");
  EXPECT_NE(sentence_of(folder / "v.zarr").find("not a regular file"), std::string::npos);
}

TEST(Zarr, NamesBehindAColon) {
  const TemporaryFolder folder;
  SmallZarr array = small_files::small_zarr(ZarrKind::zarr2, {2, 2, 2}, {2, 2, 2}, std::vector<std::uint16_t>(8, 7));
  array.metadata.replace(array.metadata.find("[2, 2, 2]"), 9, "[2, 2, 2, 2]");
  array.metadata.replace(array.metadata.find("[2, 2, 2],"), 9, "[1, 2, 2, 2]");
  array.chunks[0].first = "1.0.0.0";
  array.write(folder / "v.zarr");
  EXPECT_NE(sentence_of(folder / "v.zarr").find("add :c=N to its name, with N from 0 to 1"), std::string::npos);
  const auto sum = [&](const char* name) {
    const Volume volume = io::read_volume(folder / name);
    const auto& samples = std::get<std::vector<std::uint16_t>>(volume.samples);
    return std::accumulate(samples.begin(), samples.end(), 0);
  };
  EXPECT_EQ(io::kind_of(folder / "v.zarr:c=0"), io::Kind::volume);
  EXPECT_EQ(io::place_of_input(folder / "v.zarr:c=0"), folder / "v.zarr");
  EXPECT_EQ(io::place_of_input(folder / "w.zarr:c=0"), folder / "w.zarr:c=0");
  EXPECT_EQ(sum("v.zarr:c=0"), 0);
  EXPECT_EQ(sum("v.zarr:c=1"), 56);
  EXPECT_NE(sentence_of(folder / "v.zarr:c=2").find("goes from 0 to 1"), std::string::npos);
  EXPECT_NE(sentence_of(folder / "v.zarr:q").find("colon"), std::string::npos);
}

}  // namespace zarr_test
}  // namespace quench
