// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "quench/shape.h"

namespace quench::shape {

/// Boundary vertices of a shape, and how many of them are flat: of the eight voxels around, those inside are the four
/// on one side of a lattice plane.
struct BoundaryCount {
  std::int64_t sites = 0, flat = 0;
};
BoundaryCount count_boundary(const VoxelShape& shape);

}  // namespace quench::shape
