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
  int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const {
    const std::int32_t iax = a.x - p.x, iay = a.y - p.y, iaz = a.z - p.z, ibx = b.x - p.x, iby = b.y - p.y,
                       ibz = b.z - p.z, icx = c.x - p.x, icy = c.y - p.y, icz = c.z - p.z, idx = d.x - p.x,
                       idy = d.y - p.y, idz = d.z - p.z;
    const double ax = iax, ay = iay, az = iaz, bx = ibx, by = iby, bz = ibz, cx = icx, cy = icy, cz = icz, dx = idx,
                 dy = idy, dz = idz;
    const double det = determinant<double>(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, real_weight_);
    // The limits are powers of two, so one OR over the magnitudes tells whether all differences are below them.
    const auto magnitude = [](std::int32_t v) { return static_cast<std::uint32_t>(v ^ (v >> 31)); };
    const std::uint32_t all = magnitude(iax) | magnitude(iay) | magnitude(iaz) | magnitude(ibx) | magnitude(iby) |
                              magnitude(ibz) | magnitude(icx) | magnitude(icy) | magnitude(icz) | magnitude(idx) |
                              magnitude(idy) | magnitude(idz);
    if (all < double_limit_) return (det > 0) - (det < 0);
    if (all >= int64_limit_) {
      const double m = static_cast<double>(all) + 1;  // at least the largest difference
      const double bound = filter_ * m * m * m * m * m;
      if (det > bound) return 1;
      if (det < -bound) return -1;
      // Differences D along an axis of weight w obey D <= 2^23 and w D^2 <= 2^46 (delaunay.cpp), so
      // |det| <= 4 * (lift <= 3 * 2^46) * (minor <= 6 * 2^69) < 2^122.
      return exact<Int128>(a, b, c, d, p);
    }
    return exact<std::int64_t>(a, b, c, d, p);
  }

  const std::array<std::int64_t, 3>& weights() const { return weight_; }

 private:
  template <class T, class W>
  static T determinant(T ax, T ay, T az, T bx, T by, T bz, T cx, T cy, T cz, T dx, T dy, T dz,
                       const std::array<W, 3>& w) {
    const T ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy;
    const T da = dx * ay - ax * dy, ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
    const T abc = az * bc - bz * ac + cz * ab, bcd = bz * cd - cz * bd + dz * bc;
    const T cda = cz * da + dz * ac + az * cd, dab = dz * ab + az * bd + bz * da;
    const auto lift = [&w](T x, T y, T z) { return T(w[0]) * (x * x) + T(w[1]) * (y * y) + T(w[2]) * (z * z); };
    return (lift(cx, cy, cz) * dab - lift(dx, dy, dz) * abc) + (lift(ax, ay, az) * bcd - lift(bx, by, bz) * cda);
  }

  template <class T>
  int exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const {
    const T v = determinant<T>(a.x - p.x, a.y - p.y, a.z - p.z, b.x - p.x, b.y - p.y, b.z - p.z, c.x - p.x, c.y - p.y,
                               c.z - p.z, d.x - p.x, d.y - p.y, d.z - p.z, weight_);
    return (v > 0) - (v < 0);
  }

  std::array<std::int64_t, 3> weight_{};
  std::array<double, 3> real_weight_{};
  std::uint32_t double_limit_ = 0, int64_limit_ = 0;  // powers of two: differences below them are exact
  double filter_ = 0;
  bool wide_ = false;
};

}  // namespace quench::lattice
