// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "quench/axis.h"
#include "quench/shape.h"

/// Local thickness by definition: every voxel centre against every ball. Shares no code with the library.
namespace quench::oracles {

/// The same rule for centres on a sphere.
inline bool holds(double squared_distance, double squared_radius) {
  return squared_distance <= squared_radius * (1 + 2e-9);
}

/// The voxel centres of a shape in the order of its runs.
inline std::vector<Vec3> voxel_centres(const VoxelShape& shape) {
  std::vector<Vec3> centres;
  const Grid& grid = shape.grid();
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y)
      for (const Run& run : shape.row(y, z))
        for (std::int32_t x = run.begin; x < run.end; ++x)
          centres.push_back(grid.world(grid.first_centre() + Vec3(x, static_cast<double>(y), static_cast<double>(z))));
  return centres;
}

/// The largest diameter of a ball of a vertex that holds the point; 0: none does.
inline double thickness_of_vertices(const MedialAxis& axis, const Vec3& p) {
  double best = 0;
  for (std::size_t v = 0; v < axis.points.size(); ++v)
    if (holds((p - axis.points[v]).squaredNorm(), axis.radius[v] * axis.radius[v]))
      best = std::max(best, 2 * axis.radius[v]);
  return best;
}

/// A nearest site of the middle of each edge: of all points of the edge, too.
inline std::vector<Vec3> sites_of_edges(const MedialAxis& axis, const VoxelShape& shape) {
  std::vector<Vec3> sites;
  for (const LatticePoint& site : boundary_vertices(shape)) sites.push_back(shape.grid().world_of(site));
  std::vector<Vec3> nearest;
  for (const auto& [a, b] : axis.complex.edges) {
    const Vec3 middle = (axis.points[a] + axis.points[b]) / 2;
    nearest.push_back(*std::min_element(sites.begin(), sites.end(), [&](const Vec3& s, const Vec3& t) {
      return (s - middle).squaredNorm() < (t - middle).squaredNorm();
    }));
  }
  return nearest;
}

/// The same over all points of the edges of a voxel core. A point x of an edge has the radius |x - a| for a nearest
/// site a, so p is in its ball where x lies on one side of the plane half way between p and a; the radius is largest at
/// an end of that part.
inline double thickness_of_edges(const MedialAxis& axis, const std::vector<Vec3>& sites, const Vec3& p) {
  double best = thickness_of_vertices(axis, p);
  for (std::size_t e = 0; e < axis.complex.edges.size(); ++e) {
    const Vec3 &u = axis.points[axis.complex.edges[e][0]], &v = axis.points[axis.complex.edges[e][1]], &a = sites[e];
    const Vec3 normal = a - p, way = v - u;
    const double across = normal.dot(way);
    if (across == 0) continue;
    const double t = normal.dot((p + a) / 2 - u) / across;
    if (!(t > 0 && t < 1)) continue;
    best = std::max(best, 2 * (u + t * way - a).norm());
  }
  return best;
}

}  // namespace quench::oracles
