// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "burn/network.h"

namespace quench::burning {

/// One side of a polygon as the fire sees it: its nodes k = 0 .. pieces along the polygon's cycle, with positions (in
/// the polygon's plane; in space for polygons without one) and states in this polygon's sectors.
struct Side {
  Vec3 start, step;  ///< of node 0; from node to node
  double length;
  std::uint32_t corner, edge, pieces;
  std::uint32_t first_state, last_state;  ///< of nodes 0 and `pieces`
  std::uint32_t base, stride, rank;       ///< states of inserted nodes
  std::uint32_t before;                   ///< nodes of the polygon on the sides before this one
  bool forward;                           ///< runs from the edge's first vertex

  Vec3 at(double k) const { return start + step * k; }
  double spacing() const { return length / pieces; }
  /// Place of node k counted from the edge's first vertex.
  std::uint32_t along_edge(std::uint32_t k) const { return forward ? k : pieces - k; }
  std::uint32_t state(std::uint32_t k) const {
    if (k == 0) return first_state;
    if (k == pieces) return last_state;
    return base + (along_edge(k) - 1) * stride + rank;
  }
};

/// A polygon opened for reading.
struct PolygonView {
  std::uint32_t face = kNone;
  bool flat = false;
  std::vector<Side> sides;
  std::uint32_t nodes = 0;  ///< on its boundary

  void load(std::uint32_t f, const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
            const Planes& planes) {
    face = f;
    flat = planes.flat[f];
    const std::uint32_t first = complex.face_offsets[f], end = complex.face_offsets[f + 1];
    const auto place = [&](std::uint32_t c) -> Vec3 {
      if (!flat) return points[complex.face_vertices[c]];
      return {planes.corner[c][0], planes.corner[c][1], 0};
    };
    sides.resize(end - first);
    nodes = 0;
    Vec3 here = place(first);
    for (std::uint32_t c = first; c < end; ++c) {
      const std::uint32_t next = c + 1 == end ? first : c + 1;
      const Vec3 there = place(next);
      Side& s = sides[c - first];
      s.corner = c;
      s.edge = complex.face_edges[c];
      s.pieces = network.pieces[s.edge];
      s.start = here;
      s.step = (there - here) / s.pieces;
      s.length = network.length[s.edge];
      s.forward = complex.edges[s.edge][0] == complex.face_vertices[c];
      s.first_state = network.corner_state[c];
      s.last_state = network.corner_state[next];
      s.base = network.state_base[s.edge];
      s.stride = network.sectors_of(s.edge);
      s.rank = s.stride > 1 ? network.side_rank[c] : 0;
      s.before = nodes;
      nodes += s.pieces;
      here = there;
    }
  }
  std::size_t side_after(std::size_t i) const { return i + 1 == sides.size() ? 0 : i + 1; }
  std::size_t side_before(std::size_t i) const { return i == 0 ? sides.size() - 1 : i - 1; }
};

}  // namespace quench::burning
