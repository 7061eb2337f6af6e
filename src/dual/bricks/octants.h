// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

/// What the shape looks like at a site: all that a brick needs to know of it.
namespace quench::dual::bricks {

/// Bit x + 2y + 4z: the voxel at the site on the positive side (1) or the negative side (0) of each axis is in O.
using Octants = std::uint8_t;

/// The octants of every site. Linear time; the sites must be in order of z, y, x.
std::vector<Octants> octants_of(const VoxelShape& shape, std::span<const LatticePoint> sites, Context* context);

/// Whether a direction (not along the boundary of O) leads into O. Between voxels the positive side is asked: both
/// agree there.
inline bool leads_inside(Octants octants, const std::array<std::int64_t, 3>& direction) {
  const unsigned octant = (direction[0] >= 0 ? 1u : 0u) | (direction[1] >= 0 ? 2u : 0u) | (direction[2] >= 0 ? 4u : 0u);
  return octants >> octant & 1;
}

/// A set of the 12 unit squares around a site: bit 4a + b + 2c for the one normal to axis a in the quadrant of the
/// positive (1) or negative (0) sides b of axis a+1 and c of axis a+2.
using Squares = std::uint16_t;

/// The squares at a site that lie on the boundary of O.
Squares boundary_squares(Octants octants);

/// The unit square in which three different lattice points lie, as seen from the first; 0 when there is none.
Squares square_at(const LatticePoint& at, const LatticePoint& p, const LatticePoint& q);

}  // namespace quench::dual::bricks
