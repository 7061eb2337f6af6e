// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"

namespace quench {

/// One value per cell, by dimension.
struct CellValues {
  std::vector<double> vertex, edge, face;
};

/// Topology-preserving thinning by simple pairs: (face, edge in no other face) and (edge in no face, vertex in no other
/// edge). Pairs go in the order of (key, dimension, index of the larger cell, index of the smaller cell), where the key
/// is the larger value of the two cells; equal keys are decided by the index, which is the tie policy of every
/// thinning. The level of a cell is the running maximum of the keys when it went, infinity if it never goes. So {level
/// >= t} is a closed subcomplex with the topology of the whole, in which no pair of key < t is left; the family is
/// nested.
///
/// Values are not negative; cells of infinite value never go. Parallel edges and faces that meet an edge twice are
/// legal (such an edge is not free).
///
/// O(n log n), one thread but for counting; 16 bytes per vertex and edge, 8 per face and 16 per queued pair.
CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage);

}  // namespace quench
