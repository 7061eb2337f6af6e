// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "delaunay/bounds.h"
#include "quench/geometry.h"

namespace quench::dual::bricks {

using BrickIndex = std::array<std::int64_t, 3>;

/// A ball in lattice coordinates times the integer spacing.
struct Ball {
  Vec3 centre;
  double radius = 0;
};

/// Space cut into equal bricks (half-open boxes of lattice points), each with a halo: in brick and halo together, its
/// region, the brick knows all sites. A side of a region beyond which there are no sites is at infinity.
class BrickGrid {
 public:
  /// One brick that holds all lattice points between `bounds`.
  BrickGrid(const delaunay::Bounds& bounds, const std::array<std::int64_t, 3>& spacing);
  /// Bricks of about `size`^3 voxels with halos of about `halo` voxels, in the mean over the axes: both are the same
  /// lengths in the world along every axis, but at least one voxel.
  BrickGrid(const delaunay::Bounds& bounds, const std::array<std::int64_t, 3>& spacing, std::int64_t size,
            std::int64_t halo);

  bool whole() const { return count_ == BrickIndex{1, 1, 1}; }
  BrickIndex brick_of(const LatticePoint& p) const {
    BrickIndex brick;
    for (int a = 0; a < 3; ++a) brick[a] = (p[a] - low_[a]) / size_[a];
    return brick;
  }
  /// The bricks that hold any of the sites, in order of z, y, x.
  std::vector<BrickIndex> occupied(std::span<const LatticePoint> sites, std::span<const std::uint32_t> chosen) const;

  /// First and last lattice point of the region, within the bounds of all sites.
  delaunay::Bounds region(const BrickIndex& brick) const;
  /// Whether the ball lies in the region for certain: `slack`, relative to the size of the ball and in units, must be
  /// left on every side. The rounding of Ball is far smaller than the slacks used.
  bool certainly_holds(const BrickIndex& brick, const Ball& ball, double slack) const;

 private:
  std::array<std::int64_t, 3> low_, high_, spacing_, size_, halo_{0, 0, 0};
  BrickIndex count_;
};

}  // namespace quench::dual::bricks
