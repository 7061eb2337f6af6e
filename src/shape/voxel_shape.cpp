// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "quench/error.h"
#include "quench/shape.h"

namespace quench {

bool VoxelShape::contains(std::int64_t x, std::int64_t y, std::int64_t z) const {
  const auto runs = row(y, z);
  const auto after =
      std::upper_bound(runs.begin(), runs.end(), x, [](std::int64_t v, const Run& r) { return v < r.begin; });
  return after != runs.begin() && x < (after - 1)->end;
}

std::int64_t VoxelShape::voxel_count() const {
  std::int64_t count = 0;
  for (const Run& run : runs_) count += run.end - run.begin;
  return count;
}

VoxelShape::Box VoxelShape::foreground_box() const {
  Box box;
  if (empty()) return box;
  box.begin.fill(std::numeric_limits<std::int64_t>::max());
  for (std::int64_t z = 0; z < grid_.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid_.dims[1]; ++y) {
      const auto runs = row(y, z);
      if (runs.empty()) continue;
      box.begin = {std::min<std::int64_t>(box.begin[0], runs.front().begin), std::min(box.begin[1], y),
                   std::min(box.begin[2], z)};
      box.end = {std::max<std::int64_t>(box.end[0], runs.back().end), std::max(box.end[1], y + 1),
                 std::max(box.end[2], z + 1)};
    }
  return box;
}

double VoxelShape::longest_side() const {
  const Box box = foreground_box();
  double side = 0;
  for (int a = 0; a < grid_.dimension; ++a)
    side = std::max(side, static_cast<double>(box.end[a] - box.begin[a]) * grid_.spacing[a]);
  return side;
}

void VoxelShape::append_row(std::span<const Run> runs) {
  if (row_begin_.empty()) {
    row_begin_.reserve(static_cast<std::size_t>(grid_.dims[1] * grid_.dims[2]) + 1);
    row_begin_.push_back(0);
  }
  const std::size_t first = runs_.size();
  for (const Run& run : runs) {
    if (run.begin >= run.end) continue;
    if (runs_.size() > first && runs_.back().end >= run.begin)
      runs_.back().end = std::max(runs_.back().end, run.end);
    else
      runs_.push_back(run);
  }
  if (runs_.size() >= std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::failed, "the shape has more than 2^32 runs of voxels; use a lower resolution");
  row_begin_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

void VoxelShape::validate() const {
  const auto fail = [](const std::string& what) { throw Error(ErrorCode::invariant, "voxel shape: " + what); };
  const auto rows = static_cast<std::size_t>(grid_.dims[1] * grid_.dims[2]);
  if (row_begin_.size() != rows + 1)
    fail(fmt::format("{} scanlines were appended, the grid has {}", row_begin_.empty() ? 0 : row_begin_.size() - 1,
                     rows));
  if (row_begin_.front() != 0 || row_begin_.back() != runs_.size()) fail("row offsets do not span the runs");
  for (std::size_t r = 0; r < rows; ++r) {
    if (row_begin_[r] > row_begin_[r + 1]) fail(fmt::format("offsets of scanline {} decrease", r));
    std::int64_t last = -1;
    for (std::uint32_t i = row_begin_[r]; i < row_begin_[r + 1]; ++i) {
      if (runs_[i].begin <= last || runs_[i].begin >= runs_[i].end || runs_[i].end > grid_.dims[0] ||
          runs_[i].begin < 0)
        fail(fmt::format("run {} of scanline {} is out of order or out of the grid", i - row_begin_[r], r));
      last = runs_[i].end;
    }
  }
}

VoxelShape subdivide(const VoxelShape& shape, int factor) {
  if (factor < 1) throw Error(ErrorCode::usage, "voxels are subdivided by a whole number of 1 or more", "subdivide");
  Grid grid = shape.grid();
  // The corner of the grid stays where it is: lattice 0 is half a voxel before the centre of voxel 0.
  const Vec3 corner = grid.world(Vec3::Zero());
  for (int a = 0; a < grid.dimension; ++a) {
    grid.dims[a] *= factor;
    grid.spacing[a] /= factor;
    if (grid.dims[a] > std::numeric_limits<std::int32_t>::max() / 2)
      throw Error(ErrorCode::usage, fmt::format("subdividing by {} makes the grid too large", factor), "subdivide");
  }
  if (grid.is_plane()) grid.make_plane();
  grid.origin = corner + grid.direction * grid.spacing.cwiseProduct(grid.first_centre());
  VoxelShape result(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      for (const Run& run : shape.row(y / factor, z / factor)) runs.push_back({run.begin * factor, run.end * factor});
      result.append_row(runs);
    }
  return result;
}

bool contains_segment(const VoxelShape& shape, const Vec3& a, const Vec3& b) {
  const Grid& grid = shape.grid();
  const Vec3 from = grid.lattice(a), to = grid.lattice(b), way = to - from;
  // An end outside the grid is not in a foreground voxel; coordinates inside fit an integer.
  for (int i = 0; i < 3; ++i)
    for (const double end : {from[i], to[i]})
      if (!(end >= 0 && end < static_cast<double>(grid.dims[static_cast<std::size_t>(i)]))) return false;
  std::array<std::int64_t, 3> voxel, step;
  Vec3 next, each;  // parameters of the next crossing and between crossings, per axis
  std::int64_t crossings = 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    voxel[axis] = static_cast<std::int64_t>(std::floor(from[i]));
    step[axis] = way[i] > 0 ? 1 : -1;
    const double border = static_cast<double>(voxel[axis]) + (way[i] > 0 ? 1 : 0);
    next[i] = way[i] != 0 ? (border - from[i]) / way[i] : std::numeric_limits<double>::infinity();
    each[i] = way[i] != 0 ? 1 / std::abs(way[i]) : std::numeric_limits<double>::infinity();
    crossings += std::abs(static_cast<std::int64_t>(std::floor(to[i])) - voxel[axis]);
  }
  for (;; --crossings) {
    if (!shape.contains(voxel[0], voxel[1], voxel[2])) return false;
    if (crossings <= 0) return true;
    int axis = 0;
    next.minCoeff(&axis);
    voxel[static_cast<std::size_t>(axis)] += step[static_cast<std::size_t>(axis)];
    next[axis] += each[axis];
  }
}

}  // namespace quench
