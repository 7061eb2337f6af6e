// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "quench/tree.h"

/// Curve graphs without loops, built by hand or at random.
namespace quench::testing_trees {

/// Nodes by their points; branches as polylines between them.
struct Builder {
  CurveGraph graph;

  std::uint32_t node(const Vec3& point, double radius = 0.1) {
    CurveGraph::Node& n = graph.nodes.emplace_back();
    n.point = point;
    n.radius = radius;
    n.kind = CurveGraph::NodeKind::isolated;
    return static_cast<std::uint32_t>(graph.nodes.size() - 1);
  }
  /// Through `between`, whose radii are those of the line from end to end unless they are given.
  void branch(std::uint32_t a, std::uint32_t b, const std::vector<Vec3>& between = {}, double radius = -1) {
    CurveGraph::Branch branch;
    branch.from = a;
    branch.to = b;
    branch.points = {graph.nodes[a].point};
    branch.points.insert(branch.points.end(), between.begin(), between.end());
    branch.points.push_back(graph.nodes[b].point);
    const auto last = static_cast<double>(branch.points.size() - 1);
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const double t = static_cast<double>(i) / last;
      branch.radius.push_back(radius >= 0 ? radius : (1 - t) * graph.nodes[a].radius + t * graph.nodes[b].radius);
    }
    for (const std::uint32_t end : {a, b}) {
      ++graph.nodes[end].degree;
      graph.nodes[end].kind = graph.nodes[end].degree == 1 ? CurveGraph::NodeKind::end : CurveGraph::NodeKind::junction;
    }
    graph.branches.push_back(std::move(branch));
  }
  Repaired repaired() const {
    Repaired result;
    result.graph = graph;
    return result;
  }
};

/// A random forest: nodes in the unit cube, each joined to one before it, or none; straight or bent branches, of which
/// some have no length.
inline Builder random_forest(std::mt19937& random, int most_nodes) {
  std::uniform_real_distribution<double> unit(0, 1);
  Builder builder;
  const int count = std::uniform_int_distribution<int>(0, most_nodes)(random);
  for (int i = 0; i < count; ++i) {
    const bool joined = i > 0 && unit(random) < 0.93;
    const auto before =
        joined ? std::uniform_int_distribution<std::uint32_t>(0, static_cast<std::uint32_t>(i) - 1)(random) : 0;
    Vec3 point(unit(random), unit(random), unit(random));
    if (joined && unit(random) < 0.05) point = builder.graph.nodes[before].point;
    const std::uint32_t n = builder.node(point, 0.001 + 0.05 * unit(random));
    if (!joined) continue;
    std::vector<Vec3> between;
    for (int k = 0; k < 3 && unit(random) < 0.5; ++k) between.emplace_back(unit(random), unit(random), unit(random));
    if (unit(random) < 0.5)
      builder.branch(before, n, between);
    else
      builder.branch(n, before, between);
  }
  return builder;
}

/// The same graph with everything moved by `place`, radii times `scale`.
template <class Place>
CurveGraph moved(CurveGraph graph, const Place& place, double scale) {
  for (auto& node : graph.nodes) {
    node.point = place(node.point);
    node.radius *= scale;
  }
  for (auto& branch : graph.branches) {
    for (Vec3& p : branch.points) p = place(p);
    for (double& r : branch.radius) r *= scale;
  }
  return graph;
}

}  // namespace quench::testing_trees
