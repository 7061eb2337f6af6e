// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <utility>
#include <vector>

#include "quench/shape.h"

/// Distances on the boundary of a tiny voxel shape, seen from inside, straight from their definition: every sequence of
/// squares that a straight way may pass is unfolded, and shortest ways are made of straight ones between vertices.
/// Nothing is pruned but what is longer than ways along sides and diagonals. Shares no code with the library but
/// VoxelShape::contains().
namespace quench::brute_force {

class GeodesicOracle {
 public:
  using Step = std::array<int, 3>;
  /// A boundary vertex and, of the voxels of O that faces connect with each other around it, the smallest.
  using Point = std::pair<Step, Step>;

  explicit GeodesicOracle(const VoxelShape& shape) : shape_(shape) {
    const auto& dims = shape.grid().dims;
    for (int z = 0; z < dims[2]; ++z)
      for (int y = 0; y < dims[1]; ++y)
        for (int x = 0; x < dims[0]; ++x)
          for (int a = 0; a < 6; ++a) {
            const Step voxel{x, y, z}, out = direction(a);
            if (!in(voxel) || in(plus(voxel, out))) continue;
            const int first = (a / 2 + 1) % 3;
            Step forward{0, 0, 0};
            forward[static_cast<std::size_t>(first)] = 1;
            for (int turn = 0; turn < 4; ++turn) {  // every corner once at the left behind
              squares_.push_back({voxel, out, forward, {}, {}});
              forward = cross(out, forward);
            }
          }
    std::map<std::array<Step, 3>, std::size_t> row;
    for (std::size_t i = 0; i < squares_.size(); ++i)
      row[{squares_[i].voxel, squares_[i].out, squares_[i].forward}] = i;
    for (Square& square : squares_) {
      const std::array<Step, 3> ways{minus(right(square)), square.forward, right(square)};
      for (std::size_t w = 0; w < 3; ++w) {
        const Square next = beyond(square, ways[w]);
        square.beyond[w] = row.at({next.voxel, next.out, next.forward});
      }
      square.ahead = {id(corner(square, -1, 1)), id(corner(square, 1, 1))};
    }
    for (const Square& square : squares_) {
      const Point from = corner(square, -1, -1);
      for (const auto& [side, front] : {std::pair{1, -1}, {1, 1}, {-1, 1}}) {
        const double w = side > 0 ? length(right(square)) : 0, h = front > 0 ? length(square.forward) : 0;
        lower(near_, from, corner(square, side, front), std::hypot(w, h));
      }
    }
    direct_ = near_;
    for (const auto& [from, there] : near_) {
      const std::map<Point, double> bound = shortest(near_, from);
      farthest_ = 0;
      for (const auto& [to, d] : bound) farthest_ = std::max(farthest_, d);
      straight_.assign(points_.size(), std::numeric_limits<double>::infinity());
      for (const Square& square : squares_)
        if (corner(square, -1, -1) == from) leave(square);
      for (std::size_t i = 0; i < points_.size(); ++i)
        if (straight_[i] <= farthest_ + 1e-9) lower(direct_, from, points_[i], straight_[i]);
    }
  }

  /// To all points on the same side of O.
  std::map<Point, double> distances(const Point& from) const { return shortest(direct_, from); }

  const std::vector<Point>& points() const { return points_; }

  /// Where the segment to another vertex begins; it must begin in O.
  Point contact(const Step& from, const Step& to) const {
    for (int i = 0; i < 8; ++i) {
      Step voxel;
      bool there = true;
      for (std::size_t a = 0; a < 3; ++a) {
        voxel[a] = from[a] - (i >> a & 1);
        there &= to[a] == from[a] || (to[a] < from[a]) == (voxel[a] < from[a]);
      }
      if (there && in(voxel)) return {from, part(from, voxel)};
    }
    return {};
  }

 private:
  using Plane = std::array<double, 2>;
  struct Square {
    Step voxel, out, forward;
    std::array<std::size_t, 3> beyond;  // the squares to the left, ahead and to the right
    std::array<std::size_t, 2> ahead;   // the points ahead, left and right
  };
  using Graph = std::map<Point, std::map<Point, double>>;

  static Step direction(int a) {
    Step d{0, 0, 0};
    d[static_cast<std::size_t>(a / 2)] = a % 2 ? -1 : 1;
    return d;
  }
  static Step plus(const Step& a, const Step& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
  static Step minus(const Step& a) { return {-a[0], -a[1], -a[2]}; }
  static Step cross(const Step& a, const Step& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static Step right(const Square& square) { return cross(square.forward, square.out); }
  bool in(const Step& v) const { return shape_.contains(v[0], v[1], v[2]); }
  double length(const Step& d) const {
    for (int a = 0; a < 3; ++a)
      if (d[static_cast<std::size_t>(a)] != 0) return shape_.grid().spacing[a];
    return 0;
  }

  Step part(const Step& vertex, const Step& voxel) const {
    std::set<Step> found{voxel};
    std::vector<Step> open{voxel};
    while (!open.empty()) {
      const Step v = open.back();
      open.pop_back();
      for (int a = 0; a < 6; ++a) {
        const Step n = plus(v, direction(a));
        bool touches = in(n);
        for (std::size_t i = 0; i < 3; ++i) touches &= n[i] == vertex[i] || n[i] == vertex[i] - 1;
        if (touches && found.insert(n).second) open.push_back(n);
      }
    }
    return *found.begin();
  }
  Point corner(const Square& square, int side, int front) const {
    const Step r = right(square);
    Step vertex;
    for (std::size_t i = 0; i < 3; ++i)
      vertex[i] = square.voxel[i] + (1 + square.out[i] + side * r[i] + front * square.forward[i]) / 2;
    return {vertex, part(vertex, square.voxel)};
  }
  Square beyond(const Square& square, const Step& way) const {
    const Step& v = square.voxel;
    if (!in(plus(v, way))) return {v, way, minus(square.out), {}, {}};
    const Step over = plus(plus(v, way), square.out);
    if (in(over)) return {over, minus(way), square.out, {}, {}};
    return {plus(v, way), square.out, way, {}, {}};
  }
  std::size_t id(const Point& point) {
    const auto [found, fresh] = ids_.try_emplace(point, points_.size());
    if (fresh) points_.push_back(point);
    return found->second;
  }

  static void lower(Graph& graph, const Point& from, const Point& to, double d) {
    const auto [found, fresh] = graph[from].try_emplace(to, d);
    if (!fresh) found->second = std::min(found->second, d);
  }
  static std::map<Point, double> shortest(const Graph& graph, const Point& from) {
    std::map<Point, double> distance{{from, 0}};
    std::set<std::pair<double, Point>> queue{{0, from}};
    while (!queue.empty()) {
      const auto [d, point] = *queue.begin();
      queue.erase(queue.begin());
      for (const auto& [to, length] : graph.at(point)) {
        const auto [found, fresh] = distance.try_emplace(to, std::numeric_limits<double>::infinity());
        if (d + length >= found->second) continue;
        queue.erase({found->second, to});
        found->second = d + length;
        queue.insert({found->second, to});
      }
    }
    return distance;
  }

  static double side_of(const Plane& a, const Plane& b) { return a[0] * b[1] - a[1] * b[0]; }  // > 0: b is left of a
  static Plane sum(const Plane& a, const Plane& b, double t = 1) { return {a[0] + t * b[0], a[1] + t * b[1]}; }

  void leave(const Square& square) {
    const double w = length(right(square)), h = length(square.forward);
    cross_over(squares_[square.beyond[2]], {w, h}, {w, 0}, {w, h}, {w, 0});
    cross_over(squares_[square.beyond[1]], {0, h}, {w, h}, {0, h}, {w, h});
  }
  // Into a square over a side whose ends are a and b, left and right, with the ways between `left` and `right`.
  void cross_over(const Square& square, const Plane& a, const Plane& b, const Plane& left, const Plane& right) {
    const Plane along{b[0] - a[0], b[1] - a[1]};
    const double squared = along[0] * along[0] + along[1] * along[1];
    const double t = std::clamp(-(a[0] * along[0] + a[1] * along[1]) / squared, 0., 1.);
    const Plane nearest = sum(a, along, t);
    if (std::hypot(nearest[0], nearest[1]) > farthest_ + 1e-9) return;
    const double stretch = length(square.forward) / std::sqrt(squared);
    const Plane up{-along[1] * stretch, along[0] * stretch}, c = sum(a, up), d = sum(b, up);
    const auto see = [&](const Plane& p, std::size_t point) {
      if (side_of(left, p) <= 1e-12 && side_of(right, p) >= -1e-12)
        straight_[point] = std::min(straight_[point], std::hypot(p[0], p[1]));
    };
    see(c, square.ahead[0]);
    see(d, square.ahead[1]);
    const auto go = [&](std::size_t way, const Plane& p, const Plane& q) {
      const Plane& l = side_of(left, p) < 0 ? p : left;
      const Plane& r = side_of(right, q) > 0 ? q : right;
      if (side_of(r, l) > 1e-12) cross_over(squares_[square.beyond[way]], p, q, l, r);
    };
    go(0, a, c);
    go(1, c, d);
    go(2, d, b);
  }

  const VoxelShape& shape_;
  std::vector<Square> squares_;
  std::map<Point, std::size_t> ids_;
  std::vector<Point> points_;
  std::vector<double> straight_;  // of the ways from one point that do not bend
  Graph near_, direct_;
  double farthest_ = 0;
};

}  // namespace quench::brute_force
