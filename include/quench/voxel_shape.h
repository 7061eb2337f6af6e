// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench {

/// Foreground voxels [begin, end) of one scanline along x.
struct Run {
  std::int32_t begin;
  std::int32_t end;
  friend bool operator==(const Run&, const Run&) = default;
};

/// A voxel shape O: the open interior of the union of the foreground voxels (foreground 6-connected, background
/// 26-connected; Yan 2018, sec. 2.4). Sparse: sorted, disjoint, non-touching runs per scanline; row index y +
/// dims[1]*z. Memory: 8 bytes per run and 4 per scanline.
class VoxelShape {
 public:
  VoxelShape() = default;
  explicit VoxelShape(const Grid& grid) : grid_(grid) {}

  const Grid& grid() const { return grid_; }
  /// The runs of scanline (y, z); empty outside the grid.
  std::span<const Run> row(std::int64_t y, std::int64_t z) const {
    if (y < 0 || z < 0 || y >= grid_.dims[1] || z >= grid_.dims[2] || row_begin_.empty()) return {};
    const std::size_t r = static_cast<std::size_t>(y + grid_.dims[1] * z);
    return {runs_.data() + row_begin_[r], runs_.data() + row_begin_[r + 1]};
  }
  /// O(log runs of the scanline); false outside the grid.
  bool contains(std::int64_t x, std::int64_t y, std::int64_t z) const;
  std::span<const Run> runs() const { return runs_; }
  std::int64_t voxel_count() const;
  bool empty() const { return runs_.empty(); }
  /// Smallest and one-past-largest voxel coordinates of the foreground; both 0 when empty.
  struct Box {
    std::array<std::int64_t, 3> begin{0, 0, 0}, end{0, 0, 0};
  };
  Box foreground_box() const;
  /// Longest side of the foreground box in world units: what a plain number as a length refers to for volumes.
  double longest_side() const;
  /// Throws Error(invariant) naming the first relation that does not hold (row offsets, order of runs, grid).
  void validate() const;

  /// Appends the runs of the next scanline (y fastest, then z); merges touching runs, drops empty ones.
  /// All dims[1]*dims[2] scanlines must be appended before the shape is used. Runs must be sorted by begin.
  void append_row(std::span<const Run> runs);

 private:
  Grid grid_;
  std::vector<std::uint32_t> row_begin_;  // dims[1]*dims[2] + 1 offsets into runs_
  std::vector<Run> runs_;
};

/// The boundary vertices P (the sites): lattice points whose 8 incident voxels are neither all in O nor all out,
/// in order of z, y, x. O(runs + sites).
std::vector<LatticePoint> boundary_vertices(const VoxelShape& shape);
/// Their number, without storing them.
std::int64_t count_boundary_vertices(const VoxelShape& shape);

/// The shape with every voxel split into factor^3 voxels (Yan 2018, Figs. 2.3, 2.4).
VoxelShape subdivide(const VoxelShape& shape, int factor);

/// Whether the segment between two points of the world lies in the shape: every voxel it passes is foreground. False
/// when an end is not finite. O(voxels passed * log runs).
bool contains_segment(const VoxelShape& shape, const Vec3& a, const Vec3& b);

}  // namespace quench
