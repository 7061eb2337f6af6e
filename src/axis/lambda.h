// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dual/dual_complex.h"
#include "quench/axis.h"

namespace quench::axis {

struct Carried;

/// Lambda of the cells of a voxel core, in world units (Yan 2018, sec. 2.6 step 2): of a face half the distance of its
/// two sites, of edges and vertices by the rule. `complex` is that of `dual`, which may have been moved out of it;
/// `unit` is the world length of one unit of the integer spacing; `carried`: of faces and edges that are gone. Linear
/// time, in parallel; memory for the result only.
CellValues lambda(const CellComplex& complex, const dual::DualComplex& dual, std::span<const LatticePoint> sites,
                  const std::array<std::int64_t, 3>& spacing, double unit, LambdaRule rule, const Carried& carried,
                  Context* context);

}  // namespace quench::axis
