// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/brick_grid.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace quench::dual::bricks {

BrickGrid::BrickGrid(const delaunay::Bounds& bounds, const std::array<std::int64_t, 3>& spacing)
    : spacing_(spacing), count_{1, 1, 1} {
  for (int a = 0; a < 3; ++a) {
    low_[a] = bounds[0][a];
    high_[a] = bounds[1][a];
    size_[a] = high_[a] - low_[a] + 1;
  }
}

BrickGrid::BrickGrid(const delaunay::Bounds& bounds, const std::array<std::int64_t, 3>& spacing, std::int64_t size,
                     std::int64_t halo)
    : BrickGrid(bounds, spacing) {
  double volume = 1;
  for (const std::int64_t s : spacing) volume *= static_cast<double>(s);
  for (int a = 0; a < 3; ++a) {
    const double voxels = std::cbrt(volume) / static_cast<double>(spacing[a]);
    size_[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(size) * voxels));
    halo_[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(halo) * voxels));
    count_[a] = (high_[a] - low_[a]) / size_[a] + 1;
  }
}

std::vector<BrickIndex> BrickGrid::occupied(std::span<const LatticePoint> sites,
                                            std::span<const std::uint32_t> chosen) const {
  std::set<BrickIndex> bricks;  // z, y, x
  BrickIndex last{-1, -1, -1};
  for (const std::uint32_t s : chosen) {
    const BrickIndex brick = brick_of(sites[s]);
    if (brick != last) bricks.insert({brick[2], brick[1], brick[0]});
    last = brick;
  }
  std::vector<BrickIndex> result;
  for (const auto& [z, y, x] : bricks) result.push_back({x, y, z});
  return result;
}

delaunay::Bounds BrickGrid::region(const BrickIndex& brick) const {
  delaunay::Bounds result;
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

}  // namespace quench::dual::bricks
