// SPDX-License-Identifier: Apache-2.0
// The threshold that is proposed for an image of many values.
#include <gtest/gtest.h>

#include <limits>

#include "quench/pipeline.h"

namespace quench::pipeline {
namespace threshold_proposal_test {

/// An image of `side` x `side` pixels; `value(x, y)` may be below, in or above a square in its middle.
template <class T, class Value>
Volume image_of(int side, const Value& value) {
  Volume image;
  image.grid.dims = {side, side, 1};
  image.grid.make_plane();
  std::vector<T> samples;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const bool inside = x > 2 && y > 2 && x < side - 3 && y < side - 3;
      samples.push_back(value(x + y, inside));
    }
  image.samples = std::move(samples);
  return image;
}

TEST(ThresholdProposal, IsBetweenDarkAndBright) {
  for (const bool dark_shape : {false, true}) {
    const auto image = image_of<std::uint8_t>(
        12, [&](int i, bool inside) { return static_cast<std::uint8_t>((inside == dark_shape ? 20 : 220) + i % 5); });
    const auto proposal = propose_threshold(image);
    ASSERT_TRUE(proposal);
    EXPECT_EQ(proposal->low, 20);
    EXPECT_EQ(proposal->high, 224);
    EXPECT_EQ(std::get<std::int64_t>(proposal->threshold), 122);  // in the middle of 24 and 220
    EXPECT_EQ(proposal->bright_border, dark_shape);
    ForegroundOptions options;
    options.threshold = proposal->threshold;
    options.invert = dark_shape;
    EXPECT_EQ(foreground(image, options).voxel_count(), 36);
  }
}

TEST(ThresholdProposal, TakesWideAndNegativeValuesAndNoNumbers) {
  const auto wide = propose_threshold(
      image_of<std::int32_t>(12, [](int i, bool inside) { return inside ? 2000000000 - i : -2000000000 + i; }));
  ASSERT_TRUE(wide);
  EXPECT_NEAR(static_cast<double>(std::get<std::int64_t>(wide->threshold)), 0, 2e7);
  const auto real = propose_threshold(image_of<float>(12, [](int i, bool inside) {
    if (i == 0) return std::numeric_limits<float>::quiet_NaN();
    if (i == 1) return std::numeric_limits<float>::infinity();
    return (inside ? 1.0f : -1.0f) + 0.001f * static_cast<float>(i);
  }));
  ASSERT_TRUE(real);
  EXPECT_NEAR(std::get<double>(real->threshold), 0, 0.05);
  EXPECT_FALSE(real->bright_border);
}

TEST(ThresholdProposal, TwoValuesNeedNone) {
  EXPECT_FALSE(propose_threshold(image_of<std::uint8_t>(9, [](int, bool inside) -> std::uint8_t { return inside; })));
  EXPECT_FALSE(propose_threshold(image_of<double>(9, [](int, bool) { return std::nan(""); })));
}

}  // namespace threshold_proposal_test
}  // namespace quench::pipeline
