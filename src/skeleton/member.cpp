// SPDX-License-Identifier: Apache-2.0
#include "skeleton/member.h"

#include <algorithm>
#include <cmath>

#include "base/constants.h"
#include "base/csr.h"
#include "base/graph_peeler.h"
#include "skeleton/branch_growth.h"
#include "skeleton/sheet_cut.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// ET_MC counts up to so many times the growth. Under a rough surface fires run out to it and back inwards along what
// pruning leaves of sheets of noise: courses that are long, and end at balls that all but contain them.
constexpr double kMostPerGrowth = 1.5;

// Edges and vertices of K, or pieces of edges and points on them.
class CurvesOf {
 public:
  CurvesOf(const SkeletonFamily& family, const Member& member) : family_(family), k_(family.refined), member_(member) {}
  const std::array<std::uint32_t, 2>& ends(std::uint32_t e) const { return ends_of(k_, member_, e); }
  std::uint32_t other_end(std::uint32_t e, std::uint32_t v) const { return ends(e)[ends(e)[0] == v]; }
  bool is_curve(std::uint32_t e) const { return k_.curve_edge[in_k(e)]; }
  double thickness(std::uint32_t e) const { return family_.thickness_of(in_k(e)); }
  double level(std::uint32_t e) const { return family_.level_of(in_k(e)); }
  /// ET_MC over burn time; that of the end that burns where the other one is on a pocket.
  double ratio(std::uint32_t e) const {
    const auto [a, b] = k_.complex.edges[in_k(e)];
    const auto [first, second] = std::minmax(k_.burn_time[a], k_.burn_time[b]);
    return thickness(e) / (std::isinf(second) ? first : second);
  }
  /// Per step inwards over an edge, by how many burn times what is outside sticks out.
  std::vector<double> ratios(std::span<const StepInwards> inwards, std::span<const std::uint32_t> edge) const {
    std::vector<Vec3> drawn(k_.points);  // duals that passed the fire on lie on the door it went to
    for (std::uint32_t v = k_.nodes + k_.doors; v < drawn.size(); ++v)
      if (const std::uint32_t e = k_.exit[v]; e != kNone && member_.edge[e] == Member::kWhole)
        drawn[v] = k_.points[skeleton::other_end(k_, e, v)];
    std::vector<double> times(k_.burn_time);
    for (const SheetCut::Point& p : member_.cut.points) {
      const auto [a, b] = k_.complex.edges[p.edge];
      drawn.emplace_back((1 - p.along) * drawn[a] + p.along * drawn[b]);
      times.push_back(std::lerp(times[a], times[b], p.along));
    }
    const std::vector<double> growth = growth_to_contain(inwards, drawn, times);
    std::vector<double> found(growth.size());
    for (std::size_t s = 0; s < found.size(); ++s)
      found[s] = std::min(ratio(edge[s]), kMostPerGrowth * growth[s] / times[inwards[s].vertex]);
    return found;
  }
  bool is_of_plane() const { return k_.plane; }
  bool is_medial_point(std::uint32_t v) const { return v < k_.complex.vertex_count && k_.medial_point[v]; }
  /// As RefinedAxis::exit; of edges that are not cut.
  std::uint32_t exit(std::uint32_t v) const { return v < k_.complex.vertex_count ? k_.exit[v] : kNone; }

 private:
  std::uint32_t in_k(std::uint32_t e) const { return edge_in_k(k_, member_, e); }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  const Member& member_;
};

// Of branches at a medial point one is as good as another one, as the two halves of a tube are, or in the plane those to
// the corners of a square.
constexpr double kEqual = 0.8;

// Per curve edge that a free end leads to: the smallest ratio on the way from it to what has no free end. Where a tree
// would go as a whole, ratios are multiples of that of the best branch at its medial point, of at least theta1, or of the
// second where that is as good: so a course stays. `left` are the curves of a member whose balls count, `edges` its
// number of edges.
std::vector<double> least_ratios(const CurvesOf& curves, double theta1, double radii, base::GraphPeeler left,
                                 const std::vector<char>& on_sheet, std::size_t edges) {
  std::vector<StepInwards> inwards;
  std::vector<std::uint32_t> edge;  // per step
  left.peel(
      [&](std::uint32_t e) -> const auto& { return curves.ends(e); },
      [&](std::uint32_t v, std::uint32_t e) {
        return !on_sheet[v] && !curves.is_medial_point(v) && curves.is_curve(e);
      },
      [&](std::uint32_t v, std::uint32_t e) {
        inwards.push_back({v, curves.other_end(e, v)});
        edge.push_back(e);
      });
  const std::vector<double> ratio = curves.ratios(inwards, edge);
  std::vector<std::array<double, 3>> largest(on_sheet.size(), {0, 0, 0});  // three ratios at medial points
  for (std::size_t s = 0; s < inwards.size(); ++s) {
    const std::uint32_t to = inwards[s].to;
    if (!curves.is_medial_point(to) || curves.thickness(edge[s]) < theta1) continue;
    double next = ratio[s];
    for (double& other : largest[to])
      if (next > other) std::swap(next, other);
  }
  std::vector<double> least(edges, kNever), from(on_sheet.size(), kNever), scale(on_sheet.size(), 1);
  for (std::uint32_t v = 0; v < scale.size(); ++v) {
    const auto [first, second, third] = largest[v];
    if (curves.is_of_plane() && third > kEqual * second) continue;  // no course is the longest: a point stays
    const double q = second >= kEqual * first ? second : first;
    if (q > 0 && q < radii && !on_sheet[v]) scale[v] = radii / q;
  }
  for (std::size_t s = inwards.size(); s-- > 0;) {
    const auto [v, to] = inwards[s];
    scale[v] = scale[to];
    // Rounding must not drop the second branch.
    least[edge[s]] = from[v] = std::min(from[to], ratio[s] * scale[to] * (1 + 1e-12));
  }
  return least;
}

// In the plane a tip ends at a fork where an end of the shape has two corners: the second branch is at least so thick
// as a part of the first, or less where the first sticks out of the disk there by less than half a radius.
constexpr double kFork = 0.7, kBluntFork = 0.25, kBlunt = 0.5;

// What free ends of curves grow back along.
class Tips {
 public:
  Tips(const CurvesOf& curves, const Member& member, double radii, double from_thickness, bool plane)
      : curves_(curves), radii_(radii), from_thickness_(from_thickness), plane_(plane) {
    const auto edges = static_cast<std::uint32_t>(member.edge.size());
    pruned_ = base::Csr<std::uint32_t>::group(member.vertex.size(), [&](const auto& emit) {
      for (std::uint32_t e = 0; e < edges; ++e)
        if (member.edge[e] == Member::kNo && curves_.is_curve(e))
          for (const std::uint32_t v : curves_.ends(e)) emit(v, e);
    });
  }

  // What sticks out again behind a part that does not is pruned because that part is thick: the tip then ends where it
  // sticks out least, in the middle of that part.
  std::vector<std::uint32_t> at(std::uint32_t v) const {
    std::vector<std::uint32_t> path;
    std::size_t to_least = 0;
    double least = kNever;
    for (;;) {
      const std::uint32_t e = next(v, path.empty() ? kNone : path.back());
      if (e == kNone) return path;
      if (plane_) {
        path.push_back(e);
        v = curves_.other_end(e, v);
        continue;
      }
      const double ratio = curves_.ratio(e);
      if (least < radii_ && ratio >= radii_) break;
      path.push_back(e);
      if (ratio < least) {
        least = ratio;
        to_least = path.size();
      }
      v = curves_.other_end(e, v);
    }
    path.resize(to_least);
    return path;
  }

 private:
  // The pruned edge at a vertex that would have stayed longest; ties: the smaller index.
  std::uint32_t next(std::uint32_t v, std::uint32_t from) const {
    std::uint32_t best = kNone;
    double second = 0;
    for (const std::uint32_t e : pruned_[v]) {
      if (e == from || curves_.thickness(e) < from_thickness_) continue;
      const bool better = best == kNone || curves_.level(e) > curves_.level(best);
      if (best != kNone) second = std::max(second, curves_.level(better ? best : e));
      if (better) best = e;
    }
    if (!plane_ || best == kNone) return best;
    const double fork = curves_.ratio(best) < kBlunt ? kBluntFork : kFork;
    return second > fork * curves_.level(best) ? kNone : best;
  }

  const CurvesOf& curves_;
  double radii_, from_thickness_;
  bool plane_;
  base::Csr<std::uint32_t> pruned_;
};

// Prunes the curves of a member, and lets their ends grow back.
class CurvePruning {
 public:
  CurvePruning(const SkeletonFamily& family, Sheets& sheets)
      : plane_(family.refined.plane),
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
  void prune(double theta1, double radii, double balls_above) {
    const auto is_thick = [&](std::uint32_t e) { return curves_.thickness(e) >= theta1; };
    if (radii > 0) {
      peel([&](std::uint32_t e) { return curves_.thickness(e) >= std::min(theta1, balls_above); });
      const std::vector<double> least = least_ratios(curves_, theta1, radii, left_, on_sheet_, member_.edge.size());
      peel([&](std::uint32_t e) { return is_thick(e) && least[e] >= radii; });
    } else {
      peel(is_thick);
    }
  }

  // Lets the free ends of curves grow back along curves that were pruned. What grows back is a path that begins at a
  // free end, so topology does not change.
  void grow_tips(double radii, double from_thickness) {
    const Tips tips(curves_, member_, radii, from_thickness, plane_);
    for (std::uint32_t end = 0; end < left_.vertex_count(); ++end) {
      if (!left_.edges_at(end).single() || on_sheet_[end] || !member_.vertex[end]) continue;
      // An end that is drawn where its only edge leads is none there unless that is on the way of one curve.
      if (const std::uint32_t e = left_.edges_at(end).only(); curves_.exit(end) == e) {
        const std::uint32_t drawn = curves_.other_end(e, end);
        if (on_sheet_[drawn] || left_.edges_at(drawn).count() != 2) continue;
      }
      std::uint32_t v = end;
      for (const std::uint32_t e : tips.at(end)) {
        member_.edge[e] = Member::kWhole;
        v = curves_.other_end(e, v);
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

  bool plane_;
  Member& member_;
  CurvesOf curves_;
  std::vector<char> on_sheet_;
  base::GraphPeeler left_;
};

}  // namespace

Member member_of(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options) {
  Sheets sheets = sheets_above(family, theta2, options.regrow_rims_above, options.minor_curve);
  CurvePruning curves(family, sheets);
  curves.prune(theta1, options.theta1_radii, options.balls_above);
  if (options.regrow_tips_above < kNever) curves.grow_tips(options.theta1_radii, options.regrow_tips_above);
  return std::move(sheets.member);
}

Member cells_from(const SkeletonFamily& family, double theta2, double theta1) {
  Sheets sheets = whole_sheets_above(family, theta2);
  CurvePruning(family, sheets).prune(theta1, 0, theta1);
  return std::move(sheets.member);
}

}  // namespace quench::skeleton
