// SPDX-License-Identifier: Apache-2.0
#include "bricks/brick_grid.h"

#include <algorithm>
#include <cmath>

namespace quench::bricks {

BrickGrid::BrickGrid(const LatticePoint& low, const LatticePoint& high, const std::array<std::int64_t, 3>& spacing)
    : spacing_(spacing), count_{1, 1, 1} {
  for (int a = 0; a < 3; ++a) {
    low_[a] = low[a];
    high_[a] = high[a];
    size_[a] = high_[a] - low_[a] + 1;
  }
}

BrickGrid::BrickGrid(const LatticePoint& low, const LatticePoint& high, const std::array<std::int64_t, 3>& spacing,
                     std::int64_t size, std::int64_t halo)
    : BrickGrid(low, high, spacing) {
  double volume = 1;
  for (const std::int64_t s : spacing) volume *= static_cast<double>(s);
  for (int a = 0; a < 3; ++a) {
    const double voxels = std::cbrt(volume) / static_cast<double>(spacing[a]);
    size_[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(size) * voxels));
    halo_[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(halo) * voxels));
    count_[a] = (high_[a] - low_[a]) / size_[a] + 1;
  }
}

std::array<LatticePoint, 2> BrickGrid::region(const BrickIndex& brick) const {
  std::array<LatticePoint, 2> result;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t begin = low_[a] + brick[a] * size_[a];
    result[0][a] = static_cast<std::int32_t>(std::max(low_[a], begin - halo_[a]));
    result[1][a] = static_cast<std::int32_t>(std::min(high_[a], begin + size_[a] - 1 + halo_[a]));
  }
  return result;
}

bool BrickGrid::certainly_holds(const BrickIndex& brick, const Ball& ball, double slack) const {
  const auto [first, last] = region(brick);
  const double reach = ball.radius + slack * (1 + ball.radius);
  for (int a = 0; a < 3; ++a) {
    if (first[a] != low_[a] && !(ball.centre[a] - reach >= static_cast<double>(first[a] * spacing_[a]))) return false;
    if (last[a] != high_[a] && !(ball.centre[a] + reach <= static_cast<double>(last[a] * spacing_[a]))) return false;
  }
  return true;
}

}  // namespace quench::bricks
