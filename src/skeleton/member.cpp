// SPDX-License-Identifier: Apache-2.0
#include "skeleton/member.h"

#include "base/constants.h"
#include "base/csr.h"
#include "base/graph_peeler.h"
#include "skeleton/sheet_cut.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// Prunes the curves of a member, and lets their ends grow back.
class CurvePruning {
 public:
  CurvePruning(const SkeletonFamily& family, Sheets& sheets)
      : family_(family),
        k_(family.refined),
        member_(sheets.member),
        on_sheet_(member_.vertex.size(), 0),
        left_(member_.vertex.size()) {
    for (std::uint32_t e = 0; e < member_.edge.size(); ++e) {
      if (member_.edge[e] != Member::kWhole) continue;
      const bool on_face = !sheets.faces_at[e].none();
      for (const std::uint32_t v : ends(e))
        if (on_face)
          on_sheet_[v] = 1;
        else
          left_.add(v, e);
    }
  }

  // Free edges of a thickness below theta1 are removed, and what is left of sides of sheets that are gone. No end of an
  // edge of a face is free.
  void prune(double theta1) {
    left_.peel(
        [&](std::uint32_t e) -> const auto& { return ends(e); },
        [&](std::uint32_t v, std::uint32_t e) {
          if (on_sheet_[v] || is_medial_point(v)) return false;
          return !is_curve(e) || family_.thickness_of(in_k(e)) < theta1;
        },
        [&](std::uint32_t v, std::uint32_t e) { member_.edge[e] = member_.vertex[v] = Member::kNo; });
  }

  // Lets the free ends of curves grow back along curves that were pruned. What grows back is a path that begins at a
  // free end, so topology does not change.
  void grow_tips(double from_thickness) {
    const auto edges = static_cast<std::uint32_t>(member_.edge.size());
    const auto pruned = base::Csr<std::uint32_t>::group(member_.vertex.size(), [&](const auto& emit) {
      for (std::uint32_t e = 2 * k_.doors; e < edges; ++e)
        if (is_curve(e) && member_.edge[e] == Member::kNo)
          for (const std::uint32_t v : ends(e)) emit(v, e);
    });
    for (std::uint32_t end = 0; end < left_.vertex_count(); ++end) {
      if (!left_.edges_at(end).single() || on_sheet_[end] || !member_.vertex[end]) continue;
      for (std::uint32_t v = end;;) {
        std::uint32_t best = kNone;  // ties: the smaller index
        for (const std::uint32_t e : pruned[v]) {
          if (member_.edge[e] || family_.thickness_of(in_k(e)) < from_thickness) continue;
          if (best == kNone || family_.level_of(in_k(e)) > family_.level_of(in_k(best))) best = e;
        }
        if (best == kNone) break;
        member_.edge[best] = Member::kWhole;
        v = ends(best)[0] == v ? ends(best)[1] : ends(best)[0];
        member_.vertex[v] = 1;
      }
    }
  }

 private:
  // Edges and vertices of K, or pieces of edges and points on them.
  std::uint32_t in_k(std::uint32_t e) const {
    const std::size_t edges = k_.complex.edges.size();
    return e < edges ? e : member_.cut.pieces[e - edges].edge;
  }
  const std::array<std::uint32_t, 2>& ends(std::uint32_t e) const {
    const std::size_t edges = k_.complex.edges.size();
    return e < edges ? k_.complex.edges[e] : member_.cut.pieces[e - edges].ends;
  }
  bool is_curve(std::uint32_t e) const { return k_.curve_edge[in_k(e)]; }
  bool is_medial_point(std::uint32_t v) const { return v < k_.complex.vertex_count && k_.medial_point[v]; }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  Member& member_;
  std::vector<char> on_sheet_;
  base::GraphPeeler left_;
};

}  // namespace

Member member_of(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options) {
  Sheets sheets = sheets_above(family, theta2, options.regrow_rims_above, options.minor_curve);
  CurvePruning curves(family, sheets);
  curves.prune(theta1);
  if (options.regrow_tips_above < kNever) curves.grow_tips(options.regrow_tips_above);
  return std::move(sheets.member);
}

Member cells_from(const SkeletonFamily& family, double theta2, double theta1) {
  Sheets sheets = whole_sheets_above(family, theta2);
  CurvePruning(family, sheets).prune(theta1);
  return std::move(sheets.member);
}

}  // namespace quench::skeleton
