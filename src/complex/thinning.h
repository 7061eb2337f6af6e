// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "quench/complex.h"
#include "quench/context.h"

namespace quench::complex {

/// Topology-preserving thinning by simple pairs, which are elementary collapses: (face, edge in no other face) and
/// (edge in no face, vertex in no other edge). The key of a pair is the larger value of its two cells. Pairs are
/// collapsed in the order of (key, dimension, index of the free face, which is the smaller cell): this is the tie
/// policy of every thinning. The level of a cell is the running maximum of the keys when it is removed, infinite if it
/// never is. So {level >= t} is a closed subcomplex with the topology of the whole, in which no pair of key < t is
/// left; the family is nested.
///
/// Values must not be negative; cells of infinite value are never removed. Parallel edges and faces that meet an edge
/// twice are legal (such an edge is not free).
///
/// O(n log n); 16 bytes per vertex and edge, 8 per face and 16 per queued pair. Pairs are collapsed on one thread.
CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage);

}  // namespace quench::complex
