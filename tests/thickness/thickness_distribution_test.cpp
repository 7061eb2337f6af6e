// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "quench/samples.h"
#include "quench/thickness.h"
#include "quench/solid_stages.h"

namespace quench {
namespace thickness_distribution_test {

TEST(ThicknessDistribution, OfValues) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> value(1, 0.7);
  std::vector<double> values(5001);
  ThicknessDistribution all(0.5), first(0.5), second(0.5);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = value(random);
    all.add(values[i]);
    (i < 1700 ? first : second).add(values[i]);
  }
  first.add(second);
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean) / static_cast<double>(values.size());
  std::sort(values.begin(), values.end());
  for (const ThicknessDistribution& d : {all, first}) {
    EXPECT_EQ(d.weight(), 5001);
    EXPECT_NEAR(d.mean(), mean, 1e-12);
    EXPECT_NEAR(d.deviation(), std::sqrt(squares), 1e-12);
    EXPECT_EQ(d.least(), values.front());
    EXPECT_EQ(d.largest(), values.back());
    for (const double share : {0.01, 0.25, 0.5, 0.9, 0.99}) {
      const double expected = values[static_cast<std::size_t>(std::ceil(share * 5001)) - 1];
      EXPECT_NEAR(d.percentile(share), expected, expected / 8192);
    }
    EXPECT_EQ(d.percentile(0), values.front());
    EXPECT_EQ(d.percentile(1), values.back());
    double sum = 0;
    for (std::size_t b = 0; b < d.bins().size(); ++b) {
      const auto in = [&](double v) {
        return v >= 0.5 * static_cast<double>(b) && v < 0.5 * static_cast<double>(b + 1);
      };
      EXPECT_EQ(d.bins()[b], static_cast<double>(std::count_if(values.begin(), values.end(), in)));
      sum += d.bins()[b];
    }
    EXPECT_EQ(sum, 5001);
  }
  EXPECT_EQ(all.bins(), first.bins());
}

TEST(ThicknessDistribution, OfOneValueAndOfNone) {
  ThicknessDistribution d(1);
  EXPECT_EQ(d.mean(), 0);
  EXPECT_EQ(d.percentile(0.5), 0);
  for (int i = 0; i < 1000; ++i) d.add(std::sqrt(102.0), 0.1);
  d.add(std::nan(""));
  d.add(3, -1);
  EXPECT_NEAR(d.weight(), 100, 1e-9);
  EXPECT_EQ(d.mean(), std::sqrt(102.0));
  EXPECT_EQ(d.deviation(), 0);
  EXPECT_EQ(d.percentile(0.3), std::sqrt(102.0));
}

TEST(ThicknessDistribution, WidthsOfBins) {
  Grid grid;
  grid.spacing = {0.02, 0.03, 0.02};
  EXPECT_DOUBLE_EQ(automatic_bin_width(grid, 0.39), 0.002);
  EXPECT_DOUBLE_EQ(automatic_bin_width(grid, 0.41), 0.004);
  EXPECT_DOUBLE_EQ(automatic_bin_width(grid, 3.9), 0.02);
  EXPECT_DOUBLE_EQ(automatic_bin_width(grid, 0), 0.002);
}

TEST(ThicknessDistribution, Tables) {
  ThicknessDistribution d(0.5);
  for (const double v : {1.1, 1.2, 2.6}) d.add(v);
  const Table summary = pipeline::summary_of(d, {"mm", ""});
  EXPECT_EQ(summary.rows, 1u);
  EXPECT_EQ(std::get<std::vector<double>>(summary.find("count")->values)[0], 3);
  EXPECT_EQ(std::get<std::vector<double>>(summary.find("max")->values)[0], 2.6);
  EXPECT_EQ(summary.find("max")->unit, "mm");
  const Table histogram = pipeline::histogram_of(d, {});
  EXPECT_EQ(histogram.rows, 4u);
  EXPECT_EQ(std::get<std::vector<double>>(histogram.find("from")->values), (std::vector<double>{1, 1.5, 2, 2.5}));
  EXPECT_EQ(std::get<std::vector<double>>(histogram.find("count")->values), (std::vector<double>{2, 0, 0, 1}));
  EXPECT_EQ(std::get<std::vector<double>>(histogram.find("cumulative")->values).back(), 1);
}

TEST(SheetThickness, IsWeightedByArea) {
  MedialAxis axis;
  axis.points = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {5, 5, 5}, {6, 5, 5}, {5, 6, 5}};
  axis.radius = {1, 1, 1, 1, 3, 3, 3};
  const std::vector<std::uint32_t> offsets{0, 4, 7}, corners{0, 1, 2, 3, 4, 5, 6};
  axis.complex = make_complex(7, {}, offsets, corners);
  const ThicknessDistribution d = sheet_thickness(axis, 0.5);
  EXPECT_NEAR(d.weight(), 2.5, 1e-12);
  EXPECT_NEAR(d.mean(), (2 * 3 + 0.5 * 7) / 2.5, 1e-12);
  EXPECT_NEAR(d.percentile(0.9), 7, 7.0 / 8192);
}

}  // namespace thickness_distribution_test
}  // namespace quench
