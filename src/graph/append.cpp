// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "graph/settings.h"
#include "quench/error.h"
#include "quench/graph.h"

namespace quench {
namespace {

template <class T>
void append_values(std::vector<T>& to, const std::vector<T>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

void append(CurveGraph& to, const CurveGraph& more, std::uint32_t first_vertex) {
  const auto first_node = static_cast<std::uint32_t>(to.nodes.size());
  for (CurveGraph::Node node : more.nodes) {
    node.component += to.components;
    if (node.sheet != kNone) node.sheet += to.sheets;
    if (node.vertex != kNone) node.vertex += first_vertex;
    to.nodes.push_back(node);
  }
  for (CurveGraph::Branch branch : more.branches) {
    branch.from += first_node;
    branch.to += first_node;
    branch.component += to.components;
    for (std::uint32_t& v : branch.vertices) v += first_vertex;
    to.branches.push_back(std::move(branch));
  }
  for (const std::uint32_t component : more.sheet_only) to.sheet_only.push_back(component + to.components);
  to.components += more.components;
  to.sheets += more.sheets;
}

void append(Skeleton& to, const Skeleton& more) {
  if (to.complex.face_count() + more.complex.face_count() > 0)
    throw Error(ErrorCode::usage, "only skeletons of curves are put together");
  const auto last = std::max_element(to.edge_branch.begin(), to.edge_branch.end());
  const std::int32_t first_branch = last == to.edge_branch.end() ? 0 : *last + 1;
  const std::uint32_t first_vertex = to.complex.vertex_count;
  if (first_vertex == 0) graph::copy_settings(more, to);
  for (const auto& [a, b] : more.complex.edges) to.complex.edges.push_back({a + first_vertex, b + first_vertex});
  to.complex.vertex_count += more.complex.vertex_count;
  for (const std::int32_t b : more.edge_branch) to.edge_branch.push_back(b < 0 ? b : b + first_branch);
  append_values(to.points, more.points);
  append_values(to.radius, more.radius);
  append_values(to.burn_time, more.burn_time);
  append_values(to.curve_burn_time, more.curve_burn_time);
  append_values(to.on_curve, more.on_curve);
  append_values(to.mgf, more.mgf);
  append_values(to.edge_thickness, more.edge_thickness);
  append_values(to.edge_level, more.edge_level);
}

}  // namespace quench
