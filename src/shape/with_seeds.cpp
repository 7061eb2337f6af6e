// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "shape/grown.h"
#include "shape/voxel_components.h"

namespace quench::shape {

VoxelShape with_seeds(const VoxelShape& shape, const VoxelShape& seeds, int connectivity, ForegroundReport& report,
                      Context* context) {
  base::UnionFind sets =
      connectivity == 6 ? foreground_components(shape, context) : touching_components(shape, context);
  std::vector<bool> seeded(shape.runs().size(), false);
  for_scanlines(shape, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
    const auto row = shape.row(y, z);
    const std::uint32_t first = first_index(shape, row);
    for_overlaps(row, seeds.row(y, z),
                 [&](std::size_t i, std::size_t) { seeded[sets.find(first + static_cast<std::uint32_t>(i))] = true; });
  });
  VoxelShape result(shape.grid());
  std::vector<Run> runs;
  for_scanlines(shape, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
    const auto row = shape.row(y, z);
    std::uint32_t index = first_index(shape, row);
    runs.clear();
    for (const Run& run : row)
      if (seeded[sets.find(index++)]) runs.push_back(run);
    result.append_row(runs);
  });
  report.weak_dropped = shape.voxel_count() - result.voxel_count();
  return result;
}

}  // namespace quench::shape
