// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "axis/measures.h"
#include "base/parallel.h"
#include "quench/geometry.h"

namespace quench::axis {
namespace {

double angle(const MedialAxis& axis, std::span<const std::uint32_t> corners, double lambda) {
  const auto count = static_cast<double>(corners.size());
  const std::vector<Vec3>& points = axis.points_of_voxels();
  const std::vector<double>& radius = axis.radius_of_voxels();
  Vec3 centre = Vec3::Zero();
  for (const std::uint32_t v : corners) centre += points[v];
  centre /= count;
  // The squared distance of the centre to a site is that of the corners, on average, less their spread.
  double squared = 0;
  for (const std::uint32_t v : corners) squared += radius[v] * radius[v] - (points[v] - centre).squaredNorm();
  const double distance = std::sqrt(std::max(0.0, squared / count));
  return distance > 0 ? 2 * std::asin(std::min(1.0, lambda / distance)) * (180 / std::numbers::pi) : 180;
}

}  // namespace

CellValues object_angles(const MedialAxis& axis, const CellValues& lambda) {
  const CellComplex& complex = axis.complex;
  CellValues value{std::vector<double>(complex.vertex_count), std::vector<double>(complex.edges.size()),
                   std::vector<double>(complex.face_count())};
  base::for_indices(complex.vertex_count, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    value.vertex[i] = angle(axis, {&v, 1}, lambda.vertex[i]);
  });
  base::for_indices(complex.edges.size(),
                    [&](std::size_t e) { value.edge[e] = angle(axis, complex.edges[e], lambda.edge[e]); });
  base::for_indices(complex.face_count(),
                    [&](std::size_t f) { value.face[f] = angle(axis, complex.corners(f), lambda.face[f]); });
  return value;
}

}  // namespace quench::axis
