// SPDX-License-Identifier: Apache-2.0
// Folders of TIFF slices: slices of one kind, their notes once, and the memory and the cancelling of the caller.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "temporary_folder.h"
#include "tiff_bytes.h"

#ifdef QUENCH_TESTS_HAVE_TIFF
namespace quench {
namespace tiff_folder_test {

using namespace testing_tiff;
using Dims = std::array<std::int64_t, 3>;

/// Whole or slice by slice.
void read(const TemporaryFolder& slices, bool whole, Context* context = nullptr,
          const io::VolumeReadOptions& options = {}) {
  if (whole) {
    io::read_volume(slices.path(), options, context);
    return;
  }
  const auto stream = io::open_slices(slices.path(), options, context);
  ASSERT_TRUE(stream);
  foreground(*stream, {.threshold = 1, .label = {}}, nullptr, context);
}

/// The sentence of a folder that cannot be read, the same both ways.
std::string refused(const TemporaryFolder& slices, ErrorCode code, Context* context = nullptr) {
  std::array<std::string, 2> sentences;
  for (const bool whole : {false, true}) try {
      read(slices, whole, context);
      ADD_FAILURE() << "was read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code) << e.what();
      sentences[whole] = e.what();
    }
  EXPECT_EQ(sentences[0], sentences[1]);
  return sentences[0];
}

TiffTag palette(std::uint32_t green) {
  std::vector<std::uint32_t> colours;
  for (const std::uint32_t factor : {1u, green, 1u})
    for (std::uint32_t i = 0; i < 256; ++i) colours.push_back(i * 0x40 * factor);
  return TiffBytes().shorts(320, colours);
}

TEST(TiffFolder, SlicesOfAFolder) {
  const TemporaryFolder slices;
  for (int z = 0; z < 12; ++z)
    slices.write(fmt::format("s{}.tif", z), tiff(2, 1, {std::string(2, static_cast<char>('a' + z))},
                                                 {.tags = imagej_tags("ImageJ=1\nunit=um\nspacing=3", 2000000)}));
  const Volume v = io::read_volume(slices.path());
  EXPECT_EQ(v.grid.dims, (Dims{2, 1, 12}));
  EXPECT_EQ(v.grid.spacing, Vec3(1, 1, 1));
  EXPECT_EQ(v.coordinates.units, "");
  for (std::size_t z = 0; z < 12; ++z) EXPECT_EQ(std::get<std::vector<std::uint8_t>>(v.samples)[2 * z], 'a' + z);
  const auto opened = io::open_slices(slices.path(), {.spacing = Vec3(1, 1, 4)});
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->grid.spacing, Vec3(1, 1, 4));
  EXPECT_EQ(foreground(*opened, {.threshold = 'c', .label = {}}).voxel_count(), 20);
  for (const std::string& other : {tiff(1, 2, {"ab"}), tiff(2, 1, {"abcd"}, {.bits = 16}), tiff(2, 1, {"ab", "cd"})}) {
    slices.write("s3.tif", other);
    for (const bool whole : {false, true}) try {
        if (whole)
          io::read_volume(slices.path());
        else
          foreground(*io::open_slices(slices.path()), {.threshold = 'c', .label = {}});
        ADD_FAILURE() << "another slice was taken";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("s3.tif"), std::string::npos) << e.what();
      }
  }
}

// A palette of greys gives greys, one of colours indices: not of one stack.
TEST(TiffFolder, SlicesWithAndWithoutColoursAreNotMixed) {
  const std::string grey = tiff(2, 1, {"ab"}), greys = tiff(2, 1, {"ab"}, {.photometric = 3, .tags = {palette(1)}}),
                    colours = tiff(2, 1, {"ab"}, {.photometric = 3, .tags = {palette(2)}});
  for (const auto& [first, second] : {std::pair(grey, colours), {colours, grey}, {greys, colours}, {colours, greys}}) {
    const TemporaryFolder slices;
    slices.write("s1.tif", first);
    slices.write("s2.tif", second);
    const std::string sentence = refused(slices, ErrorCode::input);
    EXPECT_NE(sentence.find("s2.tif"), std::string::npos) << sentence;
    EXPECT_NE(sentence.find("palette of colours"), std::string::npos) << sentence;
  }
  for (const auto& [first, second] : {std::pair(grey, greys), {colours, colours}}) {
    const TemporaryFolder slices;
    slices.write("s1.tif", first);
    slices.write("s2.tif", second);
    for (const bool whole : {false, true}) read(slices, whole);
  }
}

TEST(TiffFolder, NotesAreSaidOnce) {
  const TemporaryFolder slices;
  for (int z = 0; z < 5; ++z)
    slices.write(fmt::format("s{}.tif", z),
                 tiff(2, 1, {"ab"},
                      {.photometric = z < 2 ? 1u : 0u,
                       .tags = {TiffBytes().rational(282, 100 + static_cast<std::uint32_t>(z), 1),
                                TiffBytes().rational(283, 100, 1)}}));
  for (const bool whole : {false, true})
    for (const bool spacing_is_given : {false, true}) {
      std::vector<std::string> notes;
      Context context;
      context.note = [&](const std::string& sentence) { notes.push_back(sentence); };
      io::VolumeReadOptions options;
      if (spacing_is_given) options.spacing = Vec3(1, 1, 1);
      read(slices, whole, &context, options);
      ASSERT_EQ(notes.size(), spacing_is_given ? 1u : 2u);
      EXPECT_NE(notes.back().find("s2.tif' says that 0 is white"), std::string::npos) << notes.back();
      EXPECT_EQ(notes[0].find("no distance of slices") != std::string::npos, !spacing_is_given) << notes[0];
    }
}

TEST(TiffFolder, LimitsAndCancelReachTheSlices) {
  const TemporaryFolder slices;
  for (int z = 0; z < 2; ++z) slices.write(fmt::format("s{}.tif", z), tiff(200, 100, {std::string(20000, 'a')}));
  Context small;
  small.memory_limit = 10000;
  const std::string sentence = refused(slices, ErrorCode::failed, &small);
  EXPECT_NE(sentence.find("s0.tif' needs about"), std::string::npos) << sentence;
  slices.write("s0.tif", "no TIFF");  // what is seen first
  Context cancelled;
  cancelled.cancel();
  refused(slices, ErrorCode::cancelled, &cancelled);
}

TEST(TiffFolder, PipesAreRefused) {
  for (const char* name : {"s1.tif", "s1.png"}) {
    const TemporaryFolder slices;
    ASSERT_EQ(mkfifo((slices / name).c_str(), 0600), 0);
    EXPECT_NE(refused(slices, ErrorCode::input).find("is not a regular file"), std::string::npos);
  }
}

}  // namespace tiff_folder_test
}  // namespace quench
#endif
