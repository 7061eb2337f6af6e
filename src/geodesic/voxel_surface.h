// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/shape.h"

namespace quench::geodesic {

/// The boundary of a voxel shape O as it is seen from inside of O: rectangles glued along their sides into a closed
/// surface, a piecewise flat metric space. Where O touches itself in an edge or a vertex, it is there several times,
/// once for each part of O that is connected around it by faces of voxels; where only the background touches itself,
/// all sheets around a vertex meet in it. So the surface has as many components as O has sides to the 26-connected
/// background, and a way on it never jumps between parts of O that are far from each other inside.
///
/// A half-edge is a side of a square: 4 * square + side, counter-clockwise seen from outside. A point is a boundary
/// vertex together with a part of O around it. About 75 bytes per square.
class VoxelSurface {
 public:
  /// O(runs + sites). Throws Error(failed) when half-edges outgrow 32 bits, Error(input) where integer_spacing() does.
  explicit VoxelSurface(const VoxelShape& shape);

  std::uint32_t half_edges() const { return static_cast<std::uint32_t>(twin_.size()); }
  std::uint32_t points() const { return static_cast<std::uint32_t>(site_of_.size()); }

  /// The same side as one of the square beyond it.
  std::uint32_t twin(std::uint32_t half_edge) const { return twin_[half_edge]; }
  /// Where a half-edge begins.
  std::uint32_t begin(std::uint32_t half_edge) const { return begin_[half_edge]; }
  /// Of a side: an integer.
  double length(std::uint32_t half_edge) const { return step_[axis_[half_edge]]; }
  /// Half-edges that begin at a point: one per square around it.
  std::span<const std::uint32_t> around(std::uint32_t point) const {
    return {leaving_.data() + leaving_begin_[point], leaving_.data() + leaving_begin_[point + 1]};
  }
  /// Whether shortest ways may bend at a point: more than a full turn is around it, or several sheets meet in it.
  bool is_saddle(std::uint32_t point) const { return leaving_begin_[point + 1] - leaving_begin_[point] > 4; }

  /// The point at a boundary vertex from which the segment to another one begins; kNone where there is no such boundary
  /// vertex, or the segment does not begin inside of O.
  std::uint32_t point_towards(const LatticePoint& from, const LatticePoint& to) const;
  const LatticePoint& place(std::uint32_t point) const { return sites_[site_of_[point]]; }
  /// Steps along x, y and z, as integer_spacing() has them, and the unit in which they are, in world units.
  const std::array<double, 3>& step() const { return step_; }
  double unit() const { return unit_; }
  double smallest_step() const { return std::ranges::min(step_); }
  /// The component of the surface that a point is in.
  std::uint32_t component(std::uint32_t point) const { return component_[point]; }

 private:
  struct Neighbours;
  void find_masks(const VoxelShape& shape);
  void make_squares(const Neighbours& neighbours);
  void glue(const Neighbours& neighbours);
  void list_leaving();
  void find_components();

  std::vector<LatticePoint> sites_;
  std::vector<std::uint8_t> mask_;          // per site: the voxels around it that are in O
  std::vector<std::uint32_t> first_point_;  // per site
  std::vector<std::uint32_t> site_of_, component_;
  std::vector<std::uint32_t> square_at_;  // per site and axis: the square with this smallest corner, across the axis
  std::vector<std::uint32_t> twin_, begin_, leaving_begin_, leaving_;
  std::vector<std::uint8_t> axis_;  // that a half-edge runs along
  std::array<double, 3> step_{1, 1, 1};
  double unit_ = 1;
};

}  // namespace quench::geodesic
