// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace quench::tree {

/// What may join two vertices.
struct ForestEdge {
  std::uint32_t a = 0, b = 0;
  double gain = 0;  ///< of keeping it: the cost of its cut; less than 0: of adding it, minus the cost of the bridge
};

/// The forest of largest gain that joins what can be joined without two marked vertices in one tree: edges in the order
/// of descending gain (ties: that of the list) wherever they join two trees, of which one at most is marked. With the
/// marked vertices taken for one this is a spanning forest, a basis of a graphic matroid, for which the greedy choice
/// is the best.
///
/// `worth`, per vertex, empty: without a limit. An edge of negative gain is only taken where the worth of the vertices
/// on each side, or of the side that is not marked, exceeds what it costs.
///
/// Returns 1 per edge that is kept. O(n log n).
std::vector<std::uint8_t> spanning_forest(std::uint32_t vertices, std::span<const ForestEdge> edges,
                                          std::span<const std::uint32_t> marked, std::span<const double> worth);

}  // namespace quench::tree
