// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace quench::burning {

/// Fire on a graph: the burning of surfaces one dimension down (Liu et al. 2011 in the plane). It starts at vertices of
/// degree 1 at their start time, runs with unit speed, stops at a junction until one branch is left there, and never
/// burns loops.
struct CurveFire {
  std::vector<double> time;         ///< per vertex: max(arrival, start); infinite where fire does not come
  std::vector<std::uint32_t> exit;  ///< per vertex: the edge over which it passed the fire on, or kNone
  std::vector<char> last;           ///< per vertex: burned last in its tree, with no edge left to pass the fire on
};

/// `of_curves`: per edge, whether it is part of the graph. `start`: per vertex, the earliest time at which it burns;
/// infinite: never, as if on a loop. `length`: per edge. Vertices of no edge burn at their start if `used`. Ties: the
/// smaller vertex first. `blocks`: where vertices with another order in space begin; threads burn shares of each, so
/// this matters for their time only. `by_arrival`: the last vertex of a tree burns when fire has come over all of its
/// edges but the one over which it would come last, which is exact however long edges are; else all but that of the
/// neighbour that burns last. O(n) and a queue for the vertices whose fire may go either way.
CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> of_curves,
                      std::span<const char> used, std::span<const double> start, std::span<const double> length,
                      std::span<const std::uint32_t> blocks = {}, bool by_arrival = false);

}  // namespace quench::burning
