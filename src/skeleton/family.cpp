// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "base/constants.h"
#include "base/parallel.h"
#include "complex/thinning.h"
#include "quench/skeleton.h"
#include "skeleton/sheet_levels.h"

namespace quench {
namespace {

using base::kNever;

// Vertices of closed pockets: curves that end there are not free.
std::vector<char> on_pockets(const RefinedAxis& axis, std::span<const double> face_level) {
  std::vector<char> pocket(axis.complex.vertex_count, 0);
  for (std::size_t f = 0; f < face_level.size(); ++f)
    if (face_level[f] == kNever)
      for (const std::uint32_t v : axis.complex.corners(f)) pocket[v] = 1;
  return pocket;
}

SkeletonFamily family_of(RefinedAxis refined, Context* context) {
  SkeletonFamily family;
  const std::size_t edges = refined.complex.edges.size(), vertices = refined.complex.vertex_count;
  CellValues sheet = skeleton::sheet_levels(refined, context);

  // Curves on their own: what is left without any sheets; their ends on pockets are fixed.
  const std::vector<char> pocket = on_pockets(refined, sheet.face);
  const std::size_t halves = 2 * std::size_t{refined.doors};  // never part of the curves
  family.curve_thickness.assign(edges - halves, 0);
  family.curve_level.assign(edges - halves, 0);
  CellComplex graph;
  graph.vertex_count = refined.complex.vertex_count;
  std::vector<std::uint32_t> edge_of;
  std::vector<double> graph_value;
  for (std::uint32_t e = 0; e < edges; ++e) {
    if (!refined.curve_edge[e]) continue;
    const auto thickness = [&](std::uint32_t v) {
      return refined.curve_burn_time[v] == kNever ? kNever : refined.curve_burn_time[v] - refined.burn_time[v];
    };
    const auto [a, b] = refined.complex.edges[e];
    double& thick = family.curve_thickness[e - halves];
    thick = std::max(0.0, std::min(thickness(a), thickness(b)));
    graph.edges.push_back({a, b});
    graph_value.push_back(thick);
    edge_of.push_back(e);
  }
  std::vector<double> vertex_value(vertices);
  for (std::size_t v = 0; v < vertices; ++v) vertex_value[v] = refined.medial_point[v] || pocket[v] ? kNever : 0;
  const CellValues curve = complex::thin(graph, vertex_value, graph_value, {}, context, "skeleton");
  for (std::size_t i = 0; i < edge_of.size(); ++i) family.curve_level[edge_of[i] - halves] = curve.edge[i];

  family.vertex_sheet_level = std::move(sheet.vertex);
  family.edge_sheet_level = std::move(sheet.edge);
  family.face_sheet_level = std::move(sheet.face);
  family.refined = std::move(refined);
  return family;
}

}  // namespace

SkeletonFamily skeletons(RefinedAxis refined, Context* context) {
  return base::in_arena(context, [&] { return family_of(std::move(refined), context); });
}

SkeletonFamily skeletons(const MedialAxis& axis, const Burning& burning, Context* context) {
  return skeletons(quench_curves(axis.complex, axis.points, axis.radius, burning, context), context);
}

}  // namespace quench
