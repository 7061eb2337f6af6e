// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/shape.h"
#include "voxelization/surface_cover.h"

namespace quench::voxelization {

using Voxel = std::array<std::int32_t, 3>;

/// From the shape and the cover together, voxels of the cover outside the shape are taken away, from the shape without
/// the cover those inside are put back, as long as they are simple: those whose centres are farthest from the surface
/// (in sixteenths of a voxel) first, equal ones in order of z, y, x. Returned, as voxels of the shape and in that
/// order, is what is left: *fills* outside the shape (with all of them it has the topology of shape and cover together)
/// and *cuts* inside it (without them that of the shape without the cover). `shape` lies `margin` voxels inside its
/// grid. Near linear in the cover; 52 bytes per voxel of it.
std::vector<Voxel> deflate(const SurfaceCover& cover, const VoxelShape& shape, std::int64_t margin,
                           const Progress& progress);

}  // namespace quench::voxelization
