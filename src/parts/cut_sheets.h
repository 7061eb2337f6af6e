// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace quench::parts {

/// A side of a triangle: from its corner `side` to the next. Ends by their numbers, the smaller first.
struct TriangleSide {
  std::uint32_t a, b, triangle;
  std::uint8_t side;
};
/// All sides, those of one edge together, by their ends and triangles. O(n log n), on all threads.
std::vector<TriangleSide> sorted_sides(std::span<const std::array<std::uint32_t, 3>> triangles);

/// Calls visit(sides) for every edge, with the sides that are there.
template <class Visit>
void each_edge(std::span<const TriangleSide> sides, const Visit& visit) {
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    while (next < sides.size() && sides[next].a == sides[i].a && sides[next].b == sides[i].b) ++next;
    visit(sides.subspan(i, next - i));
  }
}

/// Triangles cut off from each other along all edges that have not exactly two of them: sheets by themselves, each a
/// manifold.
struct CutSheets {
  /// Per corner of a triangle (3 t + c): its vertex. Numbered in the order of corners.
  std::vector<std::uint32_t> vertex;
  std::uint32_t vertices = 0;
  std::vector<std::uint32_t> corner_of;  ///< per vertex: its first corner
  std::vector<char> turned;          ///< per triangle: to be turned so that neighbours go round one way where they can
  std::vector<char> inconsistent;    ///< per triangle: its sheet has none such
  std::vector<std::uint32_t> sheet;  ///< per triangle: the least triangle of its sheet
};
/// O(n log n).
CutSheets cut_sheets(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const TriangleSide> sides);

}  // namespace quench::parts
