// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "quench/shape.h"

namespace quench {

/// Voxels in one shape only / voxels of `wanted`, of shapes of one voxel size. Lattices are laid over each other where
/// their origins are closest: they may be those of meshes with slightly different boxes.
inline double voxel_difference(const VoxelShape& shape, const VoxelShape& wanted) {
  const Grid& a = shape.grid();
  const Grid& b = wanted.grid();
  std::int64_t shift[3];
  for (int i = 0; i < 3; ++i) shift[i] = std::llround((a.origin[i] - b.origin[i]) / b.spacing[i]);
  std::int64_t both = 0;
  for (std::int64_t z = 0; z < a.dims[2]; ++z)
    for (std::int64_t y = 0; y < a.dims[1]; ++y) {
      const std::int64_t v = y + shift[1], w = z + shift[2];
      if (v < 0 || v >= b.dims[1] || w < 0 || w >= b.dims[2]) continue;
      for (const Run& r : shape.row(y, z))
        for (const Run& s : wanted.row(v, w))
          both += std::max<std::int64_t>(
              0, std::min<std::int64_t>(r.end + shift[0], s.end) - std::max<std::int64_t>(r.begin + shift[0], s.begin));
    }
  return static_cast<double>(shape.voxel_count() + wanted.voxel_count() - 2 * both) /
         static_cast<double>(wanted.voxel_count());
}

}  // namespace quench
