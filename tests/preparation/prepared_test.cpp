// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "preparation/filters.h"
#include "quench/error.h"
#include "quench/preparation.h"

namespace quench {
namespace prepared_test {

template <class T>
const std::vector<T>& samples_of(const Volume& volume) {
  return std::get<std::vector<T>>(volume.samples);
}

/// Random values on a small grid; floats have some that are not finite where `gaps`.
template <class T>
Volume noise(unsigned seed, bool plane = false, bool gaps = false) {
  std::mt19937 random(seed);
  Volume volume;
  for (auto& d : volume.grid.dims) d = 1 + static_cast<std::int64_t>(random() % 23);
  for (int a = 0; a < 3; ++a) volume.grid.spacing[a] = 1 + 0.5 * static_cast<double>(random() % 3);
  if (plane) {
    volume.grid.dims[2] = 1;
    volume.grid.make_plane();
  }
  std::vector<T> samples(static_cast<std::size_t>(volume.grid.dims[0] * volume.grid.dims[1] * volume.grid.dims[2]));
  for (T& sample : samples) {
    sample = static_cast<T>(random() % 200);
    if constexpr (!std::is_integral_v<T>) {
      if (gaps && random() % 4 == 0) sample = std::numeric_limits<T>::quiet_NaN();
      if (gaps && random() % 9 == 0) sample = std::numeric_limits<T>::infinity();
    }
  }
  if (samples.size() > 1) {
    samples[0] = 0;
    samples[1] = 199;
  }
  volume.samples = std::move(samples);
  return volume;
}

ForegroundOptions grey() {
  ForegroundOptions options;
  options.threshold = 100.0;
  return options;
}

Volume after(const Volume& volume, const PreparationOptions& options, int threads = 2,
             const ForegroundOptions& foreground = grey()) {
  Context context;
  context.threads = threads;
  return prepared(Volume(volume), options, foreground, nullptr, &context);
}

/// The place of the sample at (x, y, z), or of the nearest one of the image.
std::size_t clamped(const Grid& grid, std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto in = [&](std::int64_t i, std::size_t a) { return std::clamp<std::int64_t>(i, 0, grid.dims[a] - 1); };
  return static_cast<std::size_t>(in(x, 0) + grid.dims[0] * (in(y, 1) + grid.dims[1] * in(z, 2)));
}

template <class Visit>
void for_voxels(const Grid& grid, const Visit& visit) {
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y)
      for (std::int64_t x = 0; x < grid.dims[0]; ++x) visit(x, y, z, clamped(grid, x, y, z));
}

template <class T>
void expect_medians(const Volume& before, int radius) {
  const Volume volume = after(before, {.median = radius});
  EXPECT_TRUE(volume.samples == after(before, {.median = radius}, 1).samples ||
              std::is_floating_point_v<T>);  // NaN is unequal to itself
  const auto &was = samples_of<T>(before), &is = samples_of<T>(volume);
  const std::int64_t deep = before.grid.is_plane() ? 0 : radius;
  for_voxels(before.grid, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t i) {
    std::vector<T> around;
    for (std::int64_t dz = -deep; dz <= deep; ++dz)
      for (std::int64_t dy = -radius; dy <= radius; ++dy)
        for (std::int64_t dx = -radius; dx <= radius; ++dx) {
          const T sample = was[clamped(before.grid, x + dx, y + dy, z + dz)];
          if (preparation::is_finite(sample)) around.push_back(sample);
        }
    std::ranges::sort(around);
    if (preparation::is_finite(was[i]))
      EXPECT_EQ(is[i], around[(around.size() - 1) / 2]);
    else
      EXPECT_FALSE(preparation::is_finite(is[i]));
  });
}

TEST(Prepared, MediansAreThoseOfTheSamplesAround) {
  for (unsigned seed = 0; seed < 25; ++seed) {
    const int radius = 1 + static_cast<int>(seed % 3);
    expect_medians<std::uint8_t>(noise<std::uint8_t>(seed), radius);
    expect_medians<std::uint8_t>(noise<std::uint8_t>(seed, true), radius);
    expect_medians<std::int16_t>(noise<std::int16_t>(seed, seed % 2 == 0), radius);
    expect_medians<float>(noise<float>(seed, false, seed % 2 == 0), radius);
  }
  Volume low = noise<std::uint8_t>(3);
  std::vector<std::int8_t> negative;
  for (const std::uint8_t v : samples_of<std::uint8_t>(low)) negative.push_back(static_cast<std::int8_t>(v - 128));
  low.samples = std::move(negative);
  expect_medians<std::int8_t>(low, 1);
}

/// The sum over a box of products of the kernels along the axes, by the definition.
template <class T>
double blurred_at(const Volume& volume, double sigma, std::int64_t x, std::int64_t y, std::int64_t z) {
  std::array<std::vector<double>, 3> kernel;
  for (std::size_t a = 0; a < 3; ++a) {
    const double part = volume.grid.spacing.minCoeff() / volume.grid.spacing[static_cast<Eigen::Index>(a)];
    kernel[a] = a == 2 && volume.grid.is_plane() ? std::vector<double>{1} : preparation::gaussian_kernel(sigma * part);
  }
  const auto reach = [&](std::size_t a) { return static_cast<std::int64_t>(kernel[a].size()) - 1; };
  double sum = 0, weights = 0;
  for (std::int64_t dz = -reach(2); dz <= reach(2); ++dz)
    for (std::int64_t dy = -reach(1); dy <= reach(1); ++dy)
      for (std::int64_t dx = -reach(0); dx <= reach(0); ++dx) {
        const T sample = samples_of<T>(volume)[clamped(volume.grid, x + dx, y + dy, z + dz)];
        if (!preparation::is_finite(sample)) continue;
        const double weight = kernel[0][static_cast<std::size_t>(std::abs(dx))] *
                              kernel[1][static_cast<std::size_t>(std::abs(dy))] *
                              kernel[2][static_cast<std::size_t>(std::abs(dz))];
        sum += weight * static_cast<double>(sample);
        weights += weight;
      }
  return sum / weights;
}

template <class T, class Out>
void expect_blurred(const Volume& before, double sigma, double tolerance) {
  const Volume volume = after(before, {.blur = sigma});
  const auto& is = samples_of<Out>(volume);
  const Volume one_thread = after(before, {.blur = sigma}, 1);
  const auto& alone = samples_of<Out>(one_thread);
  for_voxels(before.grid, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t i) {
    if (!preparation::is_finite(samples_of<T>(before)[i])) {
      EXPECT_FALSE(preparation::is_finite(is[i]));
      return;
    }
    EXPECT_EQ(is[i], alone[i]);
    EXPECT_NEAR(static_cast<double>(is[i]), blurred_at<T>(before, sigma, x, y, z), tolerance);
  });
}

TEST(Prepared, BlurIsTheSumOverTheKernelsOfTheAxes) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const double sigma = 0.4 + 0.3 * (seed % 4);
    expect_blurred<std::uint8_t, std::uint8_t>(noise<std::uint8_t>(seed, seed % 3 == 0), sigma, 0.501);
    expect_blurred<std::int32_t, std::int32_t>(noise<std::int32_t>(seed), sigma, 0.5000001);
    expect_blurred<float, float>(noise<float>(seed, false, seed % 2 == 0), sigma, 1e-3);
    expect_blurred<double, double>(noise<double>(seed, seed % 2 == 0, true), sigma, 1e-9);
  }
}

TEST(Prepared, TheKernelHasTheVarianceOfItsWidth) {
  for (const double sigma : {0.05, 0.3, 0.8, 2.0, 7.5, 100.0}) {
    const std::vector<double> kernel = preparation::gaussian_kernel(sigma);
    double sum = kernel[0], variance = 0;
    for (std::size_t n = 1; n < kernel.size(); ++n) {
      EXPECT_LT(kernel[n], kernel[n - 1]);
      sum += 2 * kernel[n];
      variance += 2 * kernel[n] * static_cast<double>(n * n);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(variance, sigma * sigma, 1e-3 * sigma * sigma + 1e-4);
  }
  EXPECT_EQ(preparation::gaussian_kernel(0), std::vector<double>{1});
}

TEST(Prepared, FewWholeValuesBecomeFloats) {
  Volume mask = noise<std::uint8_t>(5);
  auto& samples = std::get<std::vector<std::uint8_t>>(mask.samples);
  for (auto& sample : samples) sample = sample > 100;
  ForegroundOptions half;
  half.threshold = 0.5;
  const Volume volume = after(mask, {.blur = 1}, 2, half);
  EXPECT_TRUE(std::holds_alternative<std::vector<float>>(volume.samples));
  expect_blurred<std::uint8_t, float>(mask, 1, 1e-5);
}

TEST(Prepared, LargeWholeValuesDoNotOverflow) {
  Volume volume;
  volume.grid.dims = {20, 4, 3};
  volume.samples = std::vector<std::uint64_t>(240, std::numeric_limits<std::uint64_t>::max());
  std::get<std::vector<std::uint64_t>>(volume.samples)[7] = 0;
  std::get<std::vector<std::uint64_t>>(volume.samples)[8] = 5;
  const Volume blurred = after(volume, {.blur = 1});
  // But for the rounding of doubles.
  EXPECT_GE(samples_of<std::uint64_t>(blurred).back(), std::numeric_limits<std::uint64_t>::max() - (1u << 16));
}

TEST(Prepared, GreyValuesAreInterpolatedLinearly) {
  Volume volume;
  volume.grid.dims = {6, 5, 7};
  volume.grid.spacing = {1, 2, 3};
  volume.grid.origin = {10, 20, 30};
  std::vector<float> samples;
  for (int z = 0; z < 7; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) samples.push_back(static_cast<float>(x + 10 * 2 * y + 100 * 3 * z));
  volume.samples = samples;
  const Volume cubes = after(volume, {.interpolate = true});
  EXPECT_EQ(cubes.grid.dims, (std::array<std::int64_t, 3>{6, 10, 21}));
  EXPECT_EQ(cubes.grid.spacing, Vec3(1, 1, 1));
  // The corner of the box stays.
  EXPECT_LT((cubes.grid.world(Vec3::Zero()) - volume.grid.world(Vec3::Zero())).norm(), 1e-12);
  for_voxels(cubes.grid, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t i) {
    const Vec3 place = cubes.grid.world(Vec3(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5,
                                             static_cast<double>(z) + 0.5)) -
                       volume.grid.origin;
    const Vec3 inside = place.cwiseMax(0).cwiseMin(Vec3(5, 8, 18));
    EXPECT_NEAR(samples_of<float>(cubes)[i], inside.dot(Vec3(1, 10, 100)), 1e-3);
  });
}

TEST(Prepared, CubesStayAsTheyAre) {
  const Volume volume = [] {
    Volume v = noise<std::uint8_t>(9);
    v.grid.spacing = {2, 2, 2};
    return v;
  }();
  PreparationReport report;
  const Volume same = prepared(Volume(volume), {.interpolate = true}, grey(), &report);
  EXPECT_EQ(same.samples, volume.samples);
  EXPECT_EQ(same.grid.dims, volume.grid.dims);
  ASSERT_EQ(report.done.size(), 1u);
  EXPECT_EQ(report.done[0].rfind("nothing to interpolate", 0), 0u);
}

TEST(Prepared, SlicesOfAConeBecomeACone) {
  // Discs of radius 20 - 2z in slices 4 apart; along each axis in turn. Value 3 of several labels, and label 0.
  for (std::size_t thick = 0; thick < 3; ++thick)
    for (const std::int64_t label : {3, 0}) {
      Volume volume;
      volume.grid.dims = {48, 48, 48};
      volume.grid.dims[thick] = 9;
      volume.grid.spacing[static_cast<Eigen::Index>(thick)] = 4;
      std::vector<std::int16_t> samples;
      for_voxels(volume.grid, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t) {
        const std::array<std::int64_t, 3> at{x, y, z};
        const double u = static_cast<double>(at[(thick + 1) % 3]) - 23.5,
                     v = static_cast<double>(at[(thick + 2) % 3]) - 23.5;
        const bool inside = std::hypot(u, v) < 20 - 2 * static_cast<double>(at[thick]);
        samples.push_back(static_cast<std::int16_t>(inside ? label : 7));
      });
      volume.samples = samples;
      ForegroundOptions options;
      options.label = label;
      const Volume cubes = after(volume, {.interpolate = true}, 2, options);
      EXPECT_EQ(cubes.grid.dims[thick], 36);
      std::int64_t wrong = 0;
      for_voxels(cubes.grid, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t i) {
        const std::array<std::int64_t, 3> at{x, y, z};
        const double u = static_cast<double>(at[(thick + 1) % 3]) - 23.5,
                     v = static_cast<double>(at[(thick + 2) % 3]) - 23.5;
        const double slice = std::clamp((static_cast<double>(at[thick]) + 0.5) / 4 - 0.5, 0.0, 8.0);
        const double deep = 20 - 2 * slice - std::hypot(u, v);
        const bool inside = samples_of<std::int16_t>(cubes)[i] == label;
        if (std::abs(deep) > 0.8) wrong += inside != (deep > 0);
      });
      EXPECT_EQ(wrong, 0) << thick;
      EXPECT_FALSE(foreground(cubes, options).empty());
    }
}

TEST(Prepared, AShapeEndsHalfWayToAnEmptySlice) {
  Volume volume;
  volume.grid.dims = {20, 20, 3};
  volume.grid.spacing = {1, 1, 6};
  std::vector<std::uint8_t> samples(1200, 0);
  for (std::size_t y = 5; y < 15; ++y)
    for (std::size_t x = 5; x < 15; ++x) samples[400 + 20 * y + x] = 255;
  volume.samples = samples;
  const VoxelShape shape = foreground(after(volume, {.interpolate = true}, 2, {}), {});
  EXPECT_EQ(shape.foreground_box().begin, (std::array<std::int64_t, 3>{5, 5, 6}));
  EXPECT_EQ(shape.foreground_box().end, (std::array<std::int64_t, 3>{15, 15, 12}));
  EXPECT_EQ(shape.voxel_count(), 600);
}

TEST(Prepared, StepsAreReportedInOrder) {
  Volume volume = noise<std::uint8_t>(11);
  volume.grid.spacing = {1, 1, 2};
  PreparationReport report;
  prepared(Volume(volume), {.interpolate = true, .median = 1, .blur = 0.8}, grey(), &report);
  ASSERT_EQ(report.done.size(), 3u);
  EXPECT_EQ(report.before.dims, volume.grid.dims);
  EXPECT_NE(report.done[0].find("linearly"), std::string::npos);
  EXPECT_NE(report.done[1].find("3 x 3 x 3"), std::string::npos);
  EXPECT_NE(report.done[2].find("0.8"), std::string::npos);
}

TEST(Prepared, RefusesWhatMakesNoSense) {
  const auto field = [](const Volume& volume, const PreparationOptions& options, const ForegroundOptions& foreground) {
    try {
      prepared(Volume(volume), options, foreground);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      return error.field();
    }
    return std::string("none");
  };
  const Volume volume = noise<std::uint8_t>(2), plane = noise<std::uint8_t>(2, true);
  ForegroundOptions label;
  label.label = 3;
  EXPECT_EQ(field(volume, {.median = -1}, grey()), "median");
  EXPECT_EQ(field(volume, {.median = kLargestMedian + 1}, grey()), "median");
  EXPECT_EQ(field(volume, {.blur = -1}, grey()), "blur");
  EXPECT_EQ(field(volume, {.blur = std::nan("")}, grey()), "blur");
  EXPECT_EQ(field(volume, {.blur = 101}, grey()), "blur");
  EXPECT_EQ(field(volume, {.blur = 1}, label), "blur");
  EXPECT_EQ(field(plane, {.interpolate = true}, grey()), "interpolate");
  EXPECT_EQ(field(plane, {.median = 1, .blur = 1}, grey()), "none");
  EXPECT_EQ(field(volume, {.median = 1}, label), "none");
}

}  // namespace prepared_test
}  // namespace quench
