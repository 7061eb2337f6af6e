// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <set>

#include "damage.h"
#include "quench/shape.h"

/// How much of a shape a damage can take, whoever repairs it.
namespace quench::testing_damage {

/// The share of the voxels of `shape` whose nearest face of the clean mesh (by the middles of faces) is missing in the
/// damaged one: what the missing part of the surface encloses. From some 3000 voxels.
inline double share_behind_missing_faces(const VoxelShape& shape, const TriangleMesh& clean,
                                         const TriangleMesh& damaged) {
  const auto sorted = [](std::array<std::uint32_t, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  std::set<std::array<std::uint32_t, 3>> left;
  for (const auto& t : damaged.triangles) left.insert(sorted(t));
  struct Face {
    Vec3 middle;
    bool missing;
  };
  std::vector<Face> faces;
  for (const auto& t : clean.triangles)
    faces.push_back({(clean.points[t[0]] + clean.points[t[1]] + clean.points[t[2]]) / 3, !left.count(sorted(t))});
  const std::int64_t step = std::max<std::int64_t>(1, shape.voxel_count() / 3000);
  std::int64_t number = 0, behind = 0, all = 0;
  for (std::int64_t z = 0; z < shape.grid().dims[2]; ++z)
    for (std::int64_t y = 0; y < shape.grid().dims[1]; ++y)
      for (const Run& run : shape.row(y, z))
        for (std::int32_t x = run.begin; x < run.end; ++x) {
          if (number++ % step != 0) continue;
          const Vec3 centre = shape.grid().world({x + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5});
          double nearest = std::numeric_limits<double>::infinity();
          bool missing = false;
          for (const Face& face : faces)
            if (const double d = (face.middle - centre).squaredNorm(); d < nearest) {
              nearest = d;
              missing = face.missing;
            }
          behind += missing;
          ++all;
        }
  return static_cast<double>(behind) / static_cast<double>(all);
}

/// Boundary vertices / voxels: a surface that moves by a share of a voxel takes about that share of them.
inline double boundary_share(const VoxelShape& shape) {
  return static_cast<double>(count_boundary_vertices(shape)) / static_cast<double>(shape.voxel_count());
}

}  // namespace quench::testing_damage
