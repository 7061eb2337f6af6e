// SPDX-License-Identifier: Apache-2.0
#include "shape/cell_loops.h"

namespace quench::shape {
namespace {

// The corners of the faces, anticlockwise seen from outside the cell.
constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

constexpr int edge_between(int a, int b) {
  for (int edge = 0; edge < kCellEdges; ++edge) {
    const auto ends = corners_of_edge(edge);
    if ((ends[0] == a && ends[1] == b) || (ends[0] == b && ends[1] == a)) return edge;
  }
  return -1;
}

// Around a face, the surface runs from the edge where the foreground begins to the edge where it ends. An edge is
// passed one way in one of its faces and the other way in the other, so every edge that is met has one successor.
constexpr CellLoops loops_of(int foreground) {
  std::array<int, kCellEdges> next{};
  next.fill(-1);
  for (const auto& face : kFaces)
    for (int i = 0; i < 4; ++i) {
      const auto is_foreground = [&](int k) { return (foreground >> face[k & 3] & 1) != 0; };
      if (is_foreground(i + 3) || !is_foreground(i)) continue;
      int last = i;
      while (is_foreground(last + 1)) ++last;
      next[static_cast<std::size_t>(edge_between(face[(i + 3) & 3], face[i]))] =
          edge_between(face[last & 3], face[(last + 1) & 3]);
    }
  CellLoops loops;
  std::size_t used = 0;
  for (std::size_t edge = 0; edge < kCellEdges; ++edge) {
    if (next[edge] < 0) continue;
    std::uint8_t length = 0;
    for (std::size_t e = edge; next[e] >= 0; ++length) {
      loops.edges[used++] = static_cast<std::uint8_t>(e);
      const auto after = static_cast<std::size_t>(next[e]);
      next[e] = -1;
      e = after;
    }
    loops.length[loops.count++] = length;
  }
  const int background = ~foreground & 255;
  for (int corner = 0; corner < 4; ++corner) loops.tube |= background == (1 << corner | 1 << (7 - corner));
  return loops;
}

}  // namespace

const std::array<CellLoops, 256>& cell_loops() {
  static const std::array<CellLoops, 256> table = [] {
    std::array<CellLoops, 256> all;
    for (int foreground = 0; foreground < 256; ++foreground)
      all[static_cast<std::size_t>(foreground)] = loops_of(foreground);
    return all;
  }();
  return table;
}

}  // namespace quench::shape
