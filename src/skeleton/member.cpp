// SPDX-License-Identifier: Apache-2.0
#include "skeleton/member.h"

#include <algorithm>

#include "base/constants.h"
#include "base/csr.h"
#include "base/graph_peeler.h"
#include "skeleton/sheet_cut.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// Edges and vertices of K, or pieces of edges and points on them.
class CurvesOf {
 public:
  CurvesOf(const SkeletonFamily& family, const Member& member)
      : family_(family), k_(family.refined), member_(member), edges_(k_.complex.edges.size()) {}
  const std::array<std::uint32_t, 2>& ends(std::uint32_t e) const {
    return e < edges_ ? k_.complex.edges[e] : member_.cut.pieces[e - edges_].ends;
  }
  std::uint32_t other_end(std::uint32_t e, std::uint32_t v) const { return ends(e)[ends(e)[0] == v]; }
  bool is_curve(std::uint32_t e) const { return k_.curve_edge[in_k(e)]; }
  double thickness(std::uint32_t e) const { return family_.thickness_of(in_k(e)); }
  double level(std::uint32_t e) const { return family_.level_of(in_k(e)); }
  double thickness_in_burn_times(std::uint32_t e) const {
    const auto [a, b] = k_.complex.edges[in_k(e)];
    return thickness(e) / std::max(k_.burn_time[a], k_.burn_time[b]);
  }
  bool is_medial_point(std::uint32_t v) const { return v < k_.complex.vertex_count && k_.medial_point[v]; }
  bool fire_goes_on(std::uint32_t v) const { return v >= k_.complex.vertex_count || k_.fire_goes_on[v]; }

 private:
  std::uint32_t in_k(std::uint32_t e) const { return e < edges_ ? e : member_.cut.pieces[e - edges_].edge; }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  const Member& member_;
  std::size_t edges_;
};

// Per curve edge that free ends lead to: ET_MC over burn time where the course of its fire ends. `left` are all curves
// of a member.
class SticksOut {
 public:
  SticksOut(const CurvesOf& curves, base::GraphPeeler left, const std::vector<char>& on_sheet, std::size_t edges)
      : ratio_(edges, 0) {
    std::vector<Step> burned;  // outwards in
    left.peel(
        [&](std::uint32_t e) -> const auto& { return curves.ends(e); },
        [&](std::uint32_t v, std::uint32_t e) {
          return !on_sheet[v] && !curves.is_medial_point(v) && curves.is_curve(e);
        },
        [&](std::uint32_t v, std::uint32_t e) {
          burned.push_back({v, e});
        });
    std::vector<double> onward(on_sheet.size(), kNever);  // of the edge over which the vertex burned on
    std::vector<char> burns(on_sheet.size(), 0);
    for (auto step = burned.rbegin(); step != burned.rend(); ++step) {
      const auto [v, e] = *step;
      const std::uint32_t next = curves.other_end(e, v);
      const bool same = burns[next] && curves.fire_goes_on(v);
      onward[v] = ratio_[e] = same ? onward[next] : std::min(onward[next], curves.thickness_in_burn_times(e));
      burns[v] = 1;
    }
  }
  double operator()(std::uint32_t e) const { return ratio_[e]; }

 private:
  struct Step {
    std::uint32_t vertex, edge;
  };
  std::vector<double> ratio_;
};

// Prunes the curves of a member, and lets their ends grow back.
class CurvePruning {
 public:
  CurvePruning(const SkeletonFamily& family, Sheets& sheets)
      : k_(family.refined),
        member_(sheets.member),
        curves_(family, member_),
        on_sheet_(member_.vertex.size(), 0),
        left_(member_.vertex.size()) {
    for (std::uint32_t e = 0; e < member_.edge.size(); ++e) {
      if (member_.edge[e] != Member::kWhole) continue;
      const bool on_face = !sheets.faces_at[e].none();
      for (const std::uint32_t v : curves_.ends(e))
        if (on_face)
          on_sheet_[v] = 1;
        else
          left_.add(v, e);
    }
  }

  // Free edges of a thickness below theta1 are removed, or below so many burn times, and what is left of sides of
  // sheets that are gone. No end of an edge of a face is free.
  void prune(double theta1, double radii) {
    const auto is_thick = [&](std::uint32_t e) { return curves_.thickness(e) >= theta1; };
    if (radii > 0) {
      peel([](std::uint32_t) { return true; });
      const SticksOut sticks_out(curves_, left_, on_sheet_, member_.edge.size());
      peel([&](std::uint32_t e) { return is_thick(e) && sticks_out(e) >= radii; });
    } else {
      peel(is_thick);
    }
  }

  // Lets the free ends of curves grow back along curves that were pruned. What grows back is a path that begins at a
  // free end, so topology does not change.
  void grow_tips(double from_thickness) {
    const auto edges = static_cast<std::uint32_t>(member_.edge.size());
    const auto pruned = base::Csr<std::uint32_t>::group(member_.vertex.size(), [&](const auto& emit) {
      for (std::uint32_t e = 2 * k_.doors; e < edges; ++e)
        if (curves_.is_curve(e) && member_.edge[e] == Member::kNo)
          for (const std::uint32_t v : curves_.ends(e)) emit(v, e);
    });
    for (std::uint32_t end = 0; end < left_.vertex_count(); ++end) {
      if (!left_.edges_at(end).single() || on_sheet_[end] || !member_.vertex[end]) continue;
      for (std::uint32_t v = end;;) {
        std::uint32_t best = kNone;  // ties: the smaller index
        for (const std::uint32_t e : pruned[v]) {
          if (member_.edge[e] || curves_.thickness(e) < from_thickness) continue;
          if (best == kNone || curves_.level(e) > curves_.level(best)) best = e;
        }
        if (best == kNone) break;
        member_.edge[best] = Member::kWhole;
        v = curves_.other_end(best, v);
        member_.vertex[v] = 1;
      }
    }
  }

 private:
  template <class Stays>
  void peel(const Stays& stays) {
    left_.peel(
        [&](std::uint32_t e) -> const auto& { return curves_.ends(e); },
        [&](std::uint32_t v, std::uint32_t e) {
          if (on_sheet_[v] || curves_.is_medial_point(v)) return false;
          return !curves_.is_curve(e) || !stays(e);
        },
        [&](std::uint32_t v, std::uint32_t e) { member_.edge[e] = member_.vertex[v] = Member::kNo; });
  }

  const RefinedAxis& k_;
  Member& member_;
  CurvesOf curves_;
  std::vector<char> on_sheet_;
  base::GraphPeeler left_;
};

}  // namespace

Member member_of(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options) {
  Sheets sheets = sheets_above(family, theta2, options.regrow_rims_above, options.minor_curve);
  CurvePruning curves(family, sheets);
  curves.prune(theta1, options.theta1_radii);
  if (options.regrow_tips_above < kNever) curves.grow_tips(options.regrow_tips_above);
  return std::move(sheets.member);
}

Member cells_from(const SkeletonFamily& family, double theta2, double theta1) {
  Sheets sheets = whole_sheets_above(family, theta2);
  CurvePruning(family, sheets).prune(theta1, 0);
  return std::move(sheets.member);
}

}  // namespace quench::skeleton
