// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "base/union_find.h"
#include "quench/shape.h"

// Notation: a *run* is a maximal interval of foreground along x, a *gap* the background between two runs of one
// scanline. The background before the first and after the last run of a scanline, and every empty scanline, is
// connected to the outside of the grid.

namespace quench {
namespace {

using Runs = std::span<const Run>;

/// Calls visit(a, b, i, j) for every pair of overlapping intervals a[i], b[j], in order of x.
template <class Visit>
void overlaps(Runs a, Runs b, const Visit& visit) {
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].begin < b[j].end && b[j].begin < a[i].end) visit(i, j);
    a[i].end < b[j].end ? ++i : ++j;
  }
}

void intersect(Runs a, Runs b, std::vector<Run>& result) {
  result.clear();
  overlaps(a, b, [&](std::size_t i, std::size_t j) {
    result.push_back({std::max(a[i].begin, b[j].begin), std::min(a[i].end, b[j].end)});
  });
}

/// Euler characteristic. Along a scanline an interval of n voxels has n - 1 adjacent pairs, so it counts 1, and the
/// same holds for the intervals in which two or four neighbouring scanlines are full (pairs and x-squares, squares and
/// cubes). The alternating sum of cubes, squares, edges and vertices
/// is therefore: runs - common intervals of two scanlines + common intervals of four.
std::int64_t euler_characteristic(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  std::int64_t euler = static_cast<std::int64_t>(shape.runs().size());
  std::vector<Run> pair, next_pair, common;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    std::int64_t pair_of = -1;  // the y for which `pair` holds the common intervals of (y, z) and (y, z+1)
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      const Runs row = shape.row(y, z);
      if (row.empty()) continue;
      const Runs ahead = shape.row(y + 1, z);
      overlaps(row, ahead, [&](std::size_t, std::size_t) { --euler; });
      if (pair_of != y) intersect(row, shape.row(y, z + 1), pair);
      euler -= static_cast<std::int64_t>(pair.size());
      intersect(ahead, shape.row(y + 1, z + 1), next_pair);
      intersect(pair, next_pair, common);
      euler += static_cast<std::int64_t>(common.size());
      pair.swap(next_pair);
      pair_of = y + 1;
    }
  }
  return euler;
}

std::uint32_t first_index(const VoxelShape& shape, Runs row) {
  return row.empty() ? 0 : static_cast<std::uint32_t>(row.data() - shape.runs().data());
}

/// 6-connected components of the foreground.
std::int64_t components(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  base::UnionFind sets(shape.runs().size());
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      const Runs row = shape.row(y, z);
      if (row.empty()) continue;
      const std::uint32_t here = first_index(shape, row);
      for (const Runs other : {shape.row(y + 1, z), shape.row(y, z + 1)}) {
        const std::uint32_t there = first_index(shape, other);
        overlaps(row, other, [&](std::size_t i, std::size_t j) {
          sets.unite(here + static_cast<std::uint32_t>(i), there + static_cast<std::uint32_t>(j));
        });
      }
    }
  return sets.count();
}

/// 26-connected components of the complement that are not connected to the outside of the grid. The set of run i
/// stands for the background after it, one further set for the outside.
std::int64_t cavities(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  const auto outside = static_cast<std::uint32_t>(shape.runs().size());
  base::UnionFind sets(std::size_t{outside} + 1);
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      const Runs row = shape.row(y, z);
      if (row.empty()) continue;
      const std::uint32_t here = first_index(shape, row);
      const auto after = [&](std::uint32_t first, Runs runs, std::size_t piece) {  // piece 0 lies before all runs
        return piece == 0 || piece == runs.size() ? outside : first + static_cast<std::uint32_t>(piece) - 1;
      };
      sets.unite(here + static_cast<std::uint32_t>(row.size()) - 1, outside);
      constexpr std::array<std::array<int, 2>, 8> neighbours{
          {{1, 0}, {-1, 1}, {0, 1}, {1, 1}, {-1, 0}, {1, -1}, {0, -1}, {-1, -1}}};
      for (std::size_t n = 0; n < neighbours.size(); ++n) {
        const Runs other = shape.row(y + neighbours[n][0], z + neighbours[n][1]);
        if (other.empty()) {
          for (std::size_t i = 1; i < row.size(); ++i) sets.unite(after(here, row, i), outside);
        } else if (n < 4) {  // the other four are seen from the other scanline
          // Pieces of background touch (26-connected) when the closed intervals meet; merged in order of x.
          const std::uint32_t there = first_index(shape, other);
          for (std::size_t i = 0, j = 0; i <= row.size() && j <= other.size();) {
            const bool meets = (i == row.size() || j == 0 || other[j - 1].end <= row[i].begin) &&
                               (j == other.size() || i == 0 || row[i - 1].end <= other[j].begin);
            if (meets) sets.unite(after(here, row, i), after(there, other, j));
            if (i == row.size())
              ++j;
            else if (j == other.size() || row[i].begin < other[j].begin)
              ++i;
            else
              ++j;
          }
        }
      }
    }
  return sets.count() - 1;
}

}  // namespace

Topology topology(const VoxelShape& shape) {
  Topology result;
  if (shape.empty()) return result;
  result.euler = euler_characteristic(shape);
  result.betti[0] = components(shape);
  result.betti[2] = cavities(shape);
  result.betti[1] = result.betti[0] + result.betti[2] - result.euler;
  return result;
}

}  // namespace quench
