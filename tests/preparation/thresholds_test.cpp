// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "quench/preparation.h"

namespace quench {
namespace thresholds_test {

double value_of(const ProposedThreshold& proposal) {
  return std::visit([](auto t) { return static_cast<double>(t); }, proposal.value);
}

constexpr int kSide = 44;

/// How much of every voxel some tubes of one radius fill.
std::vector<float> shares_of_tubes(double radius) {
  std::mt19937 random(static_cast<unsigned>(10 * radius));
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(0.2 * kSide, 0.8 * kSide);
  std::vector<Vec3> from, along;
  for (int i = 0; i < 4; ++i) {
    from.emplace_back(place(random), place(random), place(random));
    along.push_back(Vec3(normal(random), normal(random), normal(random)).normalized());
  }
  constexpr int kParts = 3;
  std::vector<float> shares;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        int inside = 0;
        for (int part = 0; part < kParts * kParts * kParts; ++part) {
          const Vec3 in(part % kParts + 0.5, part / kParts % kParts + 0.5, part / kParts / kParts + 0.5);
          const Vec3 p = Vec3(x, y, z) + in / kParts;
          for (std::size_t i = 0; i < from.size(); ++i)
            if ((p - from[i]).cross(along[i]).squaredNorm() < radius * radius) {
              ++inside;
              break;
            }
        }
        shares.push_back(static_cast<float>(inside) / (kParts * kParts * kParts));
      }
  return shares;
}

/// Tubes of one radius in a dark volume, with partial volume, blurred and noisy.
struct Tubes {
  Volume volume;      ///< of 50 beside and 150 inside
  Volume clean;       ///< without noise
  double inside = 0;  ///< volume of the tubes, in voxels

  Tubes(unsigned seed, double radius, double blur, double noise, bool stone) {
    static std::map<double, std::vector<float>> known;
    std::vector<float>& shares = known[radius];
    if (shares.empty()) shares = shares_of_tubes(radius);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<float> values;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const float share = shares[static_cast<std::size_t>(i)];
      const Vec3 p(i % kSide, i / kSide % kSide, i / kSide / kSide);
      values.push_back(stone && (p - Vec3(9, 9, 9)).norm() < 3 ? 250.0f : 50 + 100 * share);
      inside += share;
    }
    volume.grid.dims = {kSide, kSide, kSide};
    volume.samples = values;
    ForegroundOptions grey;
    grey.threshold = 1.0;
    clean = prepared(Volume(volume), {.blur = blur}, grey);
    std::vector<std::uint8_t> samples;
    for (const float v : std::get<std::vector<float>>(clean.samples))
      samples.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(v + noise * normal(random)), 0l, 255l)));
    volume.samples = std::move(samples);
  }
  /// The radius that a threshold gives, as a part of the true one.
  double radius_at(double threshold) const {
    const auto& values = std::get<std::vector<float>>(clean.samples);
    const auto found = std::ranges::count_if(values, [&](float v) { return v >= threshold - 0.5; });
    return std::sqrt(static_cast<double>(found) / inside);
  }
};

TEST(Thresholds, OfEdgesGivesTheRadiusOfTubesBack) {
  double sum = 0, sum_of_otsu = 0;
  int count = 0;
  for (const double radius : {1.5, 2.5, 4.0})
    for (const double blur : {0.4, 0.8})
      for (const double noise : {0.0, 2.0, 6.0, 10.0})
        for (const bool stone : {false, true}) {
          if (stone && noise > 6) continue;
          const Tubes tubes(static_cast<unsigned>(count) + 1, radius, blur, noise, stone);
          const auto proposals = proposed_thresholds(tubes.volume);
          ASSERT_GE(proposals.size(), 2u);
          EXPECT_EQ(proposals[0].rule, "edges");
          EXPECT_EQ(proposals[1].rule, "otsu");
          const double found = tubes.radius_at(value_of(proposals[0]));
          EXPECT_NEAR(found, 1, 0.15) << radius << ' ' << blur << ' ' << noise << ' ' << stone;
          sum += std::abs(found - 1);
          sum_of_otsu += std::abs(tubes.radius_at(value_of(proposals[1])) - 1);
          ++count;
        }
  EXPECT_LT(sum / count, 0.04);
  EXPECT_LT(sum, sum_of_otsu);
}

TEST(Thresholds, OfRootsIsOfferedWhereOtsuDrowns) {
  // One thin tube in much noise: Otsu's method parts the noise.
  const Tubes tubes(5, 1, 0.4, 10, false);
  const auto proposals = proposed_thresholds(tubes.volume);
  EXPECT_NEAR(tubes.radius_at(value_of(proposals[0])), 1, 0.25);
}

TEST(Thresholds, OfThinThingsReachFromTheBackgroundToHalfWayUpThickOnes) {
  // Of 50 and 150: half way up is 100, half of that 75, the half of a tube that just gets as bright as 100.
  for (const double noise : {0.0, 4.0}) {
    const auto proposals = proposed_thresholds(Tubes(6, 4, 0.8, noise, false).volume);
    ASSERT_EQ(proposals.size(), 3u) << noise;
    EXPECT_EQ(proposals[2].rule, "thin");
    EXPECT_NEAR(value_of(proposals[2]), 75, 3) << noise;
    ASSERT_TRUE(proposals[2].seed) << noise;
    EXPECT_NEAR(value_of({"", *proposals[2].seed, ""}), 100, 4) << noise;
  }
  // Three times the noise lies above that.
  const auto noisy = proposed_thresholds(Tubes(6, 4, 0.8, 11, false).volume);
  ASSERT_EQ(noisy.size(), 3u);
  EXPECT_NEAR(value_of(noisy[2]), 50 + 3 * 11, 4);
}

TEST(Thresholds, DoNotDependOnThreads) {
  const Tubes tubes(3, 2, 0.8, 10, false);
  Context one, three;
  one.threads = 1;
  three.threads = 3;
  const auto a = proposed_thresholds(tubes.volume, &one), b = proposed_thresholds(tubes.volume, &three);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].value, b[i].value);
}

TEST(Thresholds, FollowAChangeOfValues) {
  // Ten times the values plus 1000, in another type.
  const Tubes tubes(4, 2, 0.8, 3, false);
  Volume other;
  other.grid = tubes.volume.grid;
  std::vector<float> samples;
  for (const std::uint8_t v : std::get<std::vector<std::uint8_t>>(tubes.volume.samples))
    samples.push_back(1000 + 10 * static_cast<float>(v));
  samples[17] = std::numeric_limits<float>::quiet_NaN();
  other.samples = samples;
  const double whole = value_of(proposed_thresholds(tubes.volume)[0]),
               changed = value_of(proposed_thresholds(other)[0]);
  EXPECT_NEAR((changed - 1000) / 10, whole, 1.5);
}

TEST(Thresholds, AreNoneForTwoValues) {
  Volume volume;
  volume.grid.dims = {4, 1, 1};
  volume.samples = std::vector<std::uint8_t>{0, 7, 7, 0};
  EXPECT_TRUE(proposed_thresholds(volume).empty());
  volume.samples = std::vector<std::uint8_t>{0, 7, 7, 1};
  EXPECT_FALSE(proposed_thresholds(volume).empty());
  volume.samples = std::vector<float>(4, std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(proposed_thresholds(volume).empty());
}

TEST(Histogram, CountsEveryFiniteSample) {
  Volume volume;
  volume.grid.dims = {5, 1, 1};
  volume.samples = std::vector<std::int16_t>{-3, 4, 4, 300, 12};
  Histogram histogram = histogram_of(volume, 4);
  EXPECT_EQ(histogram.low, -3);
  EXPECT_EQ(histogram.high, 300);
  EXPECT_EQ(histogram.width, 76);
  EXPECT_EQ(histogram.counts, (std::vector<std::uint64_t>{4, 0, 0, 1}));
  histogram = histogram_of(volume, 1000);
  EXPECT_EQ(histogram.width, 1);
  EXPECT_EQ(histogram.counts.size(), 304u);
  EXPECT_EQ(histogram.counts.back(), 1u);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  volume.samples = std::vector<float>{0, 1, 0.5, kNone, std::numeric_limits<float>::infinity()};
  histogram = histogram_of(volume, 2);
  EXPECT_EQ(histogram.not_finite, 2u);
  EXPECT_EQ(histogram.counts, (std::vector<std::uint64_t>{1, 2}));
  volume.samples = std::vector<float>(5, 2);
  EXPECT_EQ(histogram_of(volume).counts, (std::vector<std::uint64_t>{5}));
  volume.samples = std::vector<float>(5, kNone);
  EXPECT_TRUE(histogram_of(volume).counts.empty());
}

TEST(Labels, AreWholeNumbersThatFillRegions) {
  Volume volume;
  volume.grid.dims = {40, 4, 1};
  std::vector<std::uint8_t> samples(160);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::uint8_t>(i / 40 % 3);
  const auto labels = [&](auto values) {
    volume.samples = std::move(values);
    return labels_in(volume);
  };
  const std::vector<std::int64_t> three{0, 1, 2};
  EXPECT_EQ(labels(samples), three);
  EXPECT_EQ(labels(std::vector<std::int16_t>(samples.begin(), samples.end())), three);
  EXPECT_TRUE(labels(std::vector<float>(samples.begin(), samples.end())).empty());
  auto other = samples;
  std::ranges::replace(other, std::uint8_t{2}, std::uint8_t{200});  // few values, far apart
  EXPECT_TRUE(labels(other).empty());
  std::ranges::replace(other, std::uint8_t{200}, std::uint8_t{0});  // a mask
  EXPECT_TRUE(labels(other).empty());
  std::mt19937 random(1);  // few values with noise
  for (auto& value : other) value = static_cast<std::uint8_t>(random() % 4);
  EXPECT_TRUE(labels(other).empty());
  EXPECT_EQ(labels_text({0, 1, 2}), "0, 1, 2");
  EXPECT_EQ(labels_text({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 14}), "0, 1, 2 ... 14");
}

}  // namespace thresholds_test
}  // namespace quench
