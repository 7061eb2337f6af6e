// SPDX-License-Identifier: Apache-2.0
// The names of the slices in a folder: numbered slices are complete, in their order, and alone; free names are not
// checked.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "small_files.h"
#include "temporary_folder.h"

namespace quench {
namespace slice_folder_test {

using Names = std::vector<std::string>;

/// Slices of one pixel, which has the place of the name in the list as its value.
void write(const TemporaryFolder& slices, const Names& names) {
  for (std::size_t i = 0; i < names.size(); ++i)
    slices.write(names[i], small_files::png(1, 1, 8, 0, false, std::string(1, '\0') + static_cast<char>(i)));
}

/// What the slices are read as; they are given in the order they should have.
void expect_read(const Names& names) {
  const TemporaryFolder slices;
  write(slices, names);
  std::vector<std::uint8_t> in_order;
  for (std::size_t i = 0; i < names.size(); ++i) in_order.push_back(static_cast<std::uint8_t>(i));
  EXPECT_EQ(
      std::get<std::vector<std::uint8_t>>(io::read_volume(slices.path(), {.spacing = {}, .dimension = 3}).samples),
      in_order)
      << names.front();
  EXPECT_EQ(io::open_slices(slices.path(), {.spacing = {}, .dimension = 3})->grid.dims[2],
            static_cast<std::int64_t>(names.size()));
}

/// The sentence of a folder that cannot be read, the same whole and slice by slice, with the name of the folder left
/// out.
std::string refused(const Names& names) {
  const TemporaryFolder slices;
  write(slices, names);
  std::array<std::string, 2> sentences;
  for (const bool whole : {false, true}) try {
      if (whole)
        io::read_volume(slices.path());
      else
        io::open_slices(slices.path());
      ADD_FAILURE() << names.front() << " was read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::input) << e.what();
      sentences[whole] = e.what();
    }
  EXPECT_EQ(sentences[0], sentences[1]);
  const auto at = sentences[0].find(slices.path().string());
  EXPECT_NE(at, std::string::npos) << sentences[0];
  return at == std::string::npos ? sentences[0] : sentences[0].replace(at, slices.path().string().size(), "F");
}

/// Of the numbers from `first` to `last` but one.
Names numbered(int first, int last, int but, int step = 1, const char* pattern = "img_{:04}.png") {
  Names names;
  for (int i = first; i <= last; i += step)
    if (i != but) names.push_back(fmt::format(fmt::runtime(pattern), i));
  return names;
}

Names with(Names names, const Names& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

TEST(SliceFolder, AMissingSliceIsNamed) {
  EXPECT_EQ(refused(numbered(0, 11, 6)),
            "the slices in 'F' are numbered 0 to 11 and number 6 is missing; restore it, or renumber the slices");
  EXPECT_EQ(refused(numbered(10, 100, 30, 10, "{}.png")),
            "the slices in 'F' are numbered 10 to 100 in steps of 10 and number 30 is missing; restore it, or renumber "
            "the slices");
  EXPECT_NE(refused({"a2_1.png", "a2_2.png", "a2_5.png"}).find("number 3 is missing"), std::string::npos);
  EXPECT_NE(refused({"0.png", "2.png", "5.png"}).find("number 4 is missing"), std::string::npos);
  EXPECT_NE(refused({"s99.png", "s0101.png", "s102.png"}).find("number 100 is missing"), std::string::npos);
}

TEST(SliceFolder, ANumberThatIsThereTwiceIsNamed) {
  EXPECT_EQ(refused(with(numbered(0, 11, -1), {"img_6.png"})),
            "the slices in 'F' are numbered, and number 6 occurs twice, as 'img_0006.png' and 'img_6.png'; move one of "
            "them out of the folder, or renumber the slices");
  EXPECT_NE(refused({"s00.png", "s0.png"}).find("number 0 occurs twice"), std::string::npos);
  EXPECT_NE(refused({"s1.png", "s2.png", "s2.PNG"}).find("number 2 occurs twice"), std::string::npos);
}

TEST(SliceFolder, AFileThatIsNotNumberedAsTheOthersIsNamed) {
  EXPECT_EQ(
      refused(with(numbered(0, 11, -1), {"preview.png"})),
      "'F/preview.png' is not numbered as the other slices ('img_0000.png' to 'img_0011.png'); move it out of the "
      "folder, or rename it where it is one of them");
  for (const char* other :
       {"img_0006 (1).png", "Img_0012.png", "img_0003_0004.png", "7.png", "img_1234567890123456789.png", "a.png"})
    EXPECT_NE(refused(with(numbered(0, 11, -1), {other})).find(other), std::string::npos);
  EXPECT_NE(refused({"a1_1.png", "a1_2.png", "a1_3.png", "a2_1.png"}).find("a2_1"), std::string::npos);
  EXPECT_NE(refused(with(numbered(0, 11, 6), {"preview.png"})).find("preview"), std::string::npos);
}

TEST(SliceFolder, CompleteNumbersAreRead) {
  expect_read(numbered(0, 11, -1));
  expect_read(numbered(7, 120, -1, 1, "slice{}.png"));
  expect_read(numbered(5, 105, -1, 20, "2024-03-01 scan {} of 7.png"));
  expect_read({"s98.png", "s099.png", "s0100.PNG"});
  expect_read({"3.png"});
  expect_read({"a1.png", "a9.png"});
  expect_read({"1.2.840.1234567890123456789012.1.png", "1.2.840.1234567890123456789012.2.png"});
}

TEST(SliceFolder, FreeNamesAreNotChecked) {
  expect_read({"bottom.png", "middle.png", "top.png"});
  expect_read({"a.png", "a1.png", "a3.png", "b.png"});  // two are not a rule
  expect_read({"x1_t100.png", "x2_t103.png", "x4_t109.png"});
  expect_read({"a1.png", "a2.png", "a3.png", "b1.png", "b2.png", "b3.png"});
  expect_read({"1234567890123456789.png", "1234567890123456791.png", "1234567890123456792.png"});
}

}  // namespace slice_folder_test
}  // namespace quench
