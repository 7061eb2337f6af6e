// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"

namespace quench {

/// A mask that somebody else owns: byte (x, y, z) is `strides[0]*x + strides[1]*y + strides[2]*z` after `data`.
struct MaskView {
  std::array<std::int64_t, 3> dims{0, 0, 0};
  std::array<std::int64_t, 3> strides{0, 0, 0};
  std::uint8_t* data = nullptr;
};

/// Sets the voxels a complex runs through to 1: those of its isolated vertices, and of samples of its edges and
/// polygons no further than a third of a voxel apart, so that what is connected is 26-connected. Voxels of a complex
/// inside a voxel shape are voxels of the shape. What is outside the mask is left out. `grid` places voxels; its dims
/// are not looked at. Throws Error(usage) for a vertex more than 2^21 voxels away.
void mark_cells(const CellComplex& complex, std::span<const Vec3> points, const Grid& grid, const MaskView& mask,
                Context* context = nullptr);

/// Sets the voxels whose centres lie in a ball to 1. O(sum of squared radii in voxels), in parallel; deterministic.
/// Balls whose centre or radius is no number have no voxels.
void mark_balls(std::span<const Vec3> centres, std::span<const double> radius, const Grid& grid, const MaskView& mask,
                Context* context = nullptr);

}  // namespace quench
