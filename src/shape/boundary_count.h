// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "quench/shape.h"

namespace quench::shape {

/// Boundary vertices of a shape, and how many of them are flat: of the eight voxels around, those inside are the four
/// on one side of a lattice plane.
struct BoundaryCount {
  std::int64_t sites = 0, flat = 0;
};
BoundaryCount count_boundary(const VoxelShape& shape);

/// The number of rows along x in which boundary vertices may lie: in order of z, y.
std::size_t boundary_rows(const VoxelShape& shape);
/// Those of some of the rows, [first, last).
std::vector<LatticePoint> boundary_vertices(const VoxelShape& shape, std::size_t first, std::size_t last);

}  // namespace quench::shape
