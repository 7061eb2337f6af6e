// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "quench/geometry.h"

namespace quench::delaunay {

__extension__ using Int128 = __int128;

/// The sphere through the origin and three points: all q with d |q|^2 = n . q. Its centre is n / (2 d).
template <class T>
struct SphereEquation {
  std::array<T, 3> n;
  T d;
};

/// The sphere through the origin and three points q[i] = (x[i], y[i], z[i]), where lift[i] = |q[i]|^2: d = det(q),
/// positive for right-handed q, and n = sum of lift[i] q[i+1] x q[i+2]. For coordinates up to D and lifts up to L D^2,
/// T must hold |d| <= 6 D^3 and |n[a]| <= 6 L D^4; every partial sum is within these bounds. With weights w[a] of the
/// axes in the lift, the centre is n[a] / (2 d w[a]).
template <class T>
SphereEquation<T> sphere_equation(const std::array<T, 3>& x, const std::array<T, 3>& y, const std::array<T, 3>& z,
                                  const std::array<T, 3>& lift) {
  SphereEquation<T> sphere{{0, 0, 0}, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const T cross_x = y[j] * z[k] - z[j] * y[k], cross_y = z[j] * x[k] - x[j] * z[k],
            cross_z = x[j] * y[k] - y[j] * x[k];
    sphere.n[0] += lift[i] * cross_x;
    sphere.n[1] += lift[i] * cross_y;
    sphere.n[2] += lift[i] * cross_z;
    if (i == 0) sphere.d = x[0] * cross_x + y[0] * cross_y + z[0] * cross_z;
  }
  return sphere;
}

/// In units of the integer spacing. Exact integers until the division, so that only their conversion and it round.
struct Circumsphere {
  Vec3 offset;  ///< of the centre from the first site
  double squared_radius;
};

/// Precondition: the sites are affinely independent, and coordinates times spacing differ by less than 2^21.
Circumsphere circumsphere(const std::array<LatticePoint, 4>& sites, const std::array<std::int64_t, 3>& spacing);

/// The same of a Delaunay polytope with the sites `ids`. Four of them are chosen by their order alone (the first three
/// and the first that is not in their plane), so that rounding does not depend on how the polytope was triangulated.
/// Throws Error(invariant) when all lie in one plane.
Circumsphere circumsphere(std::span<const std::uint32_t> ids, std::span<const LatticePoint> sites,
                          const std::array<std::int64_t, 3>& spacing);

/// The circle through three sites of a plane, as a sphere with its centre there. Precondition: they are not on a line,
/// and coordinates times spacing differ by at most 2^20.
Circumsphere circumcircle(const std::array<LatticePoint, 3>& sites, const std::array<std::int64_t, 3>& spacing);

}  // namespace quench::delaunay
