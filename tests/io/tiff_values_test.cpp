// SPDX-License-Identifier: Apache-2.0
// Grey values of TIFF files that ImageJ calibrated.
#include <gtest/gtest.h>

#include "quench/io.h"
#include "tiff_fixture.h"
#ifdef QUENCH_TESTS_HAVE_TIFF

namespace quench {
namespace tiff_values_test {

using namespace testing_tiff;

class TiffValues : public Tiff {};

// ImageJ writes images of signed integers as unsigned ones with a line, and densities likewise.
TEST_F(TiffValues, GreyValuesAreThoseThatImageJCalibrated) {
  const auto file = [](const std::string& more, std::string bytes, TiffOptions o) {
    o.tags = imagej_tags("ImageJ=1.53t\n" + more + "\nvunit=Gray Value\n", 1000000);
    const auto pixels = static_cast<std::uint32_t>(8 * bytes.size() / o.bits);
    return tiff(pixels, 1, {std::move(bytes)}, o);
  };
  const std::string words("\0\0\0\x80\xff\xff", 6);  // 0, 32768, 65535
  EXPECT_EQ(samples<std::int16_t>(file("cf=0\nc0=-32768\nc1=1", words, {.bits = 16})),
            (std::vector<std::int16_t>{-32768, 0, 32767}));
  EXPECT_NE(notes.find("-32768 + 1 x the stored ones"), std::string::npos) << notes;
  EXPECT_EQ(samples<std::int32_t>(file("cf=0\nc0=5\nc1=-2", words, {.bits = 16})),
            (std::vector<std::int32_t>{5, -65531, -131065}));
  EXPECT_EQ(samples<float>(file("cf=0\nc0=10.5\nc1=0.25", "\1\x64\xff", {})),
            (std::vector<float>{10.75F, 35.5F, 74.25F}));
  EXPECT_EQ(samples<double>(file("cf=0\nc0=1e9\nc1=0.5", "\1", {})), (std::vector<double>{1000000000.5}));
  // As they are: no line, one that changes nothing, and what ImageJ does not calibrate.
  for (const char* none : {"", "cf=20\nc0=1\nc1=2", "cf=0", "cf=0\nc0=0\nc1=1"}) {
    EXPECT_EQ(samples<std::uint8_t>(file(none, "\1\2", {})), (std::vector<std::uint8_t>{1, 2})) << none;
    EXPECT_EQ(notes, "") << none;
  }
  EXPECT_EQ(samples<float>(file("cf=0\nc0=1\nc1=2", std::string("\0\0\x80\x3f", 4), {.bits = 32, .format = 3})),
            (std::vector<float>{1}));
  EXPECT_EQ(samples<std::int16_t>(file("cf=0\nc0=-32768\nc1=1", std::string("\5\0", 2), {.bits = 16, .format = 2})),
            (std::vector<std::int16_t>{5}));
  for (const char* other : {"cf=1\nc0=1\nc1=2\nc2=3", "cf=21", "cf=0\nc0=x\nc1=0"}) {
    EXPECT_EQ(samples<std::uint8_t>(file(other, "\1\2", {})), (std::vector<std::uint8_t>{1, 2})) << other;
    EXPECT_NE(notes.find("not a straight line"), std::string::npos) << notes;
  }
  EXPECT_EQ(samples<std::uint8_t>(file("cf=0\nc0=1\nc1=2", "\1", {.photometric = 0})),
            (std::vector<std::uint8_t>{254}));
  EXPECT_NE(notes.find("0 is white in it"), std::string::npos) << notes;
}

}  // namespace tiff_values_test
}  // namespace quench
#endif
