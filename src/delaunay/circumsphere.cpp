// SPDX-License-Identifier: Apache-2.0
#include "delaunay/circumsphere.h"

#include <algorithm>
#include <cstdlib>

#include "delaunay/predicates.h"
#include "quench/error.h"

namespace quench::delaunay {
namespace {

// Of coordinates of points relative to the first, axis by axis.
template <class T>
Circumsphere rounded(const std::array<std::array<std::int64_t, 3>, 3>& differences) {
  std::array<std::array<T, 3>, 3> axis;
  std::array<T, 3> lift{0, 0, 0};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 3; ++i) {
      axis[a][i] = differences[a][i];
      lift[i] += axis[a][i] * axis[a][i];
    }
  const SphereEquation<T> sphere = sphere_equation(axis[0], axis[1], axis[2], lift);
  const double scale = 2 * static_cast<double>(sphere.d);
  Circumsphere result;
  for (std::size_t a = 0; a < 3; ++a)
    result.offset[static_cast<Eigen::Index>(a)] = static_cast<double>(sphere.n[a]) / scale;
  result.squared_radius = result.offset.squaredNorm();
  return result;
}

}  // namespace

Circumsphere circumsphere(const std::array<LatticePoint, 4>& sites, const std::array<std::int64_t, 3>& spacing) {
  std::array<std::array<std::int64_t, 3>, 3> differences;
  std::int64_t largest = 0;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 3; ++i) {
      differences[a][i] = (sites[i + 1][a] - sites[0][a]) * spacing[a];
      largest = std::max(largest, std::abs(differences[a][i]));
    }
  // Lifts are at most 3 D^2: 18 D^4 < 2^61 for D < 2^14, and < 2^89 for D < 2^21.
  return largest < 1 << 14 ? rounded<std::int64_t>(differences) : rounded<Int128>(differences);
}

Circumsphere circumcircle(const std::array<LatticePoint, 3>& sites, const std::array<std::int64_t, 3>& spacing) {
  std::array<std::int64_t, 2> x, y, lift;
  for (std::size_t i = 0; i < 2; ++i) {
    x[i] = (sites[i + 1][0] - sites[0][0]) * spacing[0];
    y[i] = (sites[i + 1][1] - sites[0][1]) * spacing[1];
    lift[i] = x[i] * x[i] + y[i] * y[i];
  }
  // For D <= 2^20 lifts are at most 2^41, products of them 2^61, and sums of two of these below 2^63.
  const std::int64_t twice_area = x[0] * y[1] - y[0] * x[1];
  const std::int64_t n_x = y[1] * lift[0] - y[0] * lift[1], n_y = x[0] * lift[1] - x[1] * lift[0];
  const double scale = 2 * static_cast<double>(twice_area);
  Circumsphere result;
  result.offset = Vec3(static_cast<double>(n_x) / scale, static_cast<double>(n_y) / scale, 0);
  result.squared_radius = result.offset.squaredNorm();
  return result;
}

Circumsphere circumsphere(std::span<const std::uint32_t> ids, std::span<const LatticePoint> sites,
                          const std::array<std::int64_t, 3>& spacing) {
  const auto point = [&](std::size_t i) {
    const LatticePoint& site = sites[ids[i]];
    return Point{site[0], site[1], site[2], ids[i]};
  };
  // No three points of a sphere are on a line. Coordinates of sites differ by at most 2^20.
  std::size_t fourth = 3;
  while (fourth < ids.size() && orientation_determinant<std::int64_t>(point(0), point(1), point(2), point(fourth)) == 0)
    ++fourth;
  if (fourth >= ids.size()) throw Error(ErrorCode::invariant, "a vertex of the voxel core has sites in one plane");
  return circumsphere({sites[ids[0]], sites[ids[1]], sites[ids[2]], sites[ids[fourth]]}, spacing);
}

}  // namespace quench::delaunay
