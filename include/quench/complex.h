// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace quench {

/// A closed mixed-dimensional cell complex of vertices, edges and polygons, combinatorics only. Every edge of a polygon
/// is an edge of the complex. Isolated vertices, lone edges, edges of any number of polygons and closed pockets are
/// legal.
struct CellComplex {
  std::uint32_t vertex_count = 0;
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< ends, smaller index first
  std::vector<std::uint32_t> face_offsets{0};       ///< faces+1 offsets into the two arrays below
  std::vector<std::uint32_t> face_vertices;         ///< corners of each face in cyclic order
  std::vector<std::uint32_t> face_edges;            ///< face_edges[i] joins face_vertices[i] and the next corner

  /// 0 also of a complex that was moved away.
  std::size_t face_count() const { return face_offsets.empty() ? 0 : face_offsets.size() - 1; }
  std::span<const std::uint32_t> corners(std::size_t face) const {
    return {face_vertices.data() + face_offsets[face], face_vertices.data() + face_offsets[face + 1]};
  }
  std::span<const std::uint32_t> sides(std::size_t face) const {
    return {face_edges.data() + face_offsets[face], face_edges.data() + face_offsets[face + 1]};
  }

  /// Throws Error(invariant) naming the first relation that does not hold: index ranges, ends in order, no duplicate
  /// edge or face, at least three distinct corners per face, sides join consecutive corners.
  void validate() const;
};

/// One value per cell of a complex, by dimension.
struct CellValues {
  std::vector<double> vertex, edge, face;

  bool empty() const { return vertex.empty() && edge.empty() && face.empty(); }
  /// Whether there is a value for each cell.
  bool complete(const CellComplex& complex) const {
    return vertex.size() == complex.vertex_count && edge.size() == complex.edges.size() &&
           face.size() == complex.face_count();
  }
  friend bool operator==(const CellValues&, const CellValues&) = default;
};

/// Builds the edge table of a complex given by corner cycles, extra edges and a vertex count. Repeated edges are
/// merged; faces are kept as they are. Edges are sorted by their ends. O(n log n). Throws Error(input) when an index is
/// out of range or a face has fewer than three corners.
CellComplex make_complex(std::uint32_t vertex_count, std::span<const std::array<std::uint32_t, 2>> edges,
                         std::vector<std::uint32_t> face_offsets, std::vector<std::uint32_t> face_vertices);

/// Euler characteristic and Betti numbers (components, independent loops, cavities), over Z/2.
struct Topology {
  std::int64_t euler = 0;
  std::array<std::int64_t, 3> betti{0, 0, 0};
  friend bool operator==(const Topology&, const Topology&) = default;
};

/// Topology of a closed complex: euler = V - E + F; b2 = dimension of the Z/2 2-cycles, computed on what is left after
/// collapsing free faces. Near-linear unless closed pockets share many non-manifold edges.
Topology topology(const CellComplex& complex);

}  // namespace quench
