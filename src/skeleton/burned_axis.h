// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "burning/network.h"
#include "quench/burn.h"
#include "quench/complex.h"

namespace quench::skeleton {

/// A burned medial axis: what its refinement is made from.
struct BurnedAxis {
  const CellComplex& complex;
  std::span<const Vec3> points;
  std::span<const double> radius;
  const burning::BurnedSectors& burned;
  const burning::BurnNetwork& network;
  RadiusRule rule;

  std::uint32_t pieces(std::uint32_t edge) const { return network.pieces[edge]; }
  Vec3 on_edge(std::uint32_t edge, double t) const {
    const auto [a, b] = complex.edges[edge];
    return points[a] * (1 - t) + points[b] * t;
  }
  double radius_on_edge(std::uint32_t edge, double t) const {
    const auto [a, b] = complex.edges[edge];
    return radius_inside_edge(radius[a], radius[b], network.length[edge], t, rule);
  }
  /// Whether the side that starts at a corner runs from the first vertex of its edge to the second.
  bool forward(std::uint32_t corner) const {
    return complex.edges[complex.face_edges[corner]][0] == complex.face_vertices[corner];
  }
  /// The node `along` an edge, counted from its first vertex.
  std::uint32_t node_on_edge(std::uint32_t edge, std::uint32_t along) const {
    if (along == 0) return complex.edges[edge][0];
    return along == pieces(edge) ? complex.edges[edge][1] : network.node_base[edge] + along - 1;
  }
  /// The state of the node `along` the edge of a side, in the sector of the side's polygon.
  std::uint32_t state_on_side(std::uint32_t corner, std::uint32_t along) const {
    const std::uint32_t e = complex.face_edges[corner];
    if (along == 0 || along == pieces(e)) {
      const std::uint32_t f = network.corner_face[corner];
      const bool at_start = (along == 0) == forward(corner);
      const std::uint32_t next = corner + 1 == complex.face_offsets[f + 1] ? complex.face_offsets[f] : corner + 1;
      return network.corner_state[at_start ? corner : next];
    }
    const std::uint32_t sectors = network.sectors_of(e);
    return network.state_base[e] + (along - 1) * sectors + (sectors > 1 ? network.corner_rank[corner] : 0);
  }
};

/// A polygon of a burned axis with the nodes of its boundary in order, by *place*, and the prime arcs in it. A segment
/// has the place of its first node.
class PolygonArcs {
 public:
  struct Chord {
    std::uint32_t from, to, edge;  ///< places, from < to; `edge` is left to the caller
  };
  std::vector<std::uint32_t> node, state, door;  ///< per place; door: of the segment, counted from 0
  std::vector<char> prime;                       ///< per place: a prime arc runs along the segment
  std::vector<Chord> chords;                     ///< the other prime arcs, in the order of their sectors' places
  std::uint32_t primes = 0;                      ///< segments with a prime arc

  std::uint32_t size() const { return static_cast<std::uint32_t>(node.size()); }

  /// `door_base`: per edge, its first door.
  void load(const BurnedAxis& axis, std::span<const std::uint32_t> door_base, std::uint32_t f) {
    const CellComplex& m = axis.complex;
    node.clear();
    state.clear();
    door.clear();
    for (std::uint32_t c = m.face_offsets[f]; c < m.face_offsets[f + 1]; ++c) {
      const std::uint32_t e = m.face_edges[c], pieces = axis.pieces(e);
      const bool forward = axis.forward(c);
      for (std::uint32_t k = 0; k < pieces; ++k) {
        const std::uint32_t along = forward ? k : pieces - k;
        node.push_back(axis.node_on_edge(e, along));
        state.push_back(axis.state_on_side(c, along));
        door.push_back(door_base[e] + (forward ? k : along - 1));
      }
    }
    find_arcs(axis.burned, f);
  }

 private:
  void find_arcs(const burning::BurnedSectors& burned, std::uint32_t f) {
    const std::uint32_t n = size();
    prime.assign(n, 0);
    chords.clear();
    for (std::uint32_t p = 0; p < n; ++p) {
      if (burned.parent_face[state[p]] != f) continue;
      const auto q =
          static_cast<std::uint32_t>(std::find(node.begin(), node.end(), burned.parent[state[p]]) - node.begin());
      if (q == (p + 1) % n)
        prime[p] = 1;
      else if (p == (q + 1) % n)
        prime[q] = 1;
      else
        chords.push_back({std::min(p, q), std::max(p, q), 0});
    }
    primes = static_cast<std::uint32_t>(std::count(prime.begin(), prime.end(), 1));
  }
};

}  // namespace quench::skeleton
