// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "axis/measures.h"
#include "quench/geometry.h"

namespace quench::axis {

double object_angle(const MedialAxis& axis, std::span<const std::uint32_t> corners, double lambda) {
  const auto count = static_cast<double>(corners.size());
  Vec3 centre = Vec3::Zero();
  for (const std::uint32_t v : corners) centre += axis.points[v];
  centre /= count;
  // The squared distance of the centre to a site is that of the corners, on average, less their spread.
  double squared = 0;
  for (const std::uint32_t v : corners)
    squared += axis.radius[v] * axis.radius[v] - (axis.points[v] - centre).squaredNorm();
  const double distance = std::sqrt(std::max(0.0, squared / count));
  return distance > 0 ? 2 * std::asin(std::min(1.0, lambda / distance)) * (180 / std::numbers::pi) : 180;
}

}  // namespace quench::axis
