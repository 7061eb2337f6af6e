// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/skeleton.h"

namespace quench::skeleton {

/// Cells of K that a member of the family has in part: sheets end along straight cuts.
struct SheetCut {
  struct Point {
    std::uint32_t edge;
    double along;  ///< from the first end of the edge, 0, to the second, 1
  };
  struct Piece {
    std::uint32_t edge;
    std::array<std::uint32_t, 2> ends;  ///< in the order of those of the edge
  };
  /// What is left of a face: its corners from the point `in` on, as far as the point `out`.
  struct Chord {
    std::uint32_t face, in, out;
  };
  /// An edge with its pieces in order.
  struct Split {
    std::uint32_t edge, first, count;
  };
  std::vector<Point> points;  ///< vertices of the member behind those of K
  std::vector<Piece> pieces;  ///< edges of the member behind those of K
  std::vector<Chord> chords;  ///< by face
  std::vector<Split> splits;  ///< by edge

  const Chord& chord_of(std::uint32_t face) const {
    return *std::lower_bound(chords.begin(), chords.end(), face,
                             [](const Chord& c, std::uint32_t f) { return c.face < f; });
  }
  const Split& split_of(std::uint32_t edge) const {
    return *std::lower_bound(splits.begin(), splits.end(), edge,
                             [](const Split& s, std::uint32_t e) { return s.edge < e; });
  }
};

/// The cells of K that a member of the family has.
struct Member {
  enum : char { kNo, kWhole, kInPart };
  std::vector<char> vertex, edge, face;  ///< edges in part are there as pieces
  SheetCut cut;
};

Member member_of(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options);
/// The cells that all members have together from these thetas on, with parts of polygons that are whole.
Member cells_from(const SkeletonFamily& family, double theta2, double theta1);

/// Of an edge of a member, one of K or a piece: the edge of K, and its ends.
inline std::uint32_t edge_in_k(const RefinedAxis& k, const Member& member, std::uint32_t e) {
  const std::size_t edges = k.complex.edges.size();
  return e < edges ? e : member.cut.pieces[e - edges].edge;
}
inline const std::array<std::uint32_t, 2>& ends_of(const RefinedAxis& k, const Member& member, std::uint32_t e) {
  const std::size_t edges = k.complex.edges.size();
  return e < edges ? k.complex.edges[e] : member.cut.pieces[e - edges].ends;
}

inline std::uint32_t other_end(const RefinedAxis& k, std::uint32_t edge, std::uint32_t vertex) {
  const auto [a, b] = k.complex.edges[edge];
  return a == vertex ? b : a;
}

}  // namespace quench::skeleton
