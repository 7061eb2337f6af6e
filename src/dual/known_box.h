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
  KnownBox(const delaunay::Bounds& points, const std::array<std::int64_t, 3>& spacing)
      : points_(points), spacing_(spacing) {}

  /// Whether the closed ball through four points has no other lattice points for certain. Rounding is far below the
  /// 10^-6 of the radius and of a voxel that are left free, so it does not matter which corners of a polytope are
  /// taken.
  bool certainly_holds(const std::array<LatticePoint, 4>& corners) const {
    const delaunay::Circumsphere sphere = delaunay::circumsphere(corners, spacing_);
    const double reach = std::sqrt(sphere.squared_radius) * (1 + kSlack);
    for (std::size_t a = 0; a < 3; ++a) {
      const auto units = [&](std::int64_t steps) { return static_cast<double>(steps * spacing_[a]); };
      const double offset = sphere.offset[static_cast<Eigen::Index>(a)], free = (1 - kSlack) * units(1);
      const double below = units(corners[0][a] - points_[0][a]) + offset + free;
      const double above = units(points_[1][a] - corners[0][a]) - offset + free;
      if (!(below >= reach && above >= reach)) return false;
    }
    return true;
  }

 private:
  static constexpr double kSlack = 1e-6;

  delaunay::Bounds points_;
  std::array<std::int64_t, 3> spacing_;
};

}  // namespace quench::dual
