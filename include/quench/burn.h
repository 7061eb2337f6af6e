// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"

namespace quench {

/// How fire crosses a polygon. Both use the same nodes, sectors and sector times.
enum class Propagation {
  segments,  ///< two neighbouring burned nodes send the unfolded source of their front between them: the default
  nodes      ///< along straight arcs from node to node only: an upper bound that converges with the spacing
};

/// The radius at nodes inside an edge.
enum class RadiusRule {
  exact,  ///< distance to a point the edge's ends share as nearest: R^2 = (1-t)R0^2 + tR1^2 - t(1-t)L^2
  linear  ///< for medial axes whose ends share no nearest point
};

struct BurnOptions {
  double omega = 0;  ///< largest distance of neighbouring nodes on an edge, world units; 0: default_omega()
  Propagation propagation = Propagation::segments;
  RadiusRule radius = RadiusRule::exact;
  bool parents = true;  ///< also find the burn sequence: parents of prime sectors, which medial curves need
};

/// Where fire is tracked: nodes on the edges of a complex, and in the link of each node its sectors (Yan 2018, sec.
/// 3.4.1; docs/algorithms/burning.md).
///
/// Nodes are the vertices, then the points that split every edge of a polygon into `pieces[e]` equal parts no longer
/// than `omega` (to 1e-12), edge by edge from the first end to the second; edges of no polygon are not split. A *state*
/// is a pair (node, sector): the states of vertices first, then those of inserted nodes, one per node where an edge has
/// at most two polygons, else one per polygon in the order of `faces_of(e)`. Nodes with no polygon have no state.
struct BurnNetwork {
  double omega = 0;
  std::vector<double> length;                          ///< of each edge
  std::vector<std::uint32_t> pieces;                   ///< of each edge
  std::vector<std::uint32_t> node_base;                ///< edges + 1: first inserted node of each edge
  std::vector<std::uint32_t> state_base;               ///< edges + 1: first state of the inserted nodes of each edge
  std::vector<std::uint32_t> vertex_base;              ///< vertices + 1: first state of each vertex
  std::vector<std::uint32_t> side_offsets, side_list;  ///< CSR: the corners c with face_edges[c] == e, ascending
  std::vector<std::uint32_t> side_rank;     ///< of each corner c: its place among the sides of edge face_edges[c]
  std::vector<std::uint32_t> corner_face;   ///< of each corner
  std::vector<std::uint32_t> corner_state;  ///< of each corner: the state of its vertex whose sector has it
  std::vector<char> pocket;                 ///< of each face: in a closed pocket, never burns

  std::uint32_t node_count() const { return node_base.back(); }
  std::uint32_t state_count() const { return state_base.back(); }
  /// The corners c (sides) of the polygons at an edge.
  std::span<const std::uint32_t> sides_of(std::uint32_t edge) const {
    return {side_list.data() + side_offsets[edge], side_list.data() + side_offsets[edge + 1]};
  }
  /// Sectors of each inserted node of an edge.
  std::uint32_t sectors_of(std::uint32_t edge) const {
    const std::uint32_t degree = side_offsets[edge + 1] - side_offsets[edge];
    return degree > 2 ? degree : degree > 0;
  }
};

/// What the fire leaves behind. Times are in world units; infinite where no fire comes (closed pockets).
struct Burning {
  BurnOptions options;  ///< with the spacing that was used
  BurnNetwork network;
  std::vector<double> state_time;          ///< per state: when the sector burns
  std::vector<std::uint32_t> parent;       ///< per state: the node its fire came from; kNone: it opened by itself
  std::vector<std::uint32_t> parent_face;  ///< per state: the polygon that fire crossed, or kNone; both empty if not
                                           ///< asked for
  std::vector<std::uint32_t> rank;         ///< per state: place in the sequence in which sectors leave the links of
                                           ///< their nodes; kNone in pockets; empty if no parents were asked for
  std::vector<double> burn_time;           ///< per vertex: the largest time of its sectors; the radius if none
  std::vector<double> erosion_thickness;   ///< per vertex: burn_time - radius
  double max_burn_time = 0;                ///< largest finite one
  std::uint32_t unburned = 0;              ///< vertices with infinite burn time
};

/// Burns a complex of convex polygons with a radius per vertex (Yan 2018, ch. 3, with times per sector of a
/// link, see docs/algorithms/burning.md, in place of Algorithm 1): fire starts on the free edges at the time of the
/// radius, runs with unit speed, dies at a seam while two or more sheets are left, and goes on in the last one.
///
/// Deterministic. Near O(n log n) in nodes for polygons of few nodes; about 160 bytes per node, up to 300
/// where most of the axis is noise. Polygons flatter than
/// 1e-12 of a side, or not convex, are crossed along node arcs only. Throws Error(input) for a radius that is negative
/// or no number, Error(failed) when there are more than 2^32 states, Error(usage) for a negative spacing.
Burning burn(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
             const BurnOptions& options = {}, Context* context = nullptr);

/// The spacing of nodes that `burn` takes where none is given: 0.35 of the mean edge for triangles, whose diagonals are
/// long, 0.5 for other polygons. The mean error of erosion thickness is then 0.2 to 0.4% (docs/algorithms/burning.md).
double default_omega(const CellComplex& complex, std::span<const Vec3> points);

/// Predicted peak of memory of burn(), in bytes, without that of its input.
std::int64_t predicted_burn_bytes(const CellComplex& complex, std::span<const Vec3> points, const BurnOptions& options);

/// Adds the result to the file the axis came from (vertex v is row v): point arrays `burn_time`, `erosion_thickness`,
/// `unburned` (1 where infinite; the largest finite value is written there), field arrays `omega`, `propagation`,
/// `radius_rule`, `burn_nodes`, `max_burn_time`. Arrays of these names are replaced.
void add_burning(Record& data, const Burning& burning);

/// Radius at a node inside an edge, `t` from the first end in [0, 1]; linear where the ends cannot share a nearest
/// point (|R0 - R1| > L or L > R0 + R1).
double radius_inside_edge(double r0, double r1, double length, double t, RadiusRule rule);

}  // namespace quench
