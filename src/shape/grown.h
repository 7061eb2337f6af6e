// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/context.h"
#include "quench/shape.h"
#include "shape/surface_layers.h"

/// What ForegroundOptions add to a shape and take from it before it is cleaned; in planes 4 and 8 neighbours stand for
/// 6 and 26.
namespace quench::shape {

/// The components of `shape`, of 6 or 26 neighbours, that have a voxel of `seeds`, which are voxels of it.
/// O(runs log runs).
VoxelShape with_seeds(const VoxelShape& shape, const VoxelShape& seeds, int connectivity, ForegroundReport& report,
                      Context* context);

/// Closing by a ball of `radius` voxels of the smallest spacing: all voxels that no ball outside of the shape covers,
/// centres of balls lying on those of voxels, in the image and beside it. O(runs * radius^2).
VoxelShape closed(const VoxelShape& shape, int radius, ForegroundReport& report, Context* context);

/// Joins 26-connected components, as ForegroundOptions::connectivity says; of equally good voxels those of larger
/// `values` (null: none), else the first in order of z, y, x. O((runs + ways) log runs) for the ways to join the pairs
/// of voxels of different components that touch: two voxels for an edge, six pairs for a corner.
VoxelShape joined(const VoxelShape& shape, const SignedSamples* values, ForegroundReport& report, Context* context);

}  // namespace quench::shape
