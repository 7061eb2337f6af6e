// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace quench::burning {

/// Fire on a graph: the burning of surfaces one dimension down (Liu et al. 2011 in the plane). It starts at free ends
/// at their time, runs with unit speed, dies at a junction unless one branch is left, and never burns loops.
struct CurveFire {
  std::vector<double> time;         ///< per vertex: max(arrival, start); infinite where fire does not come
  std::vector<std::uint32_t> exit;  ///< per vertex: the edge over which it passed the fire on, or kNone
  std::vector<char> last;           ///< per vertex: burned last in its tree, with nothing left to pass fire to
};

/// `start`: per vertex, no burning before it; infinite: fixed, as if on a loop. `length`: per edge. Vertices of no edge
/// burn at their start if `used`. Ties: the smaller vertex first. O(n log n).
CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> used,
                      std::span<const double> start, std::span<const double> length);

}  // namespace quench::burning
