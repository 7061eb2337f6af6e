// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "delaunay/circumsphere.h"
#include "quench/geometry.h"

/// Exact predicates for points of an integer lattice with the metric w0 x^2 + w1 y^2 + w2 z^2, w = squared integer
/// spacing. Scaling the axes multiplies an orientation by a positive constant, so all differences stay in lattice units
/// and only the lifted coordinate of the in-sphere test sees the weights.
namespace quench::delaunay {

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
      real_spacing_[a] = static_cast<double>(spacing[a]);
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

  /// The sphere of a tetrahedron, for several points: its equation in differences to the first corner.
  struct Sphere {
    SphereEquation<double> equation;
    std::array<Point, 4> corners;
    std::uint32_t largest;  ///< no difference of corners to the first is larger
  };
  Sphere sphere(const Point& a, const Point& b, const Point& c, const Point& d) const;
  /// Whether p lies on it: as in_sphere() == 0, but much cheaper from the second point on.
  bool on_sphere(const Sphere& sphere, const Point& p) const { return side(sphere, p) == 0; }
  /// As in_sphere(), for a sphere of positively oriented corners.
  int side(const Sphere& sphere, const Point& p) const;
  /// Relative to the first corner, in units of the integer spacing, rounded.
  std::array<double, 3> centre(const Sphere& sphere) const {
    std::array<double, 3> centre;
    for (std::size_t a = 0; a < 3; ++a) centre[a] = sphere.equation.n[a] / (2 * sphere.equation.d * real_spacing_[a]);
    return centre;
  }

  const std::array<std::int64_t, 3>& weights() const { return weight_; }

 private:
  int in_sphere_far(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p,
                    std::uint32_t largest) const;
  template <class T>
  int exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const;

  std::array<std::int64_t, 3> weight_{};
  std::array<double, 3> real_weight_{}, real_spacing_{};
  std::uint32_t double_limit_ = 0, int64_limit_ = 0;  // powers of two: differences below them are exact
  double filter_ = 0;
  bool wide_ = false;
};

// sphere_equation() with lifts up to sum * D^2: |n| <= 6 sum D^4.
inline Predicates::Sphere Predicates::sphere(const Point& a, const Point& b, const Point& c, const Point& d) const {
  Sphere s{{}, {a, b, c, d}, 0};
  std::array<double, 3> x, y, z, lift;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& p = s.corners[i + 1];
    const std::int32_t dx = p.x - a.x, dy = p.y - a.y, dz = p.z - a.z;
    s.largest |= static_cast<std::uint32_t>((dx ^ dx >> 31) | (dy ^ dy >> 31) | (dz ^ dz >> 31));
    x[i] = dx, y[i] = dy, z[i] = dz;
    lift[i] = real_weight_[0] * (x[i] * x[i]) + real_weight_[1] * (y[i] * y[i]) + real_weight_[2] * (z[i] * z[i]);
  }
  s.equation = sphere_equation(x, y, z, lift);
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
    const auto& [n, d] = sphere.equation;
    const double left = d * lift, right = n[0] * x + n[1] * y + n[2] * z;
    return (left < right) - (left > right);
  }
  return in_sphere(a, sphere.corners[1], sphere.corners[2], sphere.corners[3], p);
}

}  // namespace quench::delaunay
