// SPDX-License-Identifier: Apache-2.0
#include "skeleton/member.h"

#include <algorithm>
#include <array>

#include "base/constants.h"
#include "base/csr.h"
#include "base/graph_peeler.h"
#include "base/parallel.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// ET_MC over burn time.
double ratio_of(const SkeletonFamily& family, std::uint32_t e) {
  const auto [a, b] = family.refined.complex.edges[e];
  return family.thickness_of(e) / std::max(family.refined.burn_time[a], family.refined.burn_time[b]);
}

// Per curve edge that a free end leads to: the smallest ratio on the way from it to what has no free end. Where a tree
// would go as a whole, ratios are multiples of that of the second branch at its medial point, so that its longest
// course stays: of branches of at least theta1, which every floor has. `curves` are all of a member.
std::vector<double> least_ratios(const SkeletonFamily& family, double theta1, double radii, base::GraphPeeler curves,
                                 const std::vector<char>& on_sheet) {
  const RefinedAxis& k = family.refined;
  struct Step {
    std::uint32_t vertex, edge;
  };
  std::vector<Step> inwards;
  std::vector<std::array<double, 2>> largest(k.complex.vertex_count, {0, 0});  // two ratios at medial points
  const auto note = [&](std::array<double, 2>& two, double ratio) {
    if (ratio > two[1]) two = {std::max(two[0], ratio), std::min(two[0], ratio)};
  };
  curves.peel(
      [&](std::uint32_t e) -> const auto& { return k.complex.edges[e]; },
      [&](std::uint32_t v, std::uint32_t e) { return !on_sheet[v] && !k.medial_point[v] && k.curve_edge[e]; },
      [&](std::uint32_t v, std::uint32_t e) {
        inwards.push_back({v, e});
        if (const std::uint32_t to = other_end(k, e, v); k.medial_point[to] && family.thickness_of(e) >= theta1)
          note(largest[to], ratio_of(family, e));
      });
  std::vector<double> least(k.complex.edges.size(), kNever), from(k.complex.vertex_count, kNever),
      scale(k.complex.vertex_count, 1);
  for (std::uint32_t v = 0; v < scale.size(); ++v) {
    const auto [first, second] = largest[v];
    const double q = second > 0 ? second : first;
    if (q > 0 && q < radii && !on_sheet[v]) scale[v] = radii / q;
  }
  for (auto step = inwards.rbegin(); step != inwards.rend(); ++step) {
    const auto [v, e] = *step;
    const std::uint32_t to = other_end(k, e, v);
    scale[v] = scale[to];
    // Rounding must not drop the second branch.
    least[e] = from[v] = std::min(from[to], ratio_of(family, e) * scale[to] * (1 + 1e-12));
  }
  return least;
}

// Lets the free ends of curves grow back along curves that were pruned. What grows back is a path that begins at a free
// end, so topology does not change.
class Tips {
 public:
  Tips(const SkeletonFamily& family, double radii, double from_thickness, Member& member)
      : family_(family), k_(family.refined), radii_(radii), from_thickness_(from_thickness), member_(member) {
    const auto edges = static_cast<std::uint32_t>(k_.complex.edges.size());
    pruned_ = base::Csr<std::uint32_t>::group(k_.complex.vertex_count, [&](const auto& emit) {
      for (std::uint32_t e = 2 * k_.doors; e < edges; ++e)
        if (k_.curve_edge[e] && !member.edge[e])
          for (const std::uint32_t v : k_.complex.edges[e]) emit(v, e);
    });
  }

  void grow(const base::GraphPeeler& left, const std::vector<char>& on_sheet) {
    for (std::uint32_t end = 0; end < left.vertex_count(); ++end) {
      if (!left.edges_at(end).single() || on_sheet[end] || !member_.vertex[end]) continue;
      // An end that is drawn where its only edge leads is none there unless that is on the way of one curve.
      if (const std::uint32_t e = left.edges_at(end).only(); k_.exit[end] == e) {
        const std::uint32_t drawn = other_end(k_, e, end);
        if (on_sheet[drawn] || left.edges_at(drawn).count() != 2) continue;
      }
      std::uint32_t v = end;
      for (const std::uint32_t e : tip_at(end)) {
        member_.edge[e] = 1;
        v = other_end(k_, e, v);
        member_.vertex[v] = 1;
      }
    }
  }

 private:
  // What sticks out again behind a part that does not is pruned because that part is thick: the tip then ends where it
  // sticks out least, in the middle of that part.
  std::vector<std::uint32_t> tip_at(std::uint32_t v) const {
    std::vector<std::uint32_t> path;
    std::size_t to_least = 0;
    double least = kNever;
    for (;;) {
      const std::uint32_t e = next(v, path.empty() ? kNone : path.back());
      if (e == kNone) return path;
      const double ratio = ratio_of(family_, e);
      if (least < radii_ && ratio >= radii_) break;
      path.push_back(e);
      if (ratio < least) {
        least = ratio;
        to_least = path.size();
      }
      v = other_end(k_, e, v);
    }
    path.resize(to_least);
    return path;
  }
  // The pruned edge at a vertex that would have stayed longest; ties: the smaller index.
  std::uint32_t next(std::uint32_t v, std::uint32_t from) const {
    std::uint32_t best = kNone;
    for (const std::uint32_t e : pruned_[v])
      if (e != from && family_.thickness_of(e) >= from_thickness_ &&
          (best == kNone || family_.level_of(e) > family_.level_of(best)))
        best = e;
    return best;
  }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  double radii_, from_thickness_;
  Member& member_;
  base::Csr<std::uint32_t> pruned_;
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
    const std::vector<double> least = least_ratios(family, theta1, radii, left, on_sheet);
    peel([&](std::uint32_t e) { return is_thick(e) && least[e] >= radii; });
  } else {
    peel(is_thick);
  }
  if (tips < kNever) Tips(family, radii, tips, member).grow(left, on_sheet);
  return member;
}

}  // namespace quench::skeleton
