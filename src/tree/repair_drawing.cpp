// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_drawing.h"

#include <algorithm>
#include <utility>

#include "base/union_find.h"
#include "graph/branch_measures.h"

namespace quench::tree {

std::uint32_t Drawing::add_node(const Vec3& point, double radius, std::uint32_t vertex) {
  nodes_.push_back({point, radius, vertex, false, {}});
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

std::uint32_t Drawing::add_cut(const Vec3& point, double radius) {
  const std::uint32_t node = add_node(point, radius, kNone);
  nodes_[node].cut = true;
  return node;
}

void Drawing::add_line(Polyline course, std::uint32_t from, std::uint32_t to) {
  const auto line = static_cast<std::uint32_t>(lines_.size());
  nodes_[from].lines.push_back(line);
  nodes_[to].lines.push_back(line);
  lines_.push_back({std::move(course), from, to});
}

void Drawing::finish(Repaired& repaired) {
  drop_rests();
  join_lines();
  make_graph(repaired);
}

void Drawing::drop(std::uint32_t line) {
  lines_[line].gone = true;
  for (const std::uint32_t n : {lines_[line].from, lines_[line].to}) std::erase(nodes_[n].lines, line);
}

// What a cut leaves inside the ball of what it is left on.
void Drawing::drop_rests() {
  for (std::uint32_t i = 0; i < lines_.size(); ++i) {
    for (const auto& [cut, on] : {std::pair{lines_[i].from, lines_[i].to}, std::pair{lines_[i].to, lines_[i].from}}) {
      if (lines_[i].gone || !nodes_[cut].cut || nodes_[cut].lines.size() != 1 || nodes_[on].lines.size() < 2) continue;
      if (lines_[i].course.length() < 1.5 * nodes_[on].radius) drop(i);
    }
  }
}

void Drawing::join_lines() {
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    std::vector<std::uint32_t>& lines = nodes_[n].lines;
    if (lines.size() != 2 || lines[0] == lines[1]) continue;
    const std::uint32_t first = std::min(lines[0], lines[1]), second = std::max(lines[0], lines[1]);
    Line &a = lines_[first], &b = lines_[second];
    if (a.to != n || a.from == n) {
      a.course = reversed(std::move(a.course));
      std::swap(a.from, a.to);
    }
    if (b.from != n) {
      b.course = reversed(std::move(b.course));
      std::swap(b.from, b.to);
    }
    append(a.course, b.course);
    a.to = b.to;
    b.gone = true;
    lines.clear();
    std::ranges::replace(nodes_[b.to].lines, second, first);
    nodes_[n].cut = true;  // gone
  }
}

void Drawing::make_graph(Repaired& repaired) {
  CurveGraph& graph = repaired.graph;
  std::vector<std::uint32_t> number(nodes_.size(), kNone);
  base::UnionFind sets(nodes_.size());
  for (const Line& line : lines_)
    if (!line.gone) sets.unite(line.from, line.to);
  std::vector<std::uint32_t> component(nodes_.size(), kNone);
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    if (node.cut && node.lines.empty()) continue;
    std::uint32_t& c = component[sets.find(n)];
    if (c == kNone) c = graph.components++;
    number[n] = static_cast<std::uint32_t>(graph.nodes.size());
    CurveGraph::Node out;
    out.point = node.point;
    out.radius = node.radius;
    out.degree = static_cast<std::uint32_t>(node.lines.size());
    out.kind = out.degree == 0   ? CurveGraph::NodeKind::isolated
               : out.degree == 1 ? CurveGraph::NodeKind::end
               : out.degree == 2 ? CurveGraph::NodeKind::loop
                                 : CurveGraph::NodeKind::junction;
    out.component = c;
    out.vertex = node.vertex;
    graph.nodes.push_back(out);
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    if (line.gone) continue;
    if (number[line.from] > number[line.to]) {
      line.course = reversed(std::move(line.course));
      std::swap(line.from, line.to);
    }
    order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return number[lines_[i].from]; });
  for (const std::uint32_t i : order) {
    Line& line = lines_[i];
    CurveGraph::Branch branch;
    branch.from = number[line.from];
    branch.to = number[line.to];
    branch.component = graph.nodes[branch.from].component;
    branch.thickness = line.course.thickness;
    repaired.bridged.push_back(std::move(line.course.bridged));
    branch.points = std::move(line.course.points);
    branch.radius = std::move(line.course.radius);
    branch.vertices = std::move(line.course.vertices);
    branch.erosion_thickness = std::move(line.course.erosion_thickness);
    branch.mgf = std::move(line.course.mgf);
    graph::measure(branch);
    graph.branches.push_back(std::move(branch));
  }
}

}  // namespace quench::tree
