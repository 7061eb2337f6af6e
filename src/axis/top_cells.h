// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/axis.h"

namespace quench::axis {

/// The two nearest sites of the cells of the largest dimension: of each face, in a plane of each edge. These cells are
/// the first ones of TopCells.
inline const std::vector<std::array<std::uint32_t, 2>>& top_sites(const MedialAxis& axis) {
  return axis.grid.is_plane() ? axis.edge_sites : axis.face_sites;
}

/// The cells that no larger cell contains, as one list: faces, edges, vertices. Most edges and vertices have the value
/// kNoTopCell (axis/measures.h), and are not among them.
class TopCells {
 public:
  TopCells(const CellComplex& complex, CellValues& value) : complex_(complex), value_(value) {}

  std::uint32_t count() const {
    return static_cast<std::uint32_t>(value_.face.size() + value_.edge.size() + value_.vertex.size());
  }
  double& value(std::uint32_t cell) const {
    if (cell < faces()) return value_.face[cell];
    if (cell < faces() + edges()) return value_.edge[cell - faces()];
    return value_.vertex[cell - faces() - edges()];
  }
  template <class Visit>
  void for_corners(std::uint32_t cell, const Visit& visit) const {
    if (cell < faces())
      for (const std::uint32_t v : complex_.corners(cell)) visit(v);
    else if (cell < faces() + edges())
      for (const std::uint32_t v : complex_.edges[cell - faces()]) visit(v);
    else
      visit(cell - faces() - edges());
  }
  std::uint32_t first_corner(std::uint32_t cell) const {
    std::uint32_t first = kNone;
    for_corners(cell, [&](std::uint32_t v) { first = first == kNone ? v : first; });
    return first;
  }

 private:
  std::uint32_t faces() const { return static_cast<std::uint32_t>(value_.face.size()); }
  std::uint32_t edges() const { return static_cast<std::uint32_t>(value_.edge.size()); }
  const CellComplex& complex_;
  CellValues& value_;
};

}  // namespace quench::axis
