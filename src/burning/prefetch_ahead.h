// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/prefetch.h"
#include "burning/domain.h"
#include "burning/window_queue.h"

namespace quench::burning {

/// The order pass reads memory at random, in the order of time, and cache misses are most of its cost. The queue knows
/// which states come next, so what each needs is prefetched in steps, each using what the one before fetched: from the
/// state to its edge, to the sides of its polygons, to the times of their nodes.
inline void prefetch_ahead(const StateQueue& queue, const BurnDomain& domain, const Times& times,
                           const HugeVector<unsigned char>& status) {
  const auto& links = domain.links;
  queue.peek(12, [&](std::uint32_t state) {
    base::prefetch(&times[state]);
    base::prefetch(&status[state]);
    base::prefetch(domain.is_vertex(state) ? &links.corners.offsets()[state]
                                           : &links.edge_of[state - domain.vertex_states()]);
  });
  queue.peek(9, [&](std::uint32_t state) {
    if (domain.is_vertex(state)) {
      base::prefetch(links.corners[state].data());
    } else {
      base::prefetch(&links.edges[domain.edge_of(state)]);
    }
  });
  const auto each_corner = [&](std::uint32_t state, const auto& visit) {
    if (domain.is_vertex(state)) {
      const auto corners = links.corners[state];
      for (const std::uint32_t c : corners.first(std::min<std::size_t>(4, corners.size()))) visit(c);
    } else {
      const auto& edge = links.edges[domain.edge_of(state)];
      for (std::uint32_t r = 0; r < std::min<std::uint32_t>(edge.degree, 2); ++r) visit(edge.corner[r]);
    }
  };
  const auto& sides = domain.polygons.sides;
  queue.peek(6, [&](std::uint32_t state) {
    each_corner(state, [&](std::uint32_t c) {
      base::prefetch(&domain.network.corner_face[c]);
      for (std::uint32_t i = c < 2 ? 0 : c - 2; i < std::min<std::size_t>(c + 3, sides.size()); ++i)
        base::prefetch(&sides[i]);
    });
  });
  queue.peek(3, [&](std::uint32_t state) {
    each_corner(state, [&](std::uint32_t c) {
      base::prefetch(&domain.complex.face_offsets[domain.network.corner_face[c]]);
      for (std::uint32_t i = c < 2 ? 0 : c - 2; i < std::min<std::size_t>(c + 3, sides.size()); ++i) {
        base::prefetch(&status[sides[i].corner_state]);
        if (sides[i].pieces > 1) base::prefetch(&status[sides[i].state_base]);
      }
    });
  });
}

}  // namespace quench::burning
