// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "quench/burn.h"

namespace quench::burning {

/// Polygons laid flat: the corners of each polygon in its own plane, in the order of the complex. A polygon that is not
/// flat, not convex or of no area has no plane.
struct Planes {
  std::vector<std::array<double, 2>> corner;
  std::vector<char> flat;  ///< of each face
};

BurnNetwork make_network(const CellComplex& complex, std::span<const Vec3> points, double omega,
                         Propagation propagation);
Planes make_planes(const CellComplex& complex, std::span<const Vec3> points);

/// A network with what else the fire needs to find its way: from states to their place, and the link of every vertex.
struct Links {
  /// Ends of each vertex state's sector among the singular directions of its vertex, numbered per vertex from 1; 0 is
  /// the contracted pocket (SPEC 5), kNone for a closed loop.
  struct Ends {
    std::uint32_t a, b;
  };
  std::vector<Ends> ends;                     ///< per vertex state
  std::vector<std::uint32_t> vertex_of;       ///< per vertex state
  std::vector<std::uint32_t> corner_offsets;  ///< vertex states + 1, into
  std::vector<std::uint32_t> corner_list;     ///< the corners of each vertex state's sector, ascending
  std::vector<std::uint32_t> edge_of;         ///< per state of an inserted node, from vertex_base.back()
  /// What the fire asks of an edge, in one place in memory.
  struct Edge {
    std::uint32_t state_base, pieces, sectors, first_side, degree;
    std::uint32_t corner[2];  ///< the first two of its sides
    bool pocket;              ///< some polygon at it is in a pocket
  };
  std::vector<Edge> edges;
};
Links make_links(const CellComplex& complex, const BurnNetwork& network);

/// Builds the sectors of every vertex into `network` (vertex_base, corner_state).
void number_sectors(const CellComplex& complex, BurnNetwork& network);

}  // namespace quench::burning
