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
  /// `spacing`: integer spacing; `extent`: largest difference of coordinates that will be met, below 2^22.
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

  /// The sphere of a tetrahedron, for several points: its equation d * lift(q) = n . q in differences q to a corner.
  struct Sphere {
    std::array<double, 3> n;
    double d;
    std::array<Point, 4> corners;
    std::uint32_t largest;  ///< no difference of corners to the first is larger
  };
  Sphere sphere(const Point& a, const Point& b, const Point& c, const Point& d) const;
  /// Whether p lies on it: as in_sphere() == 0, but much cheaper from the second point on.
  bool on_sphere(const Sphere& sphere, const Point& p) const { return side(sphere, p) == 0; }
  /// As in_sphere(), for a sphere of positively oriented corners.
  int side(const Sphere& sphere, const Point& p) const;
  /// Rounded, in units of the integer spacing.
  double radius(const Sphere& sphere) const {
    double squared = 0;
    for (std::size_t i = 0; i < 3; ++i) squared += sphere.n[i] * sphere.n[i] / real_weight_[i];
    return 0.5 * std::sqrt(squared) / std::abs(sphere.d);
  }

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

// With corners b, c, d relative to a, the weighted centre is n / (2 d), where d = det(b, c, d) and n = lift(b) c x d +
// lift(c) d x b + lift(d) b x c. For differences up to D, |d| <= 6 D^3 and |n_i| <= 6 sum D^4.
inline Predicates::Sphere Predicates::sphere(const Point& a, const Point& b, const Point& c, const Point& d) const {
  Sphere s{{}, 0, {a, b, c, d}, 0};
  std::uint32_t largest = 0;
  std::array<double, 3> x, y, z, lift;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& p = s.corners[i + 1];
    const std::int32_t dx = p.x - a.x, dy = p.y - a.y, dz = p.z - a.z;
    largest |= static_cast<std::uint32_t>((dx ^ dx >> 31) | (dy ^ dy >> 31) | (dz ^ dz >> 31));
    x[i] = dx, y[i] = dy, z[i] = dz;
    lift[i] = real_weight_[0] * (x[i] * x[i]) + real_weight_[1] * (y[i] * y[i]) + real_weight_[2] * (z[i] * z[i]);
  }
  s.largest = largest;
  s.n = {0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double cross_x = y[j] * z[k] - z[j] * y[k], cross_y = z[j] * x[k] - x[j] * z[k],
                 cross_z = x[j] * y[k] - y[j] * x[k];
    s.n[0] += lift[i] * cross_x;
    s.n[1] += lift[i] * cross_y;
    s.n[2] += lift[i] * cross_z;
    if (i == 0) s.d = x[0] * cross_x + y[0] * cross_y + z[0] * cross_z;
  }
  return s;
}

// |d * lift(q)| <= 6 sum D^5 and |n . q| <= 18 sum D^5: together the bound of the in-sphere test, and the same limit.
inline int Predicates::side(const Sphere& sphere, const Point& p) const {
  const Point& a = sphere.corners[0];
  const std::int32_t dx = p.x - a.x, dy = p.y - a.y, dz = p.z - a.z;
  const auto size = static_cast<std::uint32_t>((dx ^ dx >> 31) | (dy ^ dy >> 31) | (dz ^ dz >> 31));
  if ((size | sphere.largest) < double_limit_) {
    const double x = dx, y = dy, z = dz;
    const double lift = real_weight_[0] * (x * x) + real_weight_[1] * (y * y) + real_weight_[2] * (z * z);
    const double left = sphere.d * lift, right = sphere.n[0] * x + sphere.n[1] * y + sphere.n[2] * z;
    return (left < right) - (left > right);
  }
  return in_sphere(a, sphere.corners[1], sphere.corners[2], sphere.corners[3], p);
}

}  // namespace quench::lattice
