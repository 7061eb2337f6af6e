// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "smooth_shapes.h"
#include "verification/bvh.h"

namespace quench::smooth {

/// The four one-sided distances of Theorem 2.5.1, in voxels.
struct VoxelizationDistances {
  double vertices_to_surface = 0, surface_to_vertices = 0;  ///< boundary vertices P_h and the surface B
  double voxels_to_solid = 0, solid_to_voxels = 0;          ///< voxel shape O_h and the solid O
};

/// Distance of a lattice position to the voxels of the shape; 1 where it is 1 or more.
inline double distance_to_voxels(const VoxelShape& shape, const Vec3& x) {
  const std::array<std::int64_t, 3> voxel{static_cast<std::int64_t>(std::floor(x[0])),
                                          static_cast<std::int64_t>(std::floor(x[1])),
                                          static_cast<std::int64_t>(std::floor(x[2]))};
  if (shape.contains(voxel[0], voxel[1], voxel[2])) return 0;
  double best = 1;
  for (std::int64_t k = -1; k <= 1; ++k)
    for (std::int64_t j = -1; j <= 1; ++j)
      for (std::int64_t i = -1; i <= 1; ++i) {
        if (!shape.contains(voxel[0] + i, voxel[1] + j, voxel[2] + k)) continue;
        const Vec3 low(static_cast<double>(voxel[0] + i), static_cast<double>(voxel[1] + j),
                       static_cast<double>(voxel[2] + k));
        best = std::min(best, (x - x.cwiseMax(low).cwiseMin(low + Vec3::Ones())).norm());
      }
  return best;
}

/// The first and the third are exact: distance to a convex solid is largest at a corner of a voxel, and so it is to the
/// torus but for h / (4 (R - r)) voxels. The others are taken at `samples` points of the surface, the fourth also at
/// points 0.3 and 0.6 voxels below it (O \ O_h is a thin layer there).
inline VoxelizationDistances voxelization_distances(const Solid& solid, const VoxelShape& shape, std::size_t samples) {
  const Grid& grid = shape.grid();
  const double h = grid.spacing[0];
  VoxelizationDistances d;
  std::vector<verification::Box> sites;
  for (const LatticePoint& p : boundary_vertices(shape)) {
    const double signed_distance = solid.signed_distance(grid.world(Vec3(p[0], p[1], p[2]))) / h;
    d.vertices_to_surface = std::max(d.vertices_to_surface, std::abs(signed_distance));
    d.voxels_to_solid = std::max(d.voxels_to_solid, signed_distance);
    sites.push_back({p, p});
  }
  const verification::Bvh nearest_site(std::move(sites));
  for (const SurfacePoint& s : surface_sample(solid, samples)) {
    d.surface_to_vertices = std::max(d.surface_to_vertices, nearest_site.nearest_squared(grid.lattice(s.point)));
    for (const double below : {0.0, 0.3, 0.6})
      d.solid_to_voxels =
          std::max(d.solid_to_voxels, distance_to_voxels(shape, grid.lattice(s.point - below * h * s.normal)));
  }
  d.surface_to_vertices = std::sqrt(d.surface_to_vertices);
  return d;
}

}  // namespace quench::smooth
