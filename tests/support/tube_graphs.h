// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/union_find.h"
#include "quench/graph.h"
#include "quench/shape.h"

/// Curve graphs and voxel shapes of tubes.
namespace quench::testing_tubes {

/// A polyline between two nodes; its radius goes evenly from the first to the last, but for `waist` in the middle.
struct Tube {
  std::vector<Vec3> corners;
  double from = 1, to = 1;
  double waist = 0;  ///< 0: none
};

inline CurveGraph::Branch branch_of(const Tube& tube, double step = 0.5) {
  CurveGraph::Branch branch;
  double length = 0;
  for (std::size_t i = 1; i < tube.corners.size(); ++i) length += (tube.corners[i] - tube.corners[i - 1]).norm();
  branch.points = {tube.corners.front()};
  branch.radius = {tube.from};
  double at = 0;
  for (std::size_t i = 1; i < tube.corners.size(); ++i) {
    const Vec3 way = tube.corners[i] - tube.corners[i - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / step)));
    for (int k = 1; k <= steps; ++k) {
      const double t = (at + way.norm() * k / steps) / length;
      branch.points.push_back(k == steps ? tube.corners[i] : Vec3(tube.corners[i - 1] + way * k / steps));
      double radius = tube.from + t * (tube.to - tube.from);
      if (tube.waist > 0) radius = std::min(radius, tube.waist + 4 * std::abs(t - 0.5) * radius);
      branch.radius.push_back(radius);
    }
    at += way.norm();
  }
  branch.length = length;
  return branch;
}

/// Tubes that end at the same point meet there; a tube of one point is an isolated node.
inline CurveGraph graph_of(const std::vector<Tube>& tubes) {
  CurveGraph graph;
  const auto node_at = [&](const Vec3& point, double radius) {
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n)
      if (graph.nodes[n].point == point) {
        graph.nodes[n].radius = std::max(graph.nodes[n].radius, radius);
        return n;
      }
    CurveGraph::Node node;
    node.point = point;
    node.radius = radius;
    graph.nodes.push_back(node);
    return static_cast<std::uint32_t>(graph.nodes.size() - 1);
  };
  for (const Tube& tube : tubes) {
    const std::uint32_t from = node_at(tube.corners.front(), tube.from);
    if (tube.corners.size() == 1) continue;
    CurveGraph::Branch branch = branch_of(tube);
    branch.from = from;
    branch.to = node_at(tube.corners.back(), tube.to);
    for (const std::uint32_t n : {branch.from, branch.to}) ++graph.nodes[n].degree;
    graph.branches.push_back(branch);
  }
  base::UnionFind sets(graph.nodes.size());
  for (const CurveGraph::Branch& branch : graph.branches) sets.unite(branch.from, branch.to);
  for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
    CurveGraph::Node& node = graph.nodes[n];
    node.component = sets.find(n) == n ? graph.components++ : graph.nodes[sets.find(n)].component;
    node.kind = node.degree == 0   ? CurveGraph::NodeKind::isolated
                : node.degree == 1 ? CurveGraph::NodeKind::end
                : node.degree == 2 ? CurveGraph::NodeKind::loop
                                   : CurveGraph::NodeKind::junction;
    node.vertex = n;
  }
  for (CurveGraph::Branch& branch : graph.branches) {
    branch.component = graph.nodes[branch.from].component;
    // A branch has the radius of what it meets where it does.
    branch.radius.front() = graph.nodes[branch.from].radius;
    branch.radius.back() = graph.nodes[branch.to].radius;
  }
  return graph;
}

/// The voxels of a cube of `side` voxels whose centres are in a tube.
inline VoxelShape voxels_of(const std::vector<Tube>& tubes, std::int64_t side) {
  Grid grid;
  grid.dims = {side, side, side};
  std::vector<char> inside(static_cast<std::size_t>(side * side * side), 0);
  for (const Tube& tube : tubes) {
    const CurveGraph::Branch branch = branch_of(tube);
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const Vec3 p = branch.points[i];
      const double r = branch.radius[i];
      const auto low = [&](int a) { return std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(p[a] - r)), 0); };
      const auto high = [&](int a) { return std::min(static_cast<std::int64_t>(std::floor(p[a] + r)), side - 1); };
      for (std::int64_t z = low(2); z <= high(2); ++z)
        for (std::int64_t y = low(1); y <= high(1); ++y)
          for (std::int64_t x = low(0); x <= high(0); ++x) {
            const Vec3 centre(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
            if ((centre - p).norm() <= r) inside[static_cast<std::size_t>(x + side * (y + side * z))] = 1;
          }
    }
  }
  VoxelShape shape(grid);
  std::vector<Run> runs;
  for (std::int64_t row = 0; row < side * side; ++row) {
    runs.clear();
    for (std::int32_t x = 0; x < side; ++x)
      if (inside[static_cast<std::size_t>(x + side * row)]) runs.push_back({x, x + 1});
    shape.append_row(runs);
  }
  return shape;
}

}  // namespace quench::testing_tubes
