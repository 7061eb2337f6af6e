// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/axis.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// Per vertex of a medial mesh the quadric of what its cells show on the surface of the envelope: two planes of each
/// slab, the part of each cone and each ball that no slab or cone beside it covers.
std::vector<Quadric> envelope_quadrics(const MedialAxis& mesh, Context* context);

}  // namespace quench::simplification
