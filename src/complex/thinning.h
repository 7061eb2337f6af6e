// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "quench/complex.h"
#include "quench/context.h"

namespace quench::complex {

/// What the levels do not depend on.
struct ThinningOptions {
  std::size_t slabs = 0;  ///< parts of the complex that are thinned at once; 0: one for each thread, if it is large
  double most_crossing = 0.5;  ///< of the pairs, in components that cross slabs: a smaller bound is tried above
};

/// Topology-preserving thinning by simple pairs: (face, edge in no other face) and (edge in no face, vertex in no other
/// edge). Pairs go in the order of (key, dimension, index of the free cell, which is the smaller one), where the key is
/// the larger value of the two cells; equal keys are decided by the index, which is the tie policy of every thinning.
/// The level of a cell is the running maximum of the keys when it went, infinity if it never goes. So {level
/// >= t} is a closed subcomplex with the topology of the whole, in which no pair of key < t is left; the family is
/// nested.
///
/// Values are not negative; cells of infinite value never go. Parallel edges and faces that meet an edge twice are
/// legal (such an edge is not free).
///
/// O(n log n); 16 bytes per vertex and edge, 8 per face and 16 per queued pair, and more in slabs
/// (thinning_in_slabs.h), which is how several threads remove pairs.
CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage,
                const ThinningOptions& options = {});

}  // namespace quench::complex
