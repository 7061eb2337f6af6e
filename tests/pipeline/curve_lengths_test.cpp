// SPDX-License-Identifier: Apache-2.0
// The erosion thickness of curves on shapes where it is known in closed form: at the base of a straight branch it is
// what the branch sticks out of the ball there.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "quench/pipeline.h"

namespace quench::pipeline {
namespace curve_lengths_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// How deep a point is in the union of balls along a segment.
double depth(const Vec3& p, const Vec3& a, const Vec3& b, double radius) {
  const double l2 = (b - a).squaredNorm(), t = l2 > 0 ? std::clamp((p - a).dot(b - a) / l2, 0.0, 1.0) : 0;
  return radius - (p - a - t * (b - a)).norm();
}

// Grey values that fall with the distance to the surface, of a shape given in a turned frame in units of voxels.
LoadedShape grey(const std::function<double(const Vec3&)>& depth_at, const Eigen::AngleAxisd& turn, int size) {
  Volume volume;
  volume.grid.dims = {size, size, size};
  const Vec3 middle = Vec3::Constant(0.5 * (size - 1));
  std::vector<float> samples;
  for (int z = 0; z < size; ++z)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        samples.push_back(static_cast<float>(depth_at(turn.inverse() * (Vec3(x, y, z) - middle))));
  volume.samples = std::move(samples);
  ShapeOptions options;
  options.foreground.threshold = 0.0;
  return shape_of(view_of(volume), {}, options);
}

struct Curves {
  Skeleton skeleton;
  // Calls visit(point, ET_MC) where fire comes.
  void for_each(const std::function<void(const Vec3&, double)>& visit) const {
    for (std::size_t v = 0; v < skeleton.points.size(); ++v) {
      const double time = skeleton.curve_burn_time[v];
      if (skeleton.on_curve[v] && std::isfinite(time)) visit(skeleton.points[v], time - skeleton.burn_time[v]);
    }
  }
};

Curves curves_of(const LoadedShape& shape, double omega_in_voxels) {
  const CoreResult core = core_of(shape);
  BurningOptions burning;
  if (omega_in_voxels > 0) burning.omega = Length{omega_in_voxels, Length::Unit::voxels};
  const SkeletonFamily family =
      skeletons(core.axis, burning_of(core.axis, !core.axis.is_fitted(), burning, true, shape.scale()));
  return {extract(family, kInfinity, 1.0)};  // one voxel
}

const std::vector<Eigen::AngleAxisd>& turns() {
  static const std::vector<Eigen::AngleAxisd> some{Eigen::AngleAxisd(0.6, Vec3(0.5, 0.8, 0.33).normalized()),
                                                   Eigen::AngleAxisd(1.3, Vec3(0.8, -0.3, 0.5).normalized())};
  return some;
}

TEST(CurveLengths, OfCapsulesAreTheirs) {
  for (const Eigen::AngleAxisd& turn : turns())
    for (const double omega : {0.0, 0.25, 1.0, 2.0}) {
      const double half = 22, radius = 6;
      const LoadedShape shape = grey(
          [&](const Vec3& p) {
            return depth(p, {-half, 0, 0}, {half, 0, 0}, radius);
          },
          turn, 64);
      double found = 0;
      curves_of(shape, omega).for_each([&](const Vec3&, double thickness) { found = std::max(found, thickness); });
      EXPECT_NEAR(found, half, 0.1 * half) << omega;
    }
}

// A ball with a bump that is a smaller ball's way out of it: before the crease the balls of the curve touch that.
TEST(CurveLengths, OfABumpAreWhatSticksOut) {
  for (const Eigen::AngleAxisd& turn : turns())
    for (const double size : {12.0, 20.0})
      for (const double omega : {0.0, 0.25, 1.0}) {
        const double tip = 1.2 * size, radius = 0.4 * size, crease = std::sqrt(size * size - radius * radius);
        const LoadedShape shape = grey(
            [&](const Vec3& p) {
              return std::max(depth(p, {0, 0, 0}, {0, 0, 0}, size), depth(p, {0, 0, 0}, {tip, 0, 0}, radius));
            },
            turn, static_cast<int>(3.6 * size));
        const Vec3 middle = Vec3::Constant(0.5 * (static_cast<int>(3.6 * size) - 1));
        std::size_t compared = 0;
        curves_of(shape, omega).for_each([&](const Vec3& p, double thickness) {
          const double x = (turn.inverse() * (p - middle))[0];
          if (x < 0.45 * size || x > 0.95 * tip) return;
          const double out = std::min(x - crease, 0.0), expected = tip - x + radius - std::hypot(out, radius);
          // Beside what the steps of voxels take off at the tip.
          EXPECT_NEAR(thickness, expected, std::max(0.1 * expected, 1.5)) << size << " " << omega << " at " << x;
          ++compared;
        });
        EXPECT_GT(compared, 3u) << size << " " << omega;
      }
}

}  // namespace curve_lengths_test
}  // namespace quench::pipeline
