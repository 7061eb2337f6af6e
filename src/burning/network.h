// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/huge_pages.h"
#include "quench/burn.h"

namespace quench::burning {

/// Polygons laid flat, and what the fire asks of each side in one line of memory. Polygons that are not flat or not
/// convex are projected on their mean plane, those of no area on a line.
struct Polygons {
  /// Of the side that starts at a corner, with nodes k = 0 .. pieces along the polygon's cycle.
  struct alignas(64) Side {
    double x, y, dx, dy;  ///< node 0 in the polygon's plane, counterclockwise; from node to node
    double length;
    std::uint32_t edge;
    std::uint32_t pieces : 31, forward : 1;  ///< forward: runs from the edge's first vertex
    std::uint32_t corner_state, state_base;  ///< of node 0; of the edge
    std::uint32_t sectors, rank;             ///< of inserted nodes; the rank of this polygon's

    double spacing() const { return length / pieces; }
    /// Place of node k counted from the edge's first vertex.
    std::uint32_t along_edge(std::uint32_t k) const { return forward ? k : pieces - k; }
  };
  base::HugeVector<Side> sides;  ///< per corner
  std::vector<char> flat;        ///< per face: flat, convex and with an area; fronts can be unfolded into it
};

BurnNetwork make_network(const CellComplex& complex, std::span<const Vec3> points, double omega,
                         Propagation propagation);
Polygons make_polygons(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network);

/// A network with what else the fire needs to find its way: from states to their place, and the link of every vertex.
struct Links {
  /// Ends of each vertex state's sector among the singular directions of its vertex, numbered per vertex from 1; 0 is
  /// the contracted pocket, kNone for a closed loop.
  struct Ends {
    std::uint32_t a, b;
  };
  std::vector<Ends> ends;                     ///< per vertex state
  std::vector<std::uint32_t> vertex_of;       ///< per vertex state
  std::vector<std::uint32_t> corner_offsets;  ///< vertex states + 1, into
  std::vector<std::uint32_t> corner_list;     ///< the corners of each vertex state's sector, ascending
  base::HugeVector<std::uint32_t> edge_of;    ///< per state of an inserted node, from vertex_base.back()
  /// What the fire asks of an edge, in half a line of memory.
  struct alignas(32) Edge {
    std::uint32_t state_base, pieces, first_side;
    std::uint32_t degree : 31, pocket : 1;  ///< polygons at it; some of them is in a pocket
    std::uint32_t corner[2];                ///< the first two of its sides
    union {
      std::uint32_t face[2];        ///< with at most two polygons: those
      std::uint32_t first_arrival;  ///< with more: place of its first state among the states of `arrivals`
    };

    std::uint32_t sectors() const { return degree > 2 ? degree : degree > 0; }
  };
  base::HugeVector<Edge> edges;
  /// States whose times may differ from the arrival of fire: those of vertices, then those inside seams.
  std::uint32_t arrivals = 0;
};
Links make_links(const CellComplex& complex, const BurnNetwork& network);

/// Builds the sectors of every vertex into `network` (vertex_base, corner_state).
void number_sectors(const CellComplex& complex, BurnNetwork& network);

}  // namespace quench::burning
