// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "quench/simplify.h"
#include "simplification/primitive_tree.h"

namespace quench::simplification {

/// Moves balls so that the envelope of the primitives runs through the boundary points. `rounds` of Gauss and Newton's
/// method; a round that makes the sum of squares larger is taken back and damped more. Returns that sum.
double fit(std::vector<Vec4>& balls, std::span<const Primitive> primitives, const BoundaryPoints& boundary, int rounds,
           Context* context);

}  // namespace quench::simplification
