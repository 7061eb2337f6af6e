// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "delaunay/bounds.h"
#include "delaunay/circumsphere.h"

namespace quench::dual {

/// A box of lattice points all sites of which are known: what a ball inside it says is certain.
class KnownBox {
 public:
  /// `points`: the first and the last lattice point.
  KnownBox(const delaunay::Bounds& points, const std::array<std::int64_t, 3>& spacing) : points_(points) {
    for (std::size_t a = 0; a < 3; ++a) spacing_[a] = static_cast<double>(spacing[a]);
  }

  const delaunay::Bounds& points() const { return points_; }

  /// Whether the closed ball has no other lattice points for certain. Its centre lies at `offset`, in units of the
  /// integer spacing, from a lattice point. Rounding of both is far below the 10^-6 of the radius and of a voxel that
  /// are left free, so that it does not matter of which corners a ball was computed.
  bool certainly_holds(const LatticePoint& corner, const std::array<double, 3>& offset, double radius) const {
    for (std::size_t a = 0; a < 3; ++a) {
      const double reach = radius * (1 + kSlack), free = (1 - kSlack) * spacing_[a];
      const double below = (static_cast<double>(corner[a]) - points_[0][a]) * spacing_[a] + offset[a];
      const double above = (static_cast<double>(points_[1][a]) - corner[a]) * spacing_[a] - offset[a];
      if (!(below + free >= reach && above + free >= reach)) return false;
    }
    return true;
  }
  /// The same of the ball through four points.
  bool certainly_holds(const std::array<LatticePoint, 4>& corners) const {
    std::array<std::int64_t, 3> spacing;
    for (std::size_t a = 0; a < 3; ++a) spacing[a] = static_cast<std::int64_t>(spacing_[a]);
    const delaunay::Circumsphere sphere = delaunay::circumsphere(corners, spacing);
    return certainly_holds(corners[0], {sphere.offset[0], sphere.offset[1], sphere.offset[2]},
                           std::sqrt(sphere.squared_radius));
  }

 private:
  static constexpr double kSlack = 1e-6;

  delaunay::Bounds points_;
  std::array<double, 3> spacing_;
};

}  // namespace quench::dual
