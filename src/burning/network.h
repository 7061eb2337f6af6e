// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/constants.h"
#include "base/csr.h"
#include "base/huge_pages.h"
#include "quench/burn.h"

namespace quench::burning {

using base::HugeVector;
using base::kNever;

/// Where fire is tracked: nodes on the edges of a complex, and the sectors of the link of each node (Yan 2018, sec.
/// 3.4.1; docs/algorithms/burning.md).
///
/// Nodes are the vertices, then the points that split every edge of a polygon into `pieces[e]` equal parts no longer
/// than `omega` (to 1e-12), edge by edge from the first end to the second; edges of no polygon are not split. A *state*
/// is a pair (node, sector). The states of vertices come first, then those of inserted nodes: one per node where an
/// edge has at most two polygons, else one per polygon in the order of `face_corners_at(e)`. Nodes of no polygon have
/// no state. A *corner* c is an index into `face_vertices` and `face_edges`: a polygon at one of its vertices, and its
/// side that starts there.
struct BurnNetwork {
  double omega = 0;
  std::vector<double> length;               ///< length[e]: of edge e
  std::vector<std::uint32_t> pieces;        ///< pieces[e]: number of parts of edge e
  std::vector<std::uint32_t> node_base;     ///< node_base[e]: first inserted node of edge e; edges + 1 entries
  std::vector<std::uint32_t> state_base;    ///< state_base[e]: first state of these nodes; edges + 1 entries
  std::vector<std::uint32_t> vertex_base;   ///< vertex_base[v]: first state of vertex v; vertices + 1 entries
  base::Csr<std::uint32_t> edge_corners;    ///< row e: the corners c with face_edges[c] == e, ascending
  std::vector<std::uint32_t> corner_rank;   ///< corner_rank[c]: place of c in face_corners_at(face_edges[c])
  std::vector<std::uint32_t> corner_face;   ///< corner_face[c]: the polygon of corner c
  std::vector<std::uint32_t> corner_state;  ///< corner_state[c]: state of its vertex whose sector contains c
  std::vector<char> pocket;                 ///< pocket[f]: face f lies in a closed pocket and never burns

  std::uint32_t node_count() const { return node_base.back(); }
  std::uint32_t state_count() const { return state_base.back(); }
  /// The corners whose side is the edge: one for each polygon at it.
  std::span<const std::uint32_t> face_corners_at(std::uint32_t edge) const { return edge_corners[edge]; }
  /// Number of polygons at an edge.
  std::uint32_t degree(std::uint32_t edge) const { return static_cast<std::uint32_t>(edge_corners[edge].size()); }
  /// Number of sectors of each inserted node of an edge.
  std::uint32_t sectors_of(std::uint32_t edge) const {
    const std::uint32_t faces = degree(edge);
    return faces > 2 ? faces : faces > 0;
  }
};

/// What burning finds for every state, with the network that numbers them.
struct BurnedSectors {
  BurnNetwork network;
  std::vector<double> state_time;          ///< when the sector burns; infinite in pockets
  std::vector<std::uint32_t> parent;       ///< the node its fire came from; kNone: it was free, or became free
  std::vector<std::uint32_t> parent_face;  ///< the polygon that fire crossed, or kNone
  std::vector<std::uint32_t> rank;  ///< place in the sequence in which sectors are removed from the links of their
                                    ///< nodes; kNone in pockets. Empty, as the two above, without BurnOptions::parents.
                                    ///< From a file only the order of the sectors of each vertex is known
  double step = 0;                  ///< times are the radius and a multiple of it; 0: not rounded
};

/// Polygons unfolded into the plane, with what fire needs of each side in one cache line. Polygons that are not flat or
/// not convex are projected on their mean plane, those without area on a line.
struct Polygons {
  /// The side that starts at a corner, with nodes k = 0 .. pieces along the polygon's cycle.
  struct alignas(64) Side {
    double x, y;    ///< node 0 in the polygon's plane; the cycle is counterclockwise
    double dx, dy;  ///< from each node to the next
    double length;
    std::uint32_t edge;
    std::uint32_t pieces : 31, forward : 1;  ///< forward: runs from the edge's first vertex to its second
    std::uint32_t corner_state;              ///< state of node 0
    std::uint32_t state_base;                ///< BurnNetwork::state_base of the edge
    std::uint32_t sectors, rank;             ///< of inserted nodes: their number of sectors, and that of this polygon's

    double spacing() const { return length / pieces; }
    /// Number of node k counted from the edge's first vertex.
    std::uint32_t along_edge(std::uint32_t k) const { return forward ? k : pieces - k; }
  };
  HugeVector<Side> sides;  ///< per corner
  std::vector<char> flat;  ///< per face: flat, convex and with an area, so that fronts can be unfolded into it
};

/// The links of the nodes, and the way from a state back to its place in the complex.
struct Links {
  /// Ends of the sector of a vertex state among the singular directions of its vertex, numbered per vertex from 1; 0 is
  /// the contracted pocket. Both are kNone where the sector is a closed loop.
  struct Ends {
    std::uint32_t a, b;
  };
  std::vector<Ends> ends;                ///< per vertex state
  std::vector<std::uint32_t> vertex_of;  ///< per vertex state
  base::Csr<std::uint32_t> corners;      ///< row s: the corners of the sector of vertex state s, ascending
  HugeVector<std::uint32_t> edge_of;     ///< per state of an inserted node, counted from vertex_base.back()
  /// What fire needs of an edge, in half a cache line.
  struct alignas(32) Edge {
    std::uint32_t state_base, pieces, first_corner;  ///< first_corner: in the items of BurnNetwork::edge_corners
    std::uint32_t degree : 31, pocket : 1;           ///< number of polygons at it; whether one of them is in a pocket
    std::uint32_t corner[2];                         ///< the first two of its corners
    union {
      std::uint32_t face[2];        ///< with at most two polygons: those of the two corners
      std::uint32_t first_arrival;  ///< with more: its first state among the states of `arrivals`
    };

    std::uint32_t sectors() const { return degree > 2 ? degree : degree > 0; }
  };
  HugeVector<Edge> edges;
  /// Number of states whose time can differ from the arrival of fire: those of vertices, then those inside seams.
  std::uint32_t arrivals = 0;
};

/// Per face: flat, convex and with an area above rounding.
std::vector<char> flat_faces(const CellComplex& complex, std::span<const Vec3> points);
BurnNetwork make_network(const CellComplex& complex, std::span<const Vec3> points, double omega);
Polygons make_polygons(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network);
Links make_links(const CellComplex& complex, const BurnNetwork& network);

}  // namespace quench::burning
