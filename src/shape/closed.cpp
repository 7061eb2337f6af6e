// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "shape/grown.h"
#include "shape/voxel_components.h"

namespace quench::shape {
namespace {

/// A scanline of a ball around a voxel: it reaches from x - reach to x + reach.
struct BallRow {
  std::int64_t y, z;
  std::int32_t reach;
};

/// The scanlines of a ball; the middle one is the first.
std::vector<BallRow> ball_rows(const Grid& grid, int radius) {
  const double least = grid.spacing.minCoeff();
  // Exact for cubes, whose steps are all 1.
  const Vec3 step = grid.spacing / least;
  const double square = static_cast<double>(radius) * radius;
  std::vector<BallRow> rows;
  const std::int64_t deep = grid.is_plane() ? 0 : radius;
  for (std::int64_t z = -deep; z <= deep; ++z)
    for (std::int64_t y = -radius; y <= radius; ++y) {
      const double dy = static_cast<double>(y) * step[1], dz = static_cast<double>(z) * step[2];
      const double left = square - dy * dy - dz * dz;
      if (left >= 0) rows.push_back({y, z, static_cast<std::int32_t>(std::sqrt(left) / step[0])});
    }
  std::stable_partition(rows.begin(), rows.end(), [](const BallRow& row) { return row.y == 0 && row.z == 0; });
  return rows;
}

/// The scanlines of a shape and those around them, up to `y` and `z` away.
Grid padded(const Grid& grid, std::int64_t x, std::int64_t y, std::int64_t z) {
  Grid larger = grid;
  larger.dims = {grid.dims[0] + 2 * x, grid.dims[1] + 2 * y, grid.dims[2] + 2 * z};
  return larger;
}

}  // namespace

VoxelShape closed(const VoxelShape& shape, int radius, ForegroundReport& report, Context* context) {
  const std::vector<BallRow> ball = ball_rows(shape.grid(), radius);
  const std::int32_t wide = ball.front().reach;
  std::int64_t high = 0, deep = 0;
  for (const BallRow& row : ball) {
    high = std::max(high, row.y);
    deep = std::max(deep, row.z);
  }
  VoxelShape dilated(padded(shape.grid(), wide, high, deep));
  std::vector<Run> runs;
  for_scanlines(dilated, context, "closing", [&](std::int64_t y, std::int64_t z) {
    runs.clear();
    for (const BallRow& row : ball)
      for (const Run& run : shape.row(y - high + row.y, z - deep + row.z))
        runs.push_back({run.begin + wide - row.reach, run.end + wide + row.reach});
    std::ranges::sort(runs, {}, &Run::begin);
    dilated.append_row(runs);
  });
  VoxelShape result(shape.grid());
  std::vector<Run> left, cut;
  for_scanlines(result, context, "closing", [&](std::int64_t y, std::int64_t z) {
    const auto middle = dilated.row(y + high, z + deep);
    left.assign(middle.begin(), middle.end());
    for (const BallRow& row : ball) {
      if (left.empty()) break;
      const auto around = dilated.row(y + high + row.y, z + deep + row.z);
      cut.clear();
      for (std::size_t i = 0, j = 0; i < left.size() && j < around.size();) {
        const std::int32_t end = around[j].end - row.reach;
        const Run both{std::max(left[i].begin, around[j].begin + row.reach), std::min(left[i].end, end)};
        if (both.begin < both.end) cut.push_back(both);
        left[i].end < end ? ++i : ++j;
      }
      std::swap(left, cut);
    }
    for (Run& run : left) run = {run.begin - wide, run.end - wide};
    result.append_row(left);
  });
  report.voxels_closed = result.voxel_count() - shape.voxel_count();
  return result;
}

}  // namespace quench::shape
