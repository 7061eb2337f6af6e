// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "quench/axis.h"

namespace quench {

VoxelShape wide_part(const VoxelShape& shape, const MedialAxis& axis, double width, Context* context) {
  const Grid& grid = shape.grid();
  std::vector<Vec3> centres;
  std::vector<double> radius;
  for (std::size_t v = 0; v < axis.points.size(); ++v)
    if (2 * axis.radius[v] >= width) {
      centres.push_back(axis.points[v]);
      radius.push_back(axis.radius[v]);
    }
  std::vector<std::uint8_t> covered(static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]), 0);
  const MaskView mask{grid.dims, {1, grid.dims[0], grid.dims[0] * grid.dims[1]}, covered.data()};
  mark_balls(centres, radius, grid, mask, context);
  VoxelShape part(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      const std::uint8_t* row = covered.data() + (z * grid.dims[1] + y) * grid.dims[0];
      runs.clear();
      for (const Run& run : shape.row(y, z))
        for (std::int32_t x = run.begin; x < run.end; ++x)
          if (row[x]) runs.push_back({x, x + 1});
      part.append_row(runs);
    }
  return part;
}

}  // namespace quench
