// SPDX-License-Identifier: Apache-2.0
#include "skeleton/curve_times.h"

#include "burning/curve_fire.h"

namespace quench::skeleton {

void burn_curve_network(RefinedAxis& axis, Context* context) {
  std::vector<std::uint32_t> edge_of;  // of K, per edge of the curves
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t e = 0; e < axis.curve_edge.size(); ++e)
    if (axis.curve_edge[e]) {
      edge_of.push_back(e);
      edges.push_back(axis.complex.edges[e]);
    }
  std::vector<double> length(edges.size());
  const auto measure = [&](const std::vector<std::uint32_t>& at) {
    for (std::size_t e = 0; e < edges.size(); ++e)
      length[e] = (axis.points[at[edges[e][0]]] - axis.points[at[edges[e][1]]]).norm();
  };
  std::vector<std::uint32_t> at(axis.points.size());
  for (std::uint32_t v = 0; v < at.size(); ++v) at[v] = v;
  measure(at);
  const burning::CurveFire first = burning::burn_curves(edges, axis.curve_vertex, axis.burn_time, length);
  checkpoint(context, "curves", 0.8);
  axis.exit.assign(axis.points.size(), kNone);
  for (std::uint32_t v = axis.nodes + axis.doors; v < at.size(); ++v) {
    if (first.exit[v] == kNone) continue;
    const auto [a, b] = edges[first.exit[v]];
    at[v] = a == v ? b : a;
    axis.exit[v] = edge_of[first.exit[v]];
  }
  measure(at);
  burning::CurveFire second = burning::burn_curves(edges, axis.curve_vertex, axis.burn_time, length);
  axis.curve_burn_time = std::move(second.time);
  axis.medial_point = std::move(second.last);
}

}  // namespace quench::skeleton
