// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>
#include <vector>

#include "quench/shape.h"
#include "shape/voxel_components.h"

namespace quench {
namespace {

using Runs = std::span<const Run>;

void intersect(Runs a, Runs b, std::vector<Run>& result) {
  result.clear();
  shape::for_overlaps(a, b, [&](std::size_t i, std::size_t j) {
    result.push_back({std::max(a[i].begin, b[j].begin), std::min(a[i].end, b[j].end)});
  });
}

/// Euler characteristic. Along a scanline an interval of n voxels has n - 1 adjacent pairs, so it counts 1, and the
/// same holds for the intervals in which two or four neighbouring scanlines are full (pairs and x-squares, squares and
/// cubes). The alternating sum of cubes, squares, edges and vertices is therefore: runs - common intervals of two
/// scanlines + common intervals of four.
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
      shape::for_overlaps(row, ahead, [&](std::size_t, std::size_t) { --euler; });
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

}  // namespace

Topology topology(const VoxelShape& shape) {
  Topology result;
  if (shape.empty()) return result;
  result.euler = euler_characteristic(shape);
  result.betti[0] = shape::foreground_components(shape).count();
  if (!shape.grid().is_plane()) result.betti[2] = shape::background_components(shape).count() - 1;
  result.betti[1] = result.betti[0] + result.betti[2] - result.euler;
  return result;
}

}  // namespace quench
