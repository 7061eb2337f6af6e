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
  const VoxelShape::Box box = shape.foreground_box();
  Grid part_of_grid = grid;  // around the shape
  Vec3 first = grid.first_centre();
  for (std::size_t a = 0; a < 3; ++a) {
    part_of_grid.dims[a] = box.end[a] - box.begin[a];
    first[static_cast<Eigen::Index>(a)] += static_cast<double>(box.begin[a]);
  }
  part_of_grid.origin = grid.world(first);
  const auto& size = part_of_grid.dims;
  std::vector<std::uint8_t> covered(static_cast<std::size_t>(size[0] * size[1] * size[2]), 0);
  const MaskView mask{size, {1, size[0], size[0] * size[1]}, covered.data()};
  mark_balls(centres, radius, part_of_grid, mask, context);
  VoxelShape part(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      for (const Run& run : shape.row(y, z)) {
        const std::uint8_t* row =
            covered.data() + ((z - box.begin[2]) * size[1] + (y - box.begin[1])) * size[0] - box.begin[0];
        for (std::int32_t x = run.begin; x < run.end; ++x)
          if (row[x]) runs.push_back({x, x + 1});
      }
      part.append_row(runs);
    }
  return part;
}

}  // namespace quench
