// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"

namespace quench::complex {

/// Per cell of a complex whether it is named.
struct CellFlags {
  std::vector<std::uint8_t> vertex, edge, face;
};

/// What is known of a complex of which the rest is not: some of its cells, with all their sides.
struct KnownCells {
  const CellComplex& complex;  ///< cells of one dimension are in the order of the whole
  std::span<const double> vertex_value, edge_value, face_value;
  /// 1 of cells of which something is not known, else 0: whether there are more edges at the vertex or faces at the
  /// edge, or the value of the cell or, of an edge, of a face at it. True values are not below those that are given.
  std::span<const std::uint8_t> vertex_uncertain, edge_uncertain;
};

/// The cells that can be removed before the thinning of the whole complex (complex/thinning.h): those of some of the
/// pairs that it certainly collapses at levels below `cutoff`, whatever the rest is. What is left of the whole is
/// closed, and its thinning collapses the other pairs in the order in which that of the whole does; so it has the same
/// levels of `cutoff` and more. This holds as well where other parts, which share no cell with this one, are thinned in
/// this way at the same time, and so for several such thinnings after each other. docs/algorithms/pruning_in_parts.md.
///
/// O(n log n), on one thread; 17 bytes per vertex and edge, 8 per face and 16 per queued pair.
CellFlags certainly_removed(const KnownCells& known, double cutoff, Context* context, std::string_view stage);

}  // namespace quench::complex
