// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "voxelization/scan_conversion.h"

namespace quench::voxelization {

using Triangle = std::array<std::uint32_t, 3>;

/// The triangles with the first point at the same position for every corner, so that equal positions are equal numbers.
/// Keeps their order; those with two equal corners are left in. O(n log n).
std::vector<Triangle> weld(std::span<const FixedPoint> points, std::span<const Triangle> triangles);

/// A side of a face.
struct FaceSide {
  std::uint32_t high;  ///< the larger of its two points
  std::uint32_t side;  ///< 3 * face + i: from corner i of the face to the next one
  bool upward;         ///< that way it runs from the smaller to the larger point
};

/// Calls visit(low, high, sides) for every edge of welded faces, in the order of (low, high); sides in the order of
/// their faces. Sides between equal points are left out. O(n log n), 12 bytes per side.
template <class Visit>
void for_each_edge(std::size_t points, std::span<const Triangle> faces, const Visit& visit) {
  std::vector<std::uint32_t> begin(points + 1, 0);
  const auto for_each_side = [&](const auto& see) {
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = faces[f][i], b = faces[f][(i + 1) % 3];
        if (a != b) see(std::min(a, b), FaceSide{std::max(a, b), 3 * f + i, a < b});
      }
  };
  for_each_side([&](std::uint32_t low, const FaceSide&) { ++begin[low + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<FaceSide> sides(begin.back());
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for_each_side([&](std::uint32_t low, const FaceSide& side) { sides[next[low]++] = side; });
  }
  for (std::uint32_t low = 0; low < points; ++low) {
    const auto from = sides.begin() + begin[low], to = sides.begin() + begin[low + 1];
    std::sort(from, to, [](const FaceSide& s, const FaceSide& t) {
      return s.high != t.high ? s.high < t.high : s.side < t.side;
    });
    for (auto e = from; e != to;) {
      const auto after = std::find_if(e, to, [&](const FaceSide& s) { return s.high != e->high; });
      visit(low, e->high, std::span<const FaceSide>(e, after));
      e = after;
    }
  }
}

/// An edge of the boundary of a surface: `times` more of its faces run from `from` to `to` than back.
struct BoundaryEdge {
  std::uint32_t from, to;
  std::int32_t times;  ///< > 0
};

/// The boundary as a chain with multiplicities, of welded faces; empty exactly when every scanline must return to 0.
std::vector<BoundaryEdge> boundary_chain(std::size_t points, std::span<const Triangle> faces);

}  // namespace quench::voxelization
