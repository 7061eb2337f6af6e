// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench::simplification {

/// A simplicial complex of triangles, edges and vertices whose edges can be collapsed. Edges and triangles keep their
/// numbers, and die.
class MutableComplex {
 public:
  /// Of a complex whose faces are triangles.
  explicit MutableComplex(const CellComplex& complex);

  std::size_t edge_count() const { return edges_.size(); }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t vertices_left() const { return left_; }
  bool has_vertex(std::uint32_t v) const { return vertex_lives_[v]; }
  bool has_edge(std::uint32_t e) const { return edges_[e][0] != kNone; }
  bool has_triangle(std::uint32_t t) const { return triangles_[t][0] != kNone; }
  const std::array<std::uint32_t, 2>& ends(std::uint32_t e) const { return edges_[e]; }
  const std::array<std::uint32_t, 3>& corners(std::uint32_t t) const { return triangles_[t]; }

  /// Calls visit(e) for the edges at a vertex.
  template <class Visit>
  void for_edges(std::uint32_t v, const Visit& visit) const {
    for (std::uint32_t slot = first_edge_[v]; slot != kNone; slot = next_edge_[slot])
      if (has_edge(slot / 2)) visit(slot / 2);
  }
  template <class Visit>
  void for_triangles(std::uint32_t v, const Visit& visit) const {
    for (std::uint32_t slot = first_triangle_[v]; slot != kNone; slot = next_triangle_[slot])
      if (has_triangle(slot / 3)) visit(slot / 3);
  }
  std::uint32_t other_end(std::uint32_t e, std::uint32_t v) const { return edges_[e][edges_[e][0] == v ? 1 : 0]; }

  /// The link condition of an edge: each common neighbour of its ends is the corner of a triangle on it, and no edge is
  /// seen from both ends by triangles. Then collapsing it keeps the homotopy type
  /// (docs/algorithms/simplification.md). O(cells around its ends).
  bool may_collapse(std::uint32_t e);
  /// Makes the end `removed` of an edge, for which may_collapse() holds, one with the other.
  void collapse(std::uint32_t e, std::uint32_t removed);

 private:
  void drop_dead(std::uint32_t v);
  void mark_neighbours(std::uint32_t v);

  std::vector<std::array<std::uint32_t, 2>> edges_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  // Lists of the slots (2 e + end, 3 t + corner) in which a vertex stands.
  std::vector<std::uint32_t> first_edge_, last_edge_, next_edge_;
  std::vector<std::uint32_t> first_triangle_, last_triangle_, next_triangle_;
  std::vector<char> vertex_lives_;
  std::size_t left_ = 0;
  std::vector<std::uint32_t> mark_;  // per vertex: the last round in which it was a neighbour
  std::uint32_t round_ = 0;
  std::vector<std::array<std::uint32_t, 2>> seen_;  // scratch
};

}  // namespace quench::simplification
