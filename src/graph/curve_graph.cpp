// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <limits>
#include <tuple>

#include "base/csr.h"
#include "base/union_find.h"
#include "graph/branch_measures.h"
#include "quench/graph.h"

namespace quench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A curve edge as seen from one of its ends.
struct Step {
  std::uint32_t vertex, edge;
};

class GraphBuilder {
 public:
  explicit GraphBuilder(const Skeleton& skeleton)
      : skeleton_(skeleton),
        complex_(skeleton.complex),
        is_curve_(complex_.edges.size(), 1),
        on_sheet_(complex_.vertex_count, 0),
        has_edge_(complex_.vertex_count, 0),
        component_(complex_.vertex_count),
        patch_(complex_.vertex_count, kNone),
        node_(complex_.vertex_count, kNone),
        walked_(complex_.edges.size(), 0) {}

  CurveGraph build() {
    find_curves();
    number_components();
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      const std::size_t degree = steps(v).size();
      if (on_sheet_[v] ? degree > 0 : degree != 2) add_node(v, kind_at(v, degree));
    }
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v)
      if (node_[v] != kNone) add_branches(v);
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v)
      for (const Step& step : steps(v))
        if (!walked_[step.edge]) {
          const std::uint32_t start = thickest_of_closed_curve(v, step);
          add_node(start, CurveGraph::NodeKind::loop);
          add_branches(start);
        }
    return std::move(graph_);
  }

 private:
  std::span<const Step> steps(std::uint32_t v) const { return steps_[v]; }

  void find_curves() {
    for (std::uint32_t e : complex_.face_edges) is_curve_[e] = 0;
    for (std::uint32_t v : complex_.face_vertices) on_sheet_[v] = 1;
    for (const auto& ends : complex_.edges)
      for (std::uint32_t v : ends) has_edge_[v] = 1;
    steps_ = base::Csr<Step>::group(complex_.vertex_count, [&](const auto& emit) {
      for (std::uint32_t e = 0; e < complex_.edges.size(); ++e) {
        if (!is_curve_[e]) continue;
        const auto [u, v] = complex_.edges[e];
        emit(u, {v, e});
        emit(v, {u, e});
      }
    });
    // By neighbour, so that the result does not depend on the order of edges.
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v)
      std::ranges::sort(steps_[v], {}, [](const Step& s) { return std::tie(s.vertex, s.edge); });
  }

  void number_components() {
    base::UnionFind whole(complex_.vertex_count), sheets(complex_.vertex_count);
    for (const auto& [u, v] : complex_.edges) whole.unite(u, v);
    for (std::size_t f = 0; f < complex_.face_count(); ++f)
      for (std::uint32_t v : complex_.corners(f)) sheets.unite(complex_.corners(f)[0], v);
    std::vector<char> curves;
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      const std::uint32_t root = whole.find(v);
      component_[v] = root == v ? graph_.components++ : component_[root];
      curves.resize(graph_.components, 0);
      // An isolated vertex is a node and counts here; a component without curve and node is all sheet.
      if (!steps(v).empty() || !has_edge_[v]) curves[component_[v]] = 1;
      if (!on_sheet_[v]) continue;
      const std::uint32_t first = sheets.find(v);
      patch_[v] = first == v ? graph_.sheets++ : patch_[first];
    }
    for (std::uint32_t c = 0; c < graph_.components; ++c)
      if (!curves[c]) graph_.sheet_only.push_back(c);
  }

  CurveGraph::NodeKind kind_at(std::uint32_t v, std::size_t degree) const {
    if (on_sheet_[v]) return CurveGraph::NodeKind::sheet;
    if (degree == 0) return CurveGraph::NodeKind::isolated;
    return degree == 1 ? CurveGraph::NodeKind::end : CurveGraph::NodeKind::junction;
  }

  void add_node(std::uint32_t v, CurveGraph::NodeKind kind) {
    node_[v] = static_cast<std::uint32_t>(graph_.nodes.size());
    CurveGraph::Node node;
    node.point = skeleton_.points[v];
    node.radius = skeleton_.radius[v];
    node.kind = kind;
    node.component = component_[v];
    node.degree = static_cast<std::uint32_t>(steps(v).size());
    node.sheet = patch_[v];
    node.vertex = v;
    graph_.nodes.push_back(node);
  }

  /// The branches that leave a node and have not been walked from their other end.
  void add_branches(std::uint32_t start) {
    for (const Step& first : steps(start)) {
      if (walked_[first.edge]) continue;
      CurveGraph::Branch branch;
      branch.from = node_[start];
      branch.component = component_[start];
      add_point(branch, start);
      Step step = first;
      while (true) {
        walked_[step.edge] = 1;
        add_point(branch, step.vertex);
        branch.thickness = std::max(branch.thickness, skeleton_.edge_thickness[step.edge]);
        if (node_[step.vertex] != kNone) break;
        const auto both = steps(step.vertex);
        step = both[0].edge == step.edge ? both[1] : both[0];
      }
      branch.to = node_[step.vertex];
      graph::measure(branch);
      graph_.branches.push_back(std::move(branch));
    }
  }

  void add_point(CurveGraph::Branch& branch, std::uint32_t v) const {
    branch.points.push_back(skeleton_.points[v]);
    branch.radius.push_back(skeleton_.radius[v]);
    branch.vertices.push_back(v);
  }

  std::uint32_t thickest_of_closed_curve(std::uint32_t start, Step step) const {
    const auto key = [&](std::uint32_t v) {
      const Vec3& p = skeleton_.points[v];
      return std::make_tuple(-skeleton_.radius[v], p[0], p[1], p[2], v);
    };
    std::uint32_t best = start;
    while (step.vertex != start) {
      if (key(step.vertex) < key(best)) best = step.vertex;
      const auto both = steps(step.vertex);
      step = both[0].edge == step.edge ? both[1] : both[0];
    }
    return best;
  }

  const Skeleton& skeleton_;
  const CellComplex& complex_;
  std::vector<char> is_curve_, on_sheet_, has_edge_;
  base::Csr<Step> steps_;                                ///< per vertex: the curve edges at it
  std::vector<std::uint32_t> component_, patch_, node_;  ///< per vertex; node_: kNone where not a node
  std::vector<char> walked_;
  CurveGraph graph_;
};

}  // namespace

void graph::measure(CurveGraph::Branch& branch) {
  branch.length = 0;
  double weighted = 0;
  for (std::size_t i = 1; i < branch.points.size(); ++i) {
    const double piece = (branch.points[i] - branch.points[i - 1]).norm();
    branch.length += piece;
    weighted += piece * (branch.radius[i] + branch.radius[i - 1]) / 2;
  }
  const auto [least, most] = std::minmax_element(branch.radius.begin(), branch.radius.end());
  branch.min_radius = *least;
  branch.max_radius = *most;
  // Rounding must not move the mean out of the range.
  branch.mean_radius = branch.length > 0 ? std::clamp(weighted / branch.length, *least, *most) : *least;
  const double apart = (branch.points.back() - branch.points.front()).norm();
  branch.tortuosity = apart > 0 ? std::max(1.0, branch.length / apart) : kInfinity;
}

const char* name_of(CurveGraph::NodeKind kind) {
  switch (kind) {
    case CurveGraph::NodeKind::end:
      return "end";
    case CurveGraph::NodeKind::junction:
      return "junction";
    case CurveGraph::NodeKind::sheet:
      return "sheet";
    case CurveGraph::NodeKind::loop:
      return "loop";
    case CurveGraph::NodeKind::isolated:
      return "isolated";
    case CurveGraph::NodeKind::border:
      return "border";
  }
  return "";
}

CurveGraph curve_graph(const Skeleton& skeleton) { return GraphBuilder(skeleton).build(); }

}  // namespace quench
