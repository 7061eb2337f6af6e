// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/shape.h"

namespace quench::shape {

/// The number of a pixel among the four around a lattice point: which lies towards larger x and larger y.
constexpr int corner_of(bool larger_x, bool larger_y) { return int{larger_x} + 2 * int{larger_y}; }

/// Which of the four pixels around each site are foreground, as bits of corner_of(). `sites`: lattice points of the
/// shape's plane in order of y, x. O(runs + sites).
inline std::vector<std::uint8_t> corners_of_sites(const VoxelShape& shape, std::span<const LatticePoint> sites) {
  std::vector<std::uint8_t> corners(sites.size(), 0);
  const auto add = [&](std::size_t first, std::size_t last, std::int64_t row, bool larger_y) {
    const auto runs = shape.row(row, 0);
    std::size_t r = 0;
    for (std::size_t s = first; s < last; ++s) {
      const std::int32_t x = sites[s][0];
      while (r < runs.size() && runs[r].end < x) ++r;
      if (r == runs.size()) return;
      // Runs do not touch: at most one of two that follow each other has a pixel next to x.
      const bool left = runs[r].begin < x, right = runs[r].begin <= x && x < runs[r].end;
      corners[s] |=
          static_cast<std::uint8_t>(int{left} << corner_of(false, larger_y) | int{right} << corner_of(true, larger_y));
    }
  };
  for (std::size_t first = 0, last = 0; first < sites.size(); first = last) {
    while (last < sites.size() && sites[last][1] == sites[first][1]) ++last;
    add(first, last, sites[first][1] - 1, false);
    add(first, last, sites[first][1], true);
  }
  return corners;
}

}  // namespace quench::shape
