// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "base/cofaces.h"
#include "base/constants.h"
#include "base/parallel.h"
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

double thickness_of(const RefinedAxis& axis, std::uint32_t v) {
  return axis.curve_burn_time[v] == kNever ? kNever : axis.curve_burn_time[v] - axis.burn_time[v];
}

// The levels of curves without any sheets: those of complex::thin() of the graph of curves, where medial points and
// vertices of pockets have infinite values. A graph needs no order: an edge goes over a vertex as soon as this has no
// other edge, and its level is the largest thickness of those that have to go before it.
class CurveLevels {
 public:
  CurveLevels(SkeletonFamily& family, const std::vector<char>& pocket)
      : family_(family),
        axis_(family.refined),
        fixed_(pocket),
        left_(axis_.complex.vertex_count),
        before_(left_.size(), 0) {
    for (std::size_t v = 0; v < fixed_.size(); ++v) fixed_[v] |= axis_.medial_point[v];
    for (std::uint32_t e = first_edge(); e < axis_.complex.edges.size(); ++e)
      if (axis_.curve_edge[e])
        for (const std::uint32_t v : axis_.complex.edges[e]) left_[v].add(e);
  }
  void run() {
    for (std::uint32_t v = 0; v < left_.size(); ++v)
      for (std::uint32_t at = v; at != kNone;) at = go_over(at);
  }

 private:
  std::uint32_t first_edge() const { return 2 * axis_.doors; }
  // Removes the only edge of a vertex; returns its other end.
  std::uint32_t go_over(std::uint32_t v) {
    if (!left_[v].single() || fixed_[v]) return kNone;
    const std::uint32_t e = left_[v].only();
    const double level = std::max(before_[v], family_.thickness_of(e));
    if (level == kNever) return kNone;
    family_.curve_level[e - first_edge()] = level;
    const auto [a, b] = axis_.complex.edges[e];
    const std::uint32_t other = a == v ? b : a;
    left_[v].remove(e);
    left_[other].remove(e);
    before_[other] = std::max(before_[other], level);
    return other;
  }

  SkeletonFamily& family_;
  const RefinedAxis& axis_;
  std::vector<char> fixed_;
  std::vector<base::Cofaces> left_;
  std::vector<double> before_;  // per vertex: the largest level of its edges that are gone
};

SkeletonFamily family_of(RefinedAxis refined, Context* context) {
  SkeletonFamily family;
  family.corner_sheet_level = std::move(refined.corner_thickness);
  CellValues sheet = skeleton::sheet_levels(refined, family.corner_sheet_level, context);
  family.refined = std::move(refined);
  const RefinedAxis& k = family.refined;
  const std::size_t halves = 2 * std::size_t{k.doors};  // never part of the curves
  family.curve_thickness.assign(k.complex.edges.size() - halves, 0);
  family.curve_level.assign(k.complex.edges.size() - halves, 0);
  base::for_indices(family.curve_thickness.size(), [&](std::size_t i) {
    if (!k.curve_edge[halves + i]) return;
    const auto [a, b] = k.complex.edges[halves + i];
    family.curve_thickness[i] = std::max(0.0, std::min(thickness_of(k, a), thickness_of(k, b)));
    family.curve_level[i] = kNever;
  });
  CurveLevels(family, on_pockets(k, sheet.face)).run();
  family.vertex_sheet_level = std::move(sheet.vertex);
  family.edge_sheet_level = std::move(sheet.edge);
  family.face_sheet_level = std::move(sheet.face);
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
