// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/prefetch.h"
#include "burning/fire.h"

namespace quench::burning {

/// The burn sequence jumps through memory in the order of time, and waiting for memory is most of its cost. The queue
/// knows what comes next, so what each state needs is fetched in three steps ahead of it, each using what the one
/// before brought: from the state to its edge, to the sides of its polygons, to the times of their nodes.
inline void prefetch_ahead(const StateQueue& queue, const Site& site, const Times& times) {
  const double* per_state = times.data();
  const auto& links = site.links;
  queue.peek(12, [&](std::uint32_t state) {
    base::prefetch(per_state + state);
    base::prefetch(site.is_vertex(state) ? &links.corner_offsets[state] : &links.edge_of[state - site.vertex_states()]);
  });
  queue.peek(9, [&](std::uint32_t state) {
    if (site.is_vertex(state)) {
      base::prefetch(&links.corner_list[links.corner_offsets[state]]);
    } else {
      base::prefetch(&links.edges[site.edge_of(state)]);
    }
  });
  const auto each_corner = [&](std::uint32_t state, const auto& visit) {
    if (site.is_vertex(state)) {
      const std::uint32_t first = links.corner_offsets[state];
      const std::uint32_t end = std::min(first + 4, links.corner_offsets[state + 1]);
      for (std::uint32_t i = first; i < end; ++i) visit(links.corner_list[i]);
    } else {
      const auto& edge = links.edges[site.edge_of(state)];
      for (std::uint32_t r = 0; r < std::min<std::uint32_t>(edge.degree, 2); ++r) visit(edge.corner[r]);
    }
  };
  const auto& sides = site.polygons.sides;
  queue.peek(6, [&](std::uint32_t state) {
    each_corner(state, [&](std::uint32_t c) {
      base::prefetch(&site.network.corner_face[c]);
      for (std::uint32_t i = c < 2 ? 0 : c - 2; i < std::min<std::size_t>(c + 3, sides.size()); ++i)
        base::prefetch(&sides[i]);
    });
  });
  queue.peek(3, [&](std::uint32_t state) {
    each_corner(state, [&](std::uint32_t c) {
      base::prefetch(&site.complex.face_offsets[site.network.corner_face[c]]);
      for (std::uint32_t i = c < 2 ? 0 : c - 2; i < std::min<std::size_t>(c + 3, sides.size()); ++i) {
        base::prefetch(per_state + sides[i].corner_state);
        if (sides[i].pieces > 1) base::prefetch(per_state + sides[i].state_base);
      }
    });
  });
}

}  // namespace quench::burning
