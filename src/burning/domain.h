// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "burning/network.h"

namespace quench::burning {

/// Whether the radius along an edge of this length can be the distance to one point.
inline bool is_distance_to_point(double r0, double r1, double length, RadiusRule rule) {
  return rule == RadiusRule::exact && std::abs(r0 - r1) <= length && length <= r0 + r1;
}

/// The complex, its network of nodes and the radius rule: read-only input of both passes of burning, and of the curves.
struct BurnDomain {
  const CellComplex& complex;
  std::span<const Vec3> points;
  std::span<const double> radius;
  const BurnNetwork& network;
  RadiusRule rule;
  Links links = make_links(complex, network);
  Polygons polygons = make_polygons(complex, points, network);

  std::uint32_t vertex_states() const { return network.vertex_base.back(); }
  /// The next corner of the same polygon.
  std::uint32_t corner_after(std::uint32_t c) const {
    const std::uint32_t f = network.corner_face[c];
    return c + 1 == complex.face_offsets[f + 1] ? complex.face_offsets[f] : c + 1;
  }
  std::uint32_t corner_before(std::uint32_t c) const {
    const std::uint32_t f = network.corner_face[c];
    return c == complex.face_offsets[f] ? complex.face_offsets[f + 1] - 1 : c - 1;
  }
  bool is_vertex(std::uint32_t state) const { return state < vertex_states(); }
  std::uint32_t edge_of(std::uint32_t state) const { return links.edge_of[state - vertex_states()]; }
  /// For the state of an inserted node: the number of the node on its edge, from 1.
  std::uint32_t place_of(std::uint32_t state, std::uint32_t edge) const {
    return (state - links.edges[edge].state_base) / links.edges[edge].sectors() + 1;
  }
  /// One of the polygons in the sector of a vertex state.
  std::uint32_t face_of(std::uint32_t vertex_state) const {
    return network.corner_face[links.corners[vertex_state].front()];
  }
  /// Whether the sector of a vertex state lies in a closed pocket.
  bool in_pocket(std::uint32_t vertex_state) const { return network.pocket[face_of(vertex_state)]; }
  double radius_inside(std::uint32_t edge, std::uint32_t place) const {
    const auto [a, b] = complex.edges[edge];
    return radius_inside_edge(radius[a], radius[b], network.length[edge],
                              static_cast<double>(place) / links.edges[edge].pieces, rule);
  }
  double radius_of(std::uint32_t state) const {
    if (is_vertex(state)) return radius[links.vertex_of[state]];
    const std::uint32_t e = edge_of(state);
    return radius_inside(e, place_of(state, e));
  }
};

/// One number per state, accessed at random.
using Times = HugeVector<double>;
/// When each state burns, and opened[s]: state s burned because the others of its link had, before fire came into it.
struct BurnTimes {
  Times times;
  std::vector<char> opened;
};

}  // namespace quench::burning
