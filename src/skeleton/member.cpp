// SPDX-License-Identifier: Apache-2.0
#include "skeleton/member.h"

#include <algorithm>

#include "base/constants.h"
#include "base/csr.h"
#include "base/graph_peeler.h"
#include "base/parallel.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// Lets the free ends of curves grow back along curves that were pruned. What grows back is a path that begins at a free
// end, so topology does not change.
void grow_tips(const SkeletonFamily& family, double from_thickness, const base::GraphPeeler& left,
               const std::vector<char>& on_sheet, Member& member) {
  const RefinedAxis& k = family.refined;
  const auto edges = static_cast<std::uint32_t>(k.complex.edges.size());
  const auto pruned = base::Csr<std::uint32_t>::group(k.complex.vertex_count, [&](const auto& emit) {
    for (std::uint32_t e = 2 * k.doors; e < edges; ++e)
      if (k.curve_edge[e] && !member.edge[e])
        for (const std::uint32_t v : k.complex.edges[e]) emit(v, e);
  });
  for (std::uint32_t end = 0; end < left.vertex_count(); ++end) {
    if (!left.edges_at(end).single() || on_sheet[end] || !member.vertex[end]) continue;
    // An end that is drawn where its only edge leads is none there unless that is on the way of one curve.
    if (const std::uint32_t e = left.edges_at(end).only(); k.exit[end] == e) {
      const std::uint32_t drawn = other_end(k, e, end);
      if (on_sheet[drawn] || left.edges_at(drawn).count() != 2) continue;
    }
    for (std::uint32_t v = end;;) {
      std::uint32_t best = kNone;  // ties: the smaller index
      for (const std::uint32_t e : pruned[v]) {
        if (member.edge[e] || family.thickness_of(e) < from_thickness) continue;
        if (best == kNone || family.level_of(e) > family.level_of(best)) best = e;
      }
      if (best == kNone) break;
      member.edge[best] = 1;
      v = other_end(k, best, v);
      member.vertex[v] = 1;
    }
  }
}

// Per curve edge that free ends lead to: ET_MC over burn time where the course of its fire ends. `curves` are all of a
// member.
class SticksOut {
 public:
  SticksOut(const SkeletonFamily& family, base::GraphPeeler curves, const std::vector<char>& on_sheet)
      : family_(family), k_(family.refined), ratio_(k_.complex.edges.size() - first_edge(), 0) {
    std::vector<Step> burned;  // outwards in
    curves.peel(
        [&](std::uint32_t e) -> const auto& { return k_.complex.edges[e]; },
        [&](std::uint32_t v, std::uint32_t e) { return !on_sheet[v] && !k_.medial_point[v] && k_.curve_edge[e]; },
        [&](std::uint32_t v, std::uint32_t e) {
          burned.push_back({v, e});
        });
    std::vector<double> onward(k_.complex.vertex_count, base::kNever);  // of the edge over which the vertex burned on
    std::vector<char> burns(k_.complex.vertex_count, 0);
    for (auto step = burned.rbegin(); step != burned.rend(); ++step) {
      const auto [v, e] = *step;
      const std::uint32_t next = other_end(k_, e, v);
      const bool same = burns[next] && k_.fire_goes_on[v];
      onward[v] = ratio_[e - first_edge()] = same ? onward[next] : std::min(onward[next], ratio_here(e));
      burns[v] = 1;
    }
  }
  double operator()(std::uint32_t e) const { return ratio_[e - first_edge()]; }

 private:
  struct Step {
    std::uint32_t vertex, edge;
  };
  std::size_t first_edge() const { return 2 * std::size_t{k_.doors}; }
  double ratio_here(std::uint32_t e) const {
    const auto [a, b] = k_.complex.edges[e];
    return family_.thickness_of(e) / std::max(k_.burn_time[a], k_.burn_time[b]);
  }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  std::vector<double> ratio_;
};

}  // namespace

Member member_of(const SkeletonFamily& family, double theta2, double theta1, double radii, double tips) {
  const RefinedAxis& k = family.refined;
  Member member;
  const std::size_t edges = k.complex.edges.size(), vertices = k.complex.vertex_count;
  member.vertex.resize(vertices);
  member.edge.resize(edges);
  member.face.resize(k.complex.face_count());
  base::for_indices(vertices, [&](std::size_t v) { member.vertex[v] = family.vertex_sheet_level[v] >= theta2; });
  base::for_indices(edges, [&](std::size_t e) { member.edge[e] = family.edge_sheet_level[e] >= theta2; });
  base::for_indices(member.face.size(), [&](std::size_t f) { member.face[f] = family.face_sheet_level[f] >= theta2; });

  // Curves: free edges of a thickness below theta1 are removed. No end of an edge of a face is free.
  std::vector<char> on_face(edges, 0), on_sheet(vertices, 0);
  for (std::size_t f = 0; f < member.face.size(); ++f)
    if (member.face[f])
      for (const std::uint32_t e : k.complex.sides(f)) on_face[e] = 1;
  base::GraphPeeler left(vertices);
  for (std::uint32_t e = 0; e < edges; ++e) {
    if (on_face[e])
      for (const std::uint32_t v : k.complex.edges[e]) on_sheet[v] = 1;
    else if (member.edge[e])
      for (const std::uint32_t v : k.complex.edges[e]) left.add(v, e);
  }
  const auto peel = [&](const auto& stays) {
    left.peel(
        [&](std::uint32_t e) -> const auto& { return k.complex.edges[e]; },
        [&](std::uint32_t v, std::uint32_t e) {
          return !on_sheet[v] && !k.medial_point[v] && k.curve_edge[e] && !stays(e);
        },
        [&](std::uint32_t v, std::uint32_t e) { member.edge[e] = member.vertex[v] = 0; });
  };
  const auto is_thick = [&](std::uint32_t e) { return family.thickness_of(e) >= theta1; };
  if (radii > 0) {
    const SticksOut sticks_out(family, left, on_sheet);
    peel([&](std::uint32_t e) { return is_thick(e) && sticks_out(e) >= radii; });
  } else {
    peel(is_thick);
  }
  if (tips < kNever) grow_tips(family, tips, left, on_sheet, member);
  return member;
}

}  // namespace quench::skeleton
