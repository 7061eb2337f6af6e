// SPDX-License-Identifier: Apache-2.0
// Volumes read slice by slice give the shape that volumes read whole give.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <random>

#include "data.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "random_shapes.h"
#include "small_files.h"
#include "temporary_folder.h"

namespace quench {
namespace slices_test {

std::string gzipped(const std::string& data) { return small_files::deflated(data, 15 + 16); }

// 5 x 4 x 3 samples of two bytes, most of them different.
std::string samples(bool big_endian) {
  std::string bytes;
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    const auto v = static_cast<std::uint16_t>(random() % 1000);
    const char low = static_cast<char>(v & 255), high = static_cast<char>(v >> 8);
    bytes += big_endian ? std::string{high, low} : std::string{low, high};
  }
  return bytes;
}

std::string header(const std::string& encoding, bool big_endian) {
  return fmt::format(
      "NRRD0004\n# a comment\ntype: unsigned short\ndimension: 3\nspace dimension: 3\nsizes: 5 4 3\nspace directions: "
      "(0.5,0,0) (0,2,0) (0,0,1)\nspace origin: (1,2,3)\nendian: {}\nencoding: {}\n\n",
      big_endian ? "big" : "little", encoding);
}

void expect_same(const VoxelShape& a, const VoxelShape& b) {
  EXPECT_EQ(a.grid().dims, b.grid().dims);
  EXPECT_EQ(a.grid().spacing, b.grid().spacing);
  EXPECT_EQ(a.grid().origin, b.grid().origin);
  EXPECT_EQ(a.grid().direction, b.grid().direction);
  ASSERT_EQ(a.voxel_count(), b.voxel_count());
  for (std::int64_t z = 0; z < a.grid().dims[2]; ++z)
    for (std::int64_t y = 0; y < a.grid().dims[1]; ++y)
      ASSERT_TRUE(std::ranges::equal(a.row(y, z), b.row(y, z),
                                     [](const Run& p, const Run& q) { return p.begin == q.begin && p.end == q.end; }));
}

void expect_as_whole(const std::filesystem::path& file, const ForegroundOptions& options) {
  const auto slices = io::open_slices(file);
  ASSERT_TRUE(slices) << file << " is not read in slices";
  expect_same(foreground(*slices, options), foreground(io::read_volume(file), options));
}

TEST(Slices, NrrdOfEitherEncodingAndByteOrder) {
  const TemporaryFolder folder;
  for (const bool big : {false, true}) {
    const auto raw = folder.write("raw.nrrd", header("raw", big) + samples(big));
    const auto gzip = folder.write("gzip.nrrd", header("gzip", big) + gzipped(samples(big)));
    const std::string all = samples(big);  // gzip files may be several, one after the other
    const auto two =
        folder.write("two.nrrd", header("gzip", big) + gzipped(all.substr(0, 33)) + gzipped(all.substr(33)));
    for (const auto& file : {raw, gzip, two})
      for (const double threshold : {1.0, 300.0, 900.0}) expect_as_whole(file, {.threshold = threshold, .label = {}});
    expect_as_whole(raw, {.threshold = 500, .label = {}, .invert = true});
  }
}

TEST(Slices, DetachedAndTextSamples) {
  const TemporaryFolder folder;
  folder.write("data.raw", samples(false));
  std::string text = header("raw", false);
  text.insert(text.find("encoding"), "data file: data.raw\n");
  expect_as_whole(folder.write("detached.nrrd", text), {.threshold = 300., .label = {}});
  text = header("ascii", false);
  for (int i = 0; i < 60; ++i) text += std::to_string(i * 17 % 1000) + (i % 7 ? " " : "\n");
  expect_as_whole(folder.write("ascii.nrrd", text), {.threshold = 300., .label = {}});
  EXPECT_FALSE(io::open_slices(folder.write("text.npy", "x")));  // read whole
}

TEST(Slices, MetaImageAndMrc) {
  const TemporaryFolder folder;
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nElementSpacing = 0.5 2 1\n"
      "DimSize = 5 4 3\nElementType = MET_USHORT\nElementDataFile = LOCAL\n";
  expect_as_whole(folder.write("a.mha", meta + samples(false)), {.threshold = 300, .label = {}});
  REQUIRE_DATA("volumes/emd_5625.map");
  expect_as_whole(data_file("volumes/emd_5625.map"), {.threshold = 1.991, .label = {}});
}

// Streams look at many samples at once where they are alike.
TEST(Slices, LongAndShortStretchesOfAnyType) {
  std::mt19937 random(11);
  for (int round = 0; round < 400; ++round) {
    Volume volume;
    volume.grid.dims = {1 + static_cast<std::int64_t>(random() % 300), 2, 2};
    const auto count = static_cast<std::size_t>(volume.grid.dims[0] * 4);
    const auto fill = [&]<class T>(std::vector<T> samples) {
      T value{};
      for (std::size_t i = 0; i < count; ++i) {
        if (random() % 40 == 0) value = static_cast<T>(static_cast<int>(random() % 5) - (std::is_signed_v<T> ? 2 : 0));
        if (std::is_floating_point_v<T> && random() % 200 == 0) value = std::numeric_limits<T>::quiet_NaN();
        samples.push_back(value);
      }
      samples[random() % count] = 3;
      volume.samples = std::move(samples);
    };
    switch (round % 5) {
      case 0:
        fill(std::vector<std::uint8_t>());
        break;
      case 1:
        fill(std::vector<std::int16_t>());
        break;
      case 2:
        fill(std::vector<std::uint64_t>());
        break;
      case 3:
        fill(std::vector<float>());
        break;
      default:
        fill(std::vector<double>());
    }
    const auto outcome = [&](const ForegroundOptions& options, bool stream) -> std::string {
      SliceStream slices;
      slices.grid = volume.grid;
      slices.type = view_of(volume).type;
      slices.next = [&volume, at = std::size_t{0}](std::span<std::byte> slice) mutable {
        std::memcpy(slice.data(), static_cast<const std::byte*>(view_of(volume).data) + at, slice.size());
        at += slice.size();
      };
      try {
        const VoxelShape shape = stream ? foreground(slices, options) : foreground(volume, options);
        std::string text;
        for (std::int64_t row = 0; row < 4; ++row) {
          for (const quench::Run& run : shape.row(row % 2, row / 2)) text += fmt::format("{}-{} ", run.begin, run.end);
          text += '\n';
        }
        return text;
      } catch (const Error& error) {
        return error.what();
      }
    };
    for (const bool invert : {false, true})
      for (const ForegroundOptions& options : {ForegroundOptions{.threshold = {}, .label = {}, .invert = invert},
                                               ForegroundOptions{.threshold = 1.0, .label = {}, .invert = invert},
                                               ForegroundOptions{.threshold = -7.0, .label = {}, .invert = invert},
                                               ForegroundOptions{.threshold = {}, .label = 2, .invert = invert},
                                               ForegroundOptions{.threshold = {}, .label = 300, .invert = invert}})
        ASSERT_EQ(outcome(options, true), outcome(options, false)) << round;
    const ForegroundOptions two{.threshold = 1.0, .label = {}, .seed_threshold = 3.0};
    ASSERT_EQ(outcome(two, true), outcome(two, false)) << round;
  }
}

TEST(Slices, RealAndWrittenVolumes) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9);
    io::write_volume(folder.path() / "shape.nrrd", shape);
    expect_as_whole(folder.path() / "shape.nrrd", {});
  }
  REQUIRE_DATA("volumes/maize_root_ct.nrrd");
  expect_as_whole(data_file("volumes/maize_root_ct.nrrd"), {.threshold = 20, .label = {}});
}

// Whatever is wrong is one sentence, and the same as for a whole volume where both can tell.
TEST(Slices, EveryTruncationIsRefused) {
  const TemporaryFolder folder;
  for (const char* encoding : {"raw", "gzip"}) {
    const std::string body = std::string(encoding) == "raw" ? samples(false) : gzipped(samples(false));
    for (std::size_t kept = 0; kept + 12 < body.size();
         ++kept) {  // without its last bytes a gzip file holds all samples
      const auto file = folder.write("t.nrrd", header(encoding, false) + body.substr(0, kept));
      const auto read = [&] {
        const auto slices = io::open_slices(file);
        return slices ? foreground(*slices, {.threshold = 1, .label = {}}) : VoxelShape();
      };
      try {
        read();
        ADD_FAILURE() << encoding << ": " << kept << " bytes were enough";
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::input);
        EXPECT_NE(std::string(e.what()).find("t.nrrd"), std::string::npos) << e.what();
      }
    }
  }
}

TEST(Slices, SentencesAreThoseOfWholeVolumes) {
  const TemporaryFolder folder;
  const auto file = folder.write("v.nrrd", header("raw", false) + samples(false));
  for (const ForegroundOptions& options : {ForegroundOptions{}, ForegroundOptions{.threshold = 2000, .label = {}},
                                           ForegroundOptions{.threshold = {}, .label = 100000}}) {
    const auto sentence = [&](const auto& get) {
      try {
        get();
      } catch (const Error& e) {
        return fmt::format("{} {}", static_cast<int>(e.code()), e.what());
      }
      return std::string("no complaint");
    };
    EXPECT_EQ(sentence([&] { return foreground(*io::open_slices(file), options); }),
              sentence([&] { return foreground(io::read_volume(file), options); }));
  }
}

}  // namespace slices_test
}  // namespace quench
