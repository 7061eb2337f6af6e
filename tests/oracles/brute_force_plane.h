// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "quench/shape.h"

/// The core of a tiny pixel shape straight from its definition: all triples of sites, and all sites for each. The
/// boundary is walked pixel edge by pixel edge. Shares no code with the library but VoxelShape::contains().
namespace quench::brute_force {

__extension__ typedef __int128 PlaneWide;

/// A point of the plane: numerators over one positive denominator, in lattice coordinates.
struct PlanePoint {
  PlaneWide x, y, denominator;
};

struct PlaneVertex {
  std::vector<std::uint32_t> sites;  ///< all on its circle, ascending
  PlanePoint centre;
};

struct PlaneEdge {
  std::array<std::uint32_t, 2> ends, sites;  ///< ascending
  double mgf;                                ///< infinite: the sites lie on different curves of the boundary
};

/// Vertices in the order of their sites, edges of their ends.
struct PlaneCore {
  std::vector<LatticePoint> sites;
  std::vector<PlaneVertex> vertices;
  std::vector<PlaneEdge> edges;
};

/// Sites in order of y, x: lattice points with pixels of both kinds around them.
inline std::vector<LatticePoint> sites_of_plane(const VoxelShape& shape) {
  std::vector<LatticePoint> sites;
  for (std::int32_t y = 0; y <= shape.grid().dims[1]; ++y)
    for (std::int32_t x = 0; x <= shape.grid().dims[0]; ++x) {
      int count = 0;
      for (int i = 0; i < 4; ++i) count += shape.contains(x - i % 2, y - i / 2, 0);
      if (count % 4 != 0) sites.push_back({x, y, 0});
    }
  return sites;
}

class PlaneOracle {
 public:
  /// `scale`: integers in the proportion of the steps of the grid along x and y.
  PlaneOracle(const VoxelShape& shape, std::array<std::int64_t, 2> scale) : shape_(shape), scale_(scale) {
    core_.sites = sites_of_plane(shape);
  }

  const PlaneCore& run() {
    find_vertices();
    find_edges();
    return core_;
  }

  /// All q with d |q|^2 = n . q, relative to `origin`, d > 0; in scaled coordinates.
  struct Circle {
    std::array<std::int64_t, 2> origin;
    PlaneWide d, nx, ny;
  };
  /// Through three sites; none when they are on a line.
  std::optional<Circle> circle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const auto o = scaled(a), p = scaled(b), q = scaled(c);
    const PlaneWide ux = p[0] - o[0], uy = p[1] - o[1], vx = q[0] - o[0], vy = q[1] - o[1];
    PlaneWide d = ux * vy - uy * vx;
    if (d == 0) return std::nullopt;
    const PlaneWide u = ux * ux + uy * uy, v = vx * vx + vy * vy;
    PlaneWide nx = u * vy - v * uy, ny = v * ux - u * vx;
    if (d < 0) d = -d, nx = -nx, ny = -ny;
    return Circle{o, d, nx, ny};
  }
  /// Negative inside, 0 on the circle.
  PlaneWide side(const Circle& circle, std::uint32_t s) const {
    const auto p = scaled(s);
    const PlaneWide x = p[0] - circle.origin[0], y = p[1] - circle.origin[1];
    return circle.d * (x * x + y * y) - circle.nx * x - circle.ny * y;
  }
  PlanePoint centre(const Circle& circle) const {
    const PlaneWide d = 2 * circle.d;
    return {(circle.origin[0] * d + circle.nx) * scale_[1], (circle.origin[1] * d + circle.ny) * scale_[0],
            d * scale_[0] * scale_[1]};
  }

  /// Whether an open neighbourhood of the point is in the union of the closed foreground pixels.
  bool inside(const PlanePoint& p) const {
    const auto floor_of = [](PlaneWide a, PlaneWide b) { return static_cast<std::int64_t>(a / b - (a % b < 0)); };
    const std::int64_t x = floor_of(p.x, p.denominator), y = floor_of(p.y, p.denominator);
    const bool on_x = p.x % p.denominator == 0, on_y = p.y % p.denominator == 0;
    for (int i = 0; i <= int{on_x}; ++i)
      for (int j = 0; j <= int{on_y}; ++j)
        if (!shape_.contains(x - i, y - j, 0)) return false;
    return true;
  }

  /// Whether the segment between two sites lies in O but for its ends: all its pieces between lines of the lattice do,
  /// and the points between these.
  bool segment_inside(std::uint32_t a, std::uint32_t b) const {
    const LatticePoint &p = core_.sites[a], &q = core_.sites[b];
    const std::int64_t dx = q[0] - p[0], dy = q[1] - p[1];
    const std::int64_t parts = std::max<std::int64_t>(std::abs(dx), 1) * std::max<std::int64_t>(std::abs(dy), 1);
    for (std::int64_t i = 1; i < 2 * parts; ++i)  // lines are crossed at even i at most
      if (!inside({PlaneWide{p[0]} * 2 * parts + i * dx, PlaneWide{p[1]} * 2 * parts + i * dy, 2 * parts}))
        return false;
    return true;
  }

  /// The shorter arc of the boundary between the contacts of two sites whose segment lies in the closure of O.
  double mgf(std::uint32_t a, std::uint32_t b) const {
    const std::set<Pixel> from = beginning(a, b), to = beginning(b, a);
    const LatticePoint& goal = core_.sites[b];
    const double infinite = std::numeric_limits<double>::infinity();
    for (int d = 0; d < 4; ++d) {
      const LatticePoint start = core_.sites[a];
      if (!is_boundary(start, d) || (touches_itself(start) && !from.contains(pixel_after(start, d)))) continue;
      LatticePoint p = start;
      int direction = d;
      double length = 0, there = infinite;
      do {
        length += shape_.grid().spacing[direction & 1];
        const Pixel left = pixel_after(p, direction);
        p = step(p, direction);
        if (p == goal && (!touches_itself(p) || to.contains(left))) there = std::min(there, length);
        direction = (direction + 1) & 3;  // as far left as possible
        while (!is_boundary(p, direction)) direction = (direction + 3) & 3;
      } while (p != start || direction != d);
      return there == infinite ? infinite : std::min(there, length - there);
    }
    throw std::logic_error("a site without an edge of the boundary");
  }

 private:
  using Pixel = std::array<std::int32_t, 2>;
  std::array<std::int64_t, 2> scaled(std::uint32_t s) const {
    return {core_.sites[s][0] * scale_[0], core_.sites[s][1] * scale_[1]};
  }
  void find_vertices() {
    const auto count = static_cast<std::uint32_t>(core_.sites.size());
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        for (std::uint32_t c = b + 1; c < count; ++c)
          if (const auto found = circle(a, b, c)) add_vertex(*found, {a, b, c});
    std::ranges::sort(core_.vertices, {}, &PlaneVertex::sites);
  }
  // Of each set of sites on one circle, the three smallest add it.
  void add_vertex(const Circle& circle, const std::array<std::uint32_t, 3>& triple) {
    PlaneVertex vertex;
    for (std::uint32_t s = 0; s < core_.sites.size(); ++s) {
      const PlaneWide where = side(circle, s);
      if (where < 0) return;
      if (where == 0) vertex.sites.push_back(s);
    }
    if (!std::equal(triple.begin(), triple.end(), vertex.sites.begin())) return;
    vertex.centre = centre(circle);
    if (inside(vertex.centre)) core_.vertices.push_back(vertex);
  }

  // Two empty circles that share two sites have no other site between these, on one side of each.
  void find_edges() {
    for (std::uint32_t u = 0; u < core_.vertices.size(); ++u)
      for (std::uint32_t v = u + 1; v < core_.vertices.size(); ++v) {
        const auto &a = core_.vertices[u].sites, &b = core_.vertices[v].sites;
        std::vector<std::uint32_t> shared;
        std::ranges::set_intersection(a, b, std::back_inserter(shared));
        if (shared.size() > 2) throw std::logic_error("two circles share three sites");
        if (shared.size() == 2 && segment_inside(shared[0], shared[1]))
          core_.edges.push_back({{u, v}, {shared[0], shared[1]}, mgf(shared[0], shared[1])});
      }
  }

  // Directions 0 to 3: +x, +y, -x, -y, each a left turn after the one before where y grows upwards.
  static LatticePoint step(const LatticePoint& p, int direction) {
    constexpr int dx[] = {1, 0, -1, 0}, dy[] = {0, 1, 0, -1};
    return {p[0] + dx[direction & 3], p[1] + dy[direction & 3], 0};
  }
  // The pixel between a direction and the next, seen from p.
  static Pixel pixel_after(const LatticePoint& p, int direction) {
    const int d = direction & 3;
    return {p[0] - int{d == 1 || d == 2}, p[1] - int{d >= 2}};
  }
  bool is_in(const Pixel& p) const { return shape_.contains(p[0], p[1], 0); }
  // Whether O lies on the left of the pixel edge from p, and only there.
  bool is_boundary(const LatticePoint& p, int direction) const {
    return is_in(pixel_after(p, direction)) && !is_in(pixel_after(p, direction + 3));
  }

  // The pixels of O at site a in which the segment to b begins.
  std::set<Pixel> beginning(std::uint32_t a, std::uint32_t b) const {
    const LatticePoint &p = core_.sites[a], &q = core_.sites[b];
    std::set<Pixel> pixels;
    for (const int x : {p[0] - 1, p[0]})
      for (const int y : {p[1] - 1, p[1]}) {
        const bool towards_x = q[0] == p[0] || (q[0] > p[0]) == (x == p[0]);
        const bool towards_y = q[1] == p[1] || (q[1] > p[1]) == (y == p[1]);
        if (towards_x && towards_y && is_in({x, y})) pixels.insert({x, y});
      }
    return pixels;
  }

  bool touches_itself(const LatticePoint& p) const {
    const bool first = is_in(pixel_after(p, 0));
    return first == is_in(pixel_after(p, 2)) && first != is_in(pixel_after(p, 1)) && first != is_in(pixel_after(p, 3));
  }

  const VoxelShape& shape_;
  const std::array<std::int64_t, 2> scale_;
  PlaneCore core_;
};

}  // namespace quench::brute_force
