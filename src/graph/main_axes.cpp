// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "base/csr.h"
#include "graph/settings.h"
#include "quench/error.h"
#include "quench/graph.h"

namespace quench {
namespace {

constexpr double kNotReached = std::numeric_limits<double>::infinity();
// In a component with loops every end is tried, up to so many; else the farthest from those that were.
constexpr std::size_t kMostEnds = 2000, kSweeps = 16;

class MainAxes {
 public:
  explicit MainAxes(const CurveGraph& graph)
      : graph_(graph),
        branches_at_(base::Csr<std::uint32_t>::group(graph.nodes.size(),
                                                     [&](const auto& emit) {
                                                       for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
                                                         emit(graph.branches[b].from, b);
                                                         emit(graph.branches[b].to, b);
                                                       }
                                                     })),
        distance_(graph.nodes.size(), kNotReached),
        came_by_(graph.nodes.size(), kNone),
        kept_(graph.branches.size(), 0) {}

  // Per branch: whether it is part of the main axis of its component.
  std::vector<char> run() {
    std::vector<char> seen(graph_.nodes.size(), 0);
    for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
      if (seen[n]) continue;
      measure_from(n);
      for (const std::uint32_t m : reached_) seen[m] = 1;
      choose();
    }
    return std::move(kept_);
  }

 private:
  struct Way {
    double length = -1;
    std::uint32_t from = kNone, to = kNone;
  };

  // The nodes of one component are those that were reached.
  void choose() {
    const std::vector<std::uint32_t> nodes = reached_;
    std::size_t branches = 0;
    std::vector<std::uint32_t> ends;
    for (const std::uint32_t n : nodes) {
      branches += branches_at_[n].size();
      if (graph_.nodes[n].kind == CurveGraph::NodeKind::end) ends.push_back(n);
    }
    branches /= 2;
    if (branches == 0) return;
    if (nodes.size() == 1) {  // closed curves
      for (const std::uint32_t b : branches_at_[nodes[0]]) kept_[b] = 1;
      return;
    }
    std::uint32_t loop = kNone;  // the longest closed curve, where there is no way from end to end
    if (ends.size() < 2) {
      for (const std::uint32_t n : nodes)
        for (const std::uint32_t b : branches_at_[n])
          if (graph_.branches[b].from == graph_.branches[b].to &&
              (loop == kNone || graph_.branches[b].length > graph_.branches[loop].length))
            loop = b;
      ends = nodes;
    }
    const bool tree = branches + 1 == nodes.size();
    Way best;
    if (tree || ends.size() > kMostEnds) {
      std::uint32_t from = ends[0];
      for (std::size_t sweep = 0; sweep < (tree ? 2 : kSweeps); ++sweep) {
        const Way way = longest_from(from, ends);
        if (way.length > best.length) best = way;
        from = way.to;
      }
    } else {
      for (const std::uint32_t end : ends)
        if (const Way way = longest_from(end, ends); way.length > best.length) best = way;
    }
    if (loop != kNone && graph_.branches[loop].length > best.length) {
      kept_[loop] = 1;
      return;
    }
    measure_from(best.from);
    for (std::uint32_t n = best.to; n != best.from;) {
      const auto& branch = graph_.branches[came_by_[n]];
      kept_[came_by_[n]] = 1;
      n = branch.from == n ? branch.to : branch.from;
    }
  }
  Way longest_from(std::uint32_t from, std::span<const std::uint32_t> ends) {
    measure_from(from);
    Way way;
    for (const std::uint32_t end : ends)
      if (end != from && distance_[end] > way.length) way = {distance_[end], from, end};
    return way;
  }
  // Shortest ways to all nodes of the component (Dijkstra 1959); ties: the smaller branch.
  void measure_from(std::uint32_t from) {
    for (const std::uint32_t n : reached_) distance_[n] = kNotReached;
    reached_.clear();
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto reach = [&](std::uint32_t n, double distance, std::uint32_t branch) {
      if (distance > distance_[n] || (distance == distance_[n] && branch >= came_by_[n])) return;
      if (distance_[n] == kNotReached) reached_.push_back(n);
      distance_[n] = distance;
      came_by_[n] = branch;
      queue.push({distance, n});
    };
    reach(from, 0, kNone - 1);
    while (!queue.empty()) {
      const auto [distance, n] = queue.top();
      queue.pop();
      if (distance > distance_[n]) continue;
      for (const std::uint32_t b : branches_at_[n]) {
        const auto& branch = graph_.branches[b];
        const std::uint32_t other = branch.from == n ? branch.to : branch.from;
        if (other != n && distance + branch.length < distance_[other]) reach(other, distance + branch.length, b);
      }
    }
  }

  const CurveGraph& graph_;
  base::Csr<std::uint32_t> branches_at_;
  std::vector<double> distance_;
  std::vector<std::uint32_t> came_by_, reached_;
  std::vector<char> kept_;
};

// What is left of per-cell values.
template <class T>
std::vector<T> selected(const std::vector<T>& values, std::span<const std::uint32_t> cells) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(cells.size());
  for (const std::uint32_t cell : cells) result.push_back(values[cell]);
  return result;
}

}  // namespace

Skeleton main_axes(const Skeleton& skeleton) {
  if (skeleton.complex.face_count() > 0)
    throw Error(ErrorCode::usage,
                "only skeletons of curves have main axes; this one has sheets, which theta2 inf turns into curves",
                "theta2");
  const CurveGraph graph = curve_graph(skeleton);
  const std::vector<char> kept = MainAxes(graph).run();
  std::vector<char> vertex_stays(skeleton.points.size(), 0);
  for (const auto& node : graph.nodes)
    if (node.kind == CurveGraph::NodeKind::isolated) vertex_stays[node.vertex] = 1;
  std::vector<std::array<std::uint32_t, 2>> edge_list;
  for (std::size_t b = 0; b < kept.size(); ++b)
    for (std::size_t i = 0; kept[b] && i < graph.branches[b].vertices.size(); ++i) {
      const auto& along = graph.branches[b].vertices;
      vertex_stays[along[i]] = 1;
      if (i > 0) edge_list.push_back({std::min(along[i - 1], along[i]), std::max(along[i - 1], along[i])});
    }
  std::sort(edge_list.begin(), edge_list.end());
  std::vector<std::uint32_t> vertices, edges, number(vertex_stays.size(), kNone);
  for (std::uint32_t v = 0; v < vertex_stays.size(); ++v)
    if (vertex_stays[v]) {
      number[v] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(v);
    }
  for (std::uint32_t e = 0; e < skeleton.complex.edges.size(); ++e)
    if (std::binary_search(edge_list.begin(), edge_list.end(), skeleton.complex.edges[e])) edges.push_back(e);

  Skeleton axes;
  graph::copy_settings(skeleton, axes);
  axes.main_axes = true;
  axes.complex.vertex_count = static_cast<std::uint32_t>(vertices.size());
  axes.complex.edges = selected(skeleton.complex.edges, edges);
  for (auto& ends : axes.complex.edges)
    for (std::uint32_t& v : ends) v = number[v];
  axes.points = selected(skeleton.points, vertices);
  axes.radius = selected(skeleton.radius, vertices);
  axes.burn_time = selected(skeleton.burn_time, vertices);
  axes.curve_burn_time = selected(skeleton.curve_burn_time, vertices);
  axes.on_curve = selected(skeleton.on_curve, vertices);
  axes.mgf = selected(skeleton.mgf, vertices);
  axes.edge_thickness = selected(skeleton.edge_thickness, edges);
  axes.edge_level = selected(skeleton.edge_level, edges);
  return axes;
}

}  // namespace quench
