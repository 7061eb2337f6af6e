// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "smooth_shapes.h"
#include "verify/box_tree.h"

namespace quench::smooth {

/// The four one-sided distances of Theorem 2.5.1, in voxels.
struct VoxelizationDistances {
  double vertices_to_surface = 0, surface_to_vertices = 0;  ///< boundary vertices P_h and the surface B
  double voxels_to_solid = 0, solid_to_voxels = 0;          ///< voxel shape O_h and the solid O
};

/// The first and the third are exact: distance to a convex solid is largest at a corner of a voxel, and so it is to the
/// torus but for h / (4 (R - r)) voxels. The others are taken at `samples` points of the surface, the fourth also at
/// points 0.3 and 0.6 voxels below it (O \ O_h is a thin layer there).
inline VoxelizationDistances voxelization_distances(const Solid& solid, const VoxelShape& shape, std::size_t samples) {
  const Grid& grid = shape.grid();
  const double h = grid.spacing[0];
  VoxelizationDistances d;
  std::vector<verification::Box> sites, voxels;
  for (const LatticePoint& p : boundary_vertices(shape)) {
    const double signed_distance = solid.signed_distance(grid.world(Vec3(p[0], p[1], p[2]))) / h;
    d.vertices_to_surface = std::max(d.vertices_to_surface, std::abs(signed_distance));
    d.voxels_to_solid = std::max(d.voxels_to_solid, signed_distance);
    sites.push_back({p, p});
  }
  for (std::int32_t z = 0; z < grid.dims[2]; ++z)
    for (std::int32_t y = 0; y < grid.dims[1]; ++y)
      for (const quench::Run& run : shape.row(y, z)) voxels.push_back({{run.begin, y, z}, {run.end, y + 1, z + 1}});
  const verification::BoxTree nearest_site(std::move(sites)), nearest_voxel(std::move(voxels));
  for (const SurfacePoint& s : surface_sample(solid, samples)) {
    d.surface_to_vertices = std::max(d.surface_to_vertices, nearest_site.nearest_squared(grid.lattice(s.point)));
    for (const double below : {0.0, 0.3, 0.6})
      d.solid_to_voxels =
          std::max(d.solid_to_voxels, nearest_voxel.nearest_squared(grid.lattice(s.point - below * h * s.normal)));
  }
  d.surface_to_vertices = std::sqrt(d.surface_to_vertices);
  d.solid_to_voxels = std::sqrt(d.solid_to_voxels);
  return d;
}

}  // namespace quench::smooth
