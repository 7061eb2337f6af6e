// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::bricks {

using BrickIndex = std::array<std::int64_t, 3>;

/// A ball in lattice coordinates times the integer spacing.
struct Ball {
  Vec3 centre;
  double radius = 0;
};

/// Space cut into equal bricks (half-open boxes of lattice points), each with a halo: in brick and halo together, its
/// region, the brick knows all sites. A side of a region beyond which there are no sites at all is at infinity.
class BrickGrid {
 public:
  /// One brick that holds all lattice points from `low` to `high`.
  BrickGrid(const LatticePoint& low, const LatticePoint& high, const std::array<std::int64_t, 3>& spacing);
  /// Bricks of about `size`^3 voxels with halos of about `halo` voxels, in the mean over the axes: both are the same
  /// lengths in the world along every axis, but at least one voxel.
  BrickGrid(const LatticePoint& low, const LatticePoint& high, const std::array<std::int64_t, 3>& spacing,
            std::int64_t size, std::int64_t halo);

  bool whole() const { return count_ == BrickIndex{1, 1, 1}; }
  BrickIndex brick_of(const LatticePoint& p) const {
    BrickIndex brick;
    for (int a = 0; a < 3; ++a) brick[a] = (p[a] - low_[a]) / size_[a];
    return brick;
  }
  /// The bricks that hold any of `count` sites; `site(i)` in order of z, y, x.
  template <class Site>
  std::vector<BrickIndex> occupied(std::size_t count, const Site& site) const;

  /// First and last lattice point of the region, within the bounds of all sites.
  std::array<LatticePoint, 2> region(const BrickIndex& brick) const;
  /// Whether the ball lies in the region for certain: `slack`, relative to the size of the ball and in units, must be
  /// left on every side. The rounding of Ball is far smaller than the slacks used.
  bool certainly_holds(const BrickIndex& brick, const Ball& ball, double slack) const;

 private:
  std::array<std::int64_t, 3> low_, high_, spacing_, size_, halo_{0, 0, 0};
  BrickIndex count_;
};

template <class Site>
std::vector<BrickIndex> BrickGrid::occupied(std::size_t count, const Site& site) const {
  std::vector<BrickIndex> bricks;
  std::size_t layer = 0;  // where those of this layer of bricks begin
  const auto sort_layer = [&] {
    const auto begin = bricks.begin() + static_cast<std::ptrdiff_t>(layer);
    std::sort(begin, bricks.end(), [](const BrickIndex& a, const BrickIndex& b) {
      return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    });
    bricks.erase(std::unique(begin, bricks.end()), bricks.end());
    layer = bricks.size();
  };
  for (std::size_t i = 0; i < count; ++i) {
    const BrickIndex brick = brick_of(site(i));
    if (!bricks.empty() && bricks.size() > layer && bricks.back() == brick) continue;
    if (bricks.size() > layer && bricks.back()[2] != brick[2]) sort_layer();
    bricks.push_back(brick);
  }
  sort_layer();
  return bricks;
}

}  // namespace quench::bricks
