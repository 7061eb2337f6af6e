// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/simplify.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// Moves the balls of a medial mesh so that its envelope runs through the boundary points: rounds of Gauss and Newton's
/// method, damped (Levenberg 1944). A round that makes the sum of squared distances larger is taken back and damped
/// more.
void fit(MedialAxis& mesh, const BoundaryPoints& boundary, int rounds, Context* context);

/// Per vertex of a medial mesh the quadric of the planes at the boundary points that the cells around it reach.
std::vector<Quadric> boundary_quadrics(const MedialAxis& mesh, const BoundaryPoints& boundary, Context* context);

}  // namespace quench::simplification
