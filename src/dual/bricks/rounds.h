// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dual/dual_complex.h"
#include "quench/context.h"
#include "quench/shape.h"

namespace quench::dual::bricks {

/// Bricks of one round and their halos, in voxels (brick_grid.h).
struct BrickSize {
  std::int64_t size, halo;
};

/// How the work is divided; the result does not depend on it.
struct BrickPlan {
  std::vector<BrickSize> rounds;  ///< what is left after them is done at once
  std::size_t at_once = 20000;    ///< sites that are not worth dividing; 0: always take all rounds
};

/// Bricks with few sites beside the whole, and large beside their halos: the sites in a halo are triangulated again.
BrickPlan plan_for(const VoxelShape& shape);

/// The same as peel::dual_complex(), in memory that is bounded by the result, one brick per thread and the sites that
/// no brick can finish. Bricks run in parallel. Throws Error(failed) when the result outgrows 32-bit indices.
DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, const BrickPlan& plan, Context* context);

}  // namespace quench::dual::bricks
