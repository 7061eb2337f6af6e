// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
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

/// An edge of a ring across the rows of pixels, in coordinates along the rows and across them.
struct Upright {
  double x, low, high;
  std::size_t ring;
};

std::vector<Upright> uprights(const Polygons& boundary) {
  const Vec2 along = (boundary.rings[0][1] - boundary.rings[0][0]).normalized(), across(-along[1], along[0]);
  std::vector<Upright> edges;
  for (std::size_t r = 0; r < boundary.rings.size(); ++r) {
    const auto& ring = boundary.rings[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 &a = ring[i], &b = ring[i + 1 < ring.size() ? i + 1 : 0];
      const double from = across.dot(a), to = across.dot(b);
      if (std::abs(to - from) > std::abs(along.dot(b - a)))
        edges.push_back({along.dot(a + b) / 2, std::min(from, to), std::max(from, to), r});
    }
  }
  return edges;
}

/// For each ring, the ring of the first edge at the left of its leftmost one, or itself where there is none. Between
/// the two are pixels of the shape if the ring is that of a hole: then both bound the same part.
struct LeftOf {
  std::vector<std::size_t> ring, order;  ///< `order`: the rings from left to right by their leftmost edges
};

LeftOf left_of(const Polygons& boundary) {
  const std::vector<Upright> edges = uprights(boundary);
  std::vector<std::size_t> leftmost(boundary.rings.size(), edges.size());
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < edges.size(); ++e) {
    auto& best = leftmost[edges[e].ring];
    if (best == edges.size() || edges[e].x < edges[best].x) best = e;
    shortest = std::min(shortest, edges[e].high - edges[e].low);
  }
  // A line sweeps over the rows. It looks to the left a little above the lower end of an edge: the golden section of a
  // number of rows is never close to a row, so that rounding, in grids that are turned, does not matter.
  const double above = shortest * (2 - std::numbers::phi);
  enum Kind { begins, ends, looks };
  struct Event {
    double y;
    Kind kind;
    std::size_t edge;
  };
  std::vector<Event> events;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    events.push_back({edges[e].low, begins, e});
    events.push_back({edges[e].high, ends, e});
    if (leftmost[edges[e].ring] == e) events.push_back({edges[e].low + above, looks, e});
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.y < b.y; });
  LeftOf left;
  left.ring.resize(boundary.rings.size());
  std::set<std::pair<double, std::size_t>> crossed;
  for (const Event& event : events) {
    const std::pair key(edges[event.edge].x, event.edge);
    if (event.kind == begins) {
      crossed.insert(key);
    } else if (event.kind == ends) {
      crossed.erase(key);
    } else {
      const auto at = crossed.find(key);
      const std::size_t ring = edges[event.edge].ring;
      left.ring[ring] = at == crossed.begin() ? ring : edges[std::prev(at)->second].ring;
    }
  }
  for (std::size_t r = 0; r < boundary.rings.size(); ++r)
    if (leftmost[r] < edges.size()) left.order.push_back(r);
  std::sort(left.order.begin(), left.order.end(),
            [&](std::size_t a, std::size_t b) { return edges[leftmost[a]].x < edges[leftmost[b]].x; });
  return left;
}

}  // namespace

std::vector<Polygons> parts_of(const Polygons& boundary) {
  std::vector<Polygons> parts;
  std::vector<std::size_t> part(boundary.rings.size(), boundary.rings.size());
  for (std::size_t r = 0; r < boundary.rings.size(); ++r)
    if (twice_area(boundary.rings[r]) > 0) {
      part[r] = parts.size();
      parts.push_back({{boundary.rings[r]}});
    }
  if (parts.size() == boundary.rings.size()) return parts;
  const LeftOf left = left_of(boundary);
  std::vector<std::size_t> holes;
  for (const std::size_t r : left.order)
    if (part[r] == boundary.rings.size()) {
      part[r] = part[left.ring[r]];  // which is known: it begins farther to the left
      holes.push_back(r);
    }
  std::sort(holes.begin(), holes.end());
  for (const std::size_t r : holes)
    if (part[r] < parts.size()) parts[part[r]].rings.push_back(boundary.rings[r]);
  return parts;
}

}  // namespace quench
