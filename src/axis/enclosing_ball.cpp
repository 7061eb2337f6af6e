// SPDX-License-Identifier: Apache-2.0
#include "axis/enclosing_ball.h"

#include <Eigen/Dense>
#include <algorithm>

namespace quench::axis {
namespace {

struct Ball {
  Vec3 center = Vec3::Zero();
  double squared_radius = -1;
  bool contains(const Vec3& p) const { return (p - center).squaredNorm() <= squared_radius * (1 + 1e-12) + 1e-12; }
};

// The smallest ball with all (affinely independent) support points on its sphere: its centre lies in their affine hull.
Ball through(std::span<const Vec3> support) {
  if (support.empty()) return {};
  if (support.size() == 1) return {support[0], 0};
  const auto k = static_cast<Eigen::Index>(support.size()) - 1;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(3, k);
  for (Eigen::Index i = 0; i < k; ++i) edges.col(i) = support[static_cast<std::size_t>(i) + 1] - support[0];
  const auto gram = (edges.transpose() * edges).eval();
  const auto half = (0.5 * gram.diagonal()).eval();
  const Vec3 offset = edges * gram.fullPivLu().solve(half);
  return {support[0] + offset, offset.squaredNorm()};
}

Ball smallest(std::span<Vec3> points, std::size_t count, std::array<Vec3, 4>& support, std::size_t fixed) {
  Ball ball = through({support.data(), fixed});
  if (fixed == 4) return ball;
  for (std::size_t i = 0; i < count; ++i) {
    if (ball.contains(points[i])) continue;
    support[fixed] = points[i];
    ball = smallest(points, i, support, fixed + 1);
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(i),
                points.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
  return ball;
}

}  // namespace

double enclosing_ball_squared_radius(std::span<Vec3> points) {
  std::array<Vec3, 4> support;
  return std::max(0.0, smallest(points, points.size(), support, 0).squared_radius);
}

}  // namespace quench::axis
