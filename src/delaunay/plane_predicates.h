// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "delaunay/circumsphere.h"
#include "quench/geometry.h"

/// Exact predicates for lattice points of a plane (z = 0) with the metric w0 x^2 + w1 y^2, w = squared integer spacing.
/// As in space, differences stay in lattice units and only the lift sees the weights.
///
/// Sites come in order of y, then x. So the plane is seen with y to the right and x upwards: their order is from left
/// to right, and counter-clockwise means counter-clockwise in that view.
namespace quench::delaunay {

/// Positive when (a, b, c) run counter-clockwise, 0 when they are on a line. Differences are at most D = 2^20:
/// |result| <= 2 D^2 = 2^41.
inline std::int64_t orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const std::int64_t bx = b[1] - a[1], by = b[0] - a[0], cx = c[1] - a[1], cy = c[0] - a[0];
  return bx * cy - by * cx;
}

class InCircle {
 public:
  explicit InCircle(const std::array<std::int64_t, 3>& spacing)
      : weight_{spacing[1] * spacing[1], spacing[0] * spacing[0]} {}

  /// Positive when p lies strictly inside the circle through the counter-clockwise (a, b, c), negative outside, 0 when
  /// on it. Coordinates times spacing differ by at most 2^20: lifts are at most 2^41 and so are minors, which fit 64
  /// bits; their products are below 3 * 2^82 in sum.
  Int128 operator()(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& p) const {
    const std::int64_t ax = a[1] - p[1], ay = a[0] - p[0], bx = b[1] - p[1], by = b[0] - p[0], cx = c[1] - p[1],
                       cy = c[0] - p[0];
    return Int128{lift(ax, ay)} * (bx * cy - by * cx) + Int128{lift(bx, by)} * (cx * ay - cy * ax) +
           Int128{lift(cx, cy)} * (ax * by - ay * bx);
  }

 private:
  std::int64_t lift(std::int64_t x, std::int64_t y) const { return weight_[0] * (x * x) + weight_[1] * (y * y); }
  std::array<std::int64_t, 2> weight_;
};

}  // namespace quench::delaunay
