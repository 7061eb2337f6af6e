// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "axis/ball_tree.h"
#include "axis/shortest_paths.h"
#include "dual/bricks/part.h"
#include "quench/axis.h"

namespace quench::axis {

/// What a part of a voxel core must not lose, since cover_boundary() of the whole may need it.
class CoverNeeds {
 public:
  /// Per vertex of the axis: whether it is certain that it is part of something significant, and whether there may be
  /// edges at it that the axis does not have.
  struct Vertices {
    std::span<const std::uint8_t> significant, incomplete;
  };
  /// `own`: boundary vertices in the box of the part, `around`: others in the region, in order, that may be uncovered.
  CoverNeeds(const MedialAxis& axis, double least, const Vertices& vertices, std::span<const LatticePoint> own,
             std::span<const LatticePoint> around, const dual::bricks::Box& region, Context* context);

  /// Those in the box that may still be uncovered.
  const std::vector<LatticePoint>& pending() const { return pending_; }
  /// Per site of the axis: whether it may be an uncovered one of a thin part: all cells that touch it are needed.
  const std::vector<std::uint8_t>& thin_sites() const { return thin_sites_; }

  struct Cells {
    std::vector<std::uint8_t> vertex, edge;
  };
  /// The vertices and edges that paths may lead along, and balls that decide what is thick. Per vertex of the axis:
  /// `possible`: whether it may be part of something significant, `thin`: of a cell that touches one of thin_sites().
  /// To be called once.
  Cells of_paths(std::span<const std::uint8_t> possible, std::span<const std::uint8_t> thin);

 private:
  // Whether there may be uncovered sites within `length` of the vertex that are not known.
  bool is_near_unknown_sites(std::uint32_t vertex, double length) const;
  std::vector<std::uint8_t> look_at_balls();
  template <class Work>
  void for_blocks(const Work& work) const;
  void begin_where_unknown();
  std::vector<double> lengths_of_thin_paths(std::span<const std::uint8_t> thin) const;
  Vec3 position(std::size_t site) const { return axis_.grid.world_of(uncovered_[site]); }

  const MedialAxis& axis_;
  double least_;
  Vertices vertices_;
  dual::bricks::Box region_;
  ShortestPaths paths_;
  std::vector<double> to_significant_;  // per vertex: in units of length
  std::vector<LatticePoint> pending_;
  std::vector<LatticePoint> uncovered_;  // pending_ and those around
  std::vector<Vec3> thin_;               // those that may be of thin parts
  std::vector<std::uint8_t> thin_sites_;
  std::vector<double> length_;       // per vertex: of the longest path that begins there, -1: none does
  std::vector<std::uint8_t> balls_;  // per vertex: whether its ball decides what is thick
};

}  // namespace quench::axis
