// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "dual/cells.h"
#include "quench/error.h"

namespace quench::dual {

[[noreturn]] inline void star_does_not_close() {
  throw Error(ErrorCode::invariant, "the polytopes around an edge of the voxel core's dual do not close up");
}

/// Walks around a Delaunay edge from a to b. A half-edge from a to b, seen from outside its polytope, has its facet on
/// the left: crossing that leads counter-clockwise around the direction from a to b. From `polytope` that leads to
/// `next`; returned is the half-edge of that one from a to b. O(facets of `next`).
inline std::uint32_t halfedge_after(const Cells& cells, const Hulls& hulls, std::uint32_t polytope, std::uint32_t next,
                                    std::uint32_t b) {
  const Hull& hull = hulls[cells.hull[next]];
  const auto neighbours = cells.neighbours_of(next);
  const auto sites = cells.sites_of(next);
  // Two polytopes share one facet; in it the edge runs from b to a.
  std::uint32_t facet = 0;
  while (facet < neighbours.size() && neighbours[facet] != polytope) ++facet;
  if (facet == neighbours.size()) star_does_not_close();
  std::uint32_t from_b = hull.facet_begin[facet];
  const std::uint32_t end = hull.facet_begin[facet + 1];
  while (from_b < end && sites[hull.origin[from_b]] != b) ++from_b;
  if (from_b == end) star_does_not_close();
  return hull.twin[from_b];
}

}  // namespace quench::dual
