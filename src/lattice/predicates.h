// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "quench/geometry.h"

/// Exact predicates for points of an integer lattice with the metric w0 x^2 + w1 y^2 + w2 z^2, w = squared integer
/// spacing. Scaling the axes multiplies an orientation by a positive constant, so all differences stay in lattice units
/// and only the lifted coordinate of the in-sphere test sees the weights.
namespace quench::lattice {

__extension__ using Int128 = __int128;

/// 16 bytes, so that a point is one load; `site` is its rank among the sites in order of z, y, x.
struct alignas(16) Point {
  std::int32_t x, y, z;
  std::uint32_t site;
};

/// Positive when (b-a, c-a, d-a) is right-handed; 0 when coplanar. T must hold 6 D^3 for differences up to D:
/// 64 bits for D <= 2^20 (6 * 2^60 < 2^63), 128 bits beyond.
template <class T>
inline T orientation_determinant(const Point& a, const Point& b, const Point& c, const Point& d) {
  const T bx = b.x - a.x, by = b.y - a.y, bz = b.z - a.z;
  const T cx = c.x - a.x, cy = c.y - a.y, cz = c.z - a.z;
  const T dx = d.x - a.x, dy = d.y - a.y, dz = d.z - a.z;
  return bx * (cy * dz - cz * dy) - by * (cx * dz - cz * dx) + bz * (cx * dy - cy * dx);
}

class Predicates {
 public:
  /// `spacing`: integer spacing; `extent`: largest difference of coordinates that will be met, at most 2^23.
  Predicates(const std::array<std::int64_t, 3>& spacing, std::int64_t extent)
      : wide_(extent > (std::int64_t{1} << 20)) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      weight_[a] = spacing[a] * spacing[a];
      real_weight_[a] = static_cast<double>(weight_[a]);
      sum += real_weight_[a];
    }
    // |det| <= 4 * (lift <= sum * D^2) * (minor <= 6 D^3) = 24 * sum * D^5, and so is every partial sum.
    const auto power_of_two_below = [](double limit) {
      return limit < 1 ? 0u : std::bit_floor(static_cast<std::uint32_t>(limit * (1 - 1e-9)));
    };
    double_limit_ = power_of_two_below(std::pow(0x1p53 / (24 * sum), 0.2));
    int64_limit_ = power_of_two_below(std::pow(0x1p63 / (24 * sum), 0.2));
    // Rounding: fewer than 20 operations on the way to each of the partial sums above, each within 2^-53 relative.
    filter_ = 24 * sum * 20 * 0x1p-53;
  }

  /// Sign of the volume of (a, b, c, d).
  int orientation(const Point& a, const Point& b, const Point& c, const Point& d) const {
    if (!wide_) {
      const std::int64_t v = orientation_determinant<std::int64_t>(a, b, c, d);
      return (v > 0) - (v < 0);
    }
    const Int128 v = orientation_determinant<Int128>(a, b, c, d);
    return (v > 0) - (v < 0);
  }

  /// Positive when p lies strictly inside the ball through the corners of the positively oriented (a, b, c, d),
  /// 0 when on its sphere.
  int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const;

  const std::array<std::int64_t, 3>& weights() const { return weight_; }

 private:
  int in_sphere_far(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p,
                    std::uint32_t largest) const;
  template <class T>
  int exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const;

  std::array<std::int64_t, 3> weight_{};
  std::array<double, 3> real_weight_{};
  std::uint32_t double_limit_ = 0, int64_limit_ = 0;  // powers of two: differences below them are exact
  double filter_ = 0;
  bool wide_ = false;
};

}  // namespace quench::lattice
