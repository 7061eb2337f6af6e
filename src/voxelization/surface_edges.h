// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/csr.h"
#include "voxelization/scan_conversion.h"

namespace quench::voxelization {

using Triangle = std::array<std::uint32_t, 3>;

/// The triangles with every corner replaced by the first point at the same position, so that equal positions have equal
/// numbers.
/// Keeps their order, and those with two equal corners. O(n log n).
std::vector<Triangle> weld(std::span<const FixedPoint> points, std::span<const Triangle> triangles);

/// A side of a face.
struct FaceSide {
  std::uint32_t high;  ///< the larger of its two points
  std::uint32_t side;  ///< 3 * face + i: from corner i of the face to the next one
};

/// Whether a side runs from the smaller to the larger point.
inline bool is_upward(std::span<const Triangle> faces, std::uint32_t side) {
  const Triangle& face = faces[side / 3];
  return face[side % 3] < face[(side + 1) % 3];
}

/// Calls visit(low, high, sides) for every edge of welded faces, in the order of (low, high); sides in the order of
/// their faces. Sides between equal points are left out. O(n log n), 8 bytes per side.
template <class Visit>
void for_each_edge(std::size_t points, std::span<const Triangle> faces, const Visit& visit) {
  auto sides = base::Csr<FaceSide>::group(points, [&](const auto& emit) {
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = faces[f][i], b = faces[f][(i + 1) % 3];
        if (a != b) emit(std::min(a, b), {std::max(a, b), 3 * f + i});
      }
  });
  for (std::uint32_t low = 0; low < points; ++low) {
    const std::span<FaceSide> at = sides[low];
    std::sort(at.begin(), at.end(), [](const FaceSide& s, const FaceSide& t) {
      return s.high != t.high ? s.high < t.high : s.side < t.side;
    });
    for (auto e = at.begin(); e != at.end();) {
      const auto after = std::find_if(e, at.end(), [&](const FaceSide& s) { return s.high != e->high; });
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

/// Per point the edges of a chain that leave it.
base::Csr<std::uint32_t> edges_from(std::size_t points, std::span<const BoundaryEdge> chain);

}  // namespace quench::voxelization
