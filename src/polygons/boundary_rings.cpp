// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "quench/polygons.h"

namespace quench {
namespace {

/// The corners of the boundary, each linked to the next one of its ring; found line by line. A corner has one
/// horizontal and one vertical edge. Where pixels share a corner only there are two, each with the edges of one pixel.
class Outline {
 public:
  explicit Outline(const VoxelShape& shape) {
    const std::int64_t lines = shape.grid().dims[1];
    for (std::int64_t y = 0; y <= lines; ++y) line(static_cast<std::int32_t>(y), shape.row(y, 0));
  }

  /// Calls `visit` with the corners of every ring, in order.
  template <class Visit>
  void each_ring(const Visit& visit) {
    std::vector<std::array<std::int32_t, 2>> ring;
    for (std::uint32_t c = 0; c < next_.size(); ++c) {
      ring.clear();
      for (std::uint32_t at = c; next_[at] != kNone; at = std::exchange(next_[at], kNone)) ring.push_back(corners_[at]);
      if (!ring.empty()) visit(ring);
    }
  }

 private:
  /// A vertical edge that crosses a row, at the begin or the end of a run.
  struct Vertical {
    std::int32_t x;
    bool begin;
    std::uint32_t from;  ///< its corner below
  };

  std::uint32_t corner(std::int32_t x, std::int32_t y) {
    corners_.push_back({x, y});
    next_.push_back(kNone);
    return static_cast<std::uint32_t>(corners_.size() - 1);
  }

  /// The shape is at the left: edges at begins of runs go down, those at ends go up.
  void end_at(const Vertical& edge, std::uint32_t c) {
    if (edge.begin)
      next_[c] = edge.from;
    else
      next_[edge.from] = c;
  }

  /// The line below row y: between the edges that come from the row below it and those of this row.
  void line(std::int32_t y, std::span<const Run> runs) {
    above_.clear();
    for (const Run& run : runs) {
      above_.push_back({run.begin, true, kNone});
      above_.push_back({run.end, false, kNone});
    }
    auto below = below_.begin();
    auto above = above_.begin();
    bool in_below = false, in_above = false;
    std::uint32_t left = kNone;  // the corner at which the horizontal edge begins
    while (below != below_.end() || above != above_.end()) {
      const bool from_below = above == above_.end() || (below != below_.end() && below->x <= above->x);
      const bool to_above = below == below_.end() || (above != above_.end() && above->x <= below->x);
      const std::int32_t x = from_below ? below->x : above->x;
      if (from_below && to_above && below->begin == above->begin) {
        above->from = below->from;
      } else {
        if (in_below != in_above) {  // a horizontal edge ends here, of the row that is inside
          const std::uint32_t c = corner(x, y);
          if (in_above) {
            next_[left] = c;
            attach(to_above, above, below, c);
          } else {
            next_[c] = left;
            attach(!from_below, above, below, c);
          }
        }
        const bool below_after = in_below != from_below, above_after = in_above != to_above;
        if (below_after != above_after) {  // one begins
          left = corner(x, y);
          attach(from_below && to_above ? above_after : to_above, above, below, left);
        }
      }
      if (from_below) in_below = (below++)->begin;
      if (to_above) in_above = (above++)->begin;
    }
    std::swap(above_, below_);
  }

  template <class Iterator>
  void attach(bool to_above, Iterator above, Iterator below, std::uint32_t c) {
    if (to_above)
      above->from = c;
    else
      end_at(*below, c);
  }

  std::vector<std::array<std::int32_t, 2>> corners_;
  std::vector<std::uint32_t> next_;
  std::vector<Vertical> below_, above_;
};

}  // namespace

Polygons boundary_rings(const VoxelShape& plane) {
  const Grid& grid = plane.grid();
  const bool mirrored = grid.direction.topLeftCorner<2, 2>().determinant() < 0;
  Polygons result;
  Outline(plane).each_ring([&](const auto& corners) {
    auto& ring = result.rings.emplace_back();
    ring.reserve(corners.size());
    for (const auto& [x, y] : corners) ring.push_back(grid.world_of({x, y, 0}).template head<2>());
    if (mirrored) std::reverse(ring.begin() + 1, ring.end());
  });
  return result;
}

namespace {

double twice_area(const std::vector<Vec2>& ring) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i] - ring[0], b = ring[i + 1 < ring.size() ? i + 1 : 0] - ring[0];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

// By crossings of a ray to the right; `p` is on no edge.
bool is_inside(const std::vector<Vec2>& ring, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[i + 1 < ring.size() ? i + 1 : 0];
    if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

}  // namespace

std::vector<Polygons> parts_of(const Polygons& boundary) {
  std::vector<Polygons> parts;
  std::vector<double> area;
  for (const auto& ring : boundary.rings)
    if (const double twice = twice_area(ring); twice > 0) {
      parts.push_back({{ring}});
      area.push_back(twice);
    }
  for (const auto& ring : boundary.rings) {
    if (twice_area(ring) > 0) continue;
    // Half way along an edge a hole touches nothing else.
    const Vec2 on_hole = 0.5 * (ring[0] + ring[1]);
    std::size_t best = parts.size();
    for (std::size_t p = 0; p < parts.size(); ++p)
      if ((best == parts.size() || area[p] < area[best]) && is_inside(parts[p].rings[0], on_hole)) best = p;
    if (best < parts.size()) parts[best].rings.push_back(ring);
  }
  return parts;
}

}  // namespace quench
