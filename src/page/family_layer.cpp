// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "base/graph_peeler.h"
#include "page/layer.h"

namespace quench {
namespace {

std::vector<float> rounded_down(const std::vector<double>& levels) {
  std::vector<float> floats;
  floats.resize(levels.size());
  base::for_indices(levels.size(), [&](std::size_t i) { floats[i] = base::rounded_down(levels[i]); });
  return floats;
}

/// The least float that is not below `value`.
float rounded_up(double value) {
  const float below = base::rounded_down(value);
  return below < value ? std::nextafter(below, std::numeric_limits<float>::infinity()) : below;
}

/// Where each vertex of K is drawn: region duals at their exit doors, as skeletons are written. A dual without exit (in
/// a curve that never burns, or a medial point) goes to one of its two doors on the curves that stay longest, that
/// which burns last, unless three stay for ever. extract() decides the latter per member of the family, by the curves
/// the member has; a page can only decide once.
std::vector<std::uint32_t> drawn_at(const SkeletonFamily& family) {
  const RefinedAxis& k = family.refined;
  const std::uint32_t first_dual = k.nodes + k.doors;
  std::vector<std::uint32_t> at(k.complex.vertex_count);
  for (std::uint32_t v = 0; v < at.size(); ++v) at[v] = v;
  struct Longest {
    std::array<std::uint32_t, 2> edge{kNone, kNone};
    std::uint32_t endless = 0;
  };
  std::vector<Longest> longest(at.size() - std::min<std::size_t>(at.size(), first_dual));
  const auto level = [&](std::uint32_t e) { return e == kNone ? -1 : family.level_of(e); };
  for (std::uint32_t e = 2 * k.doors; e < k.complex.edges.size(); ++e) {
    const std::uint32_t v = k.complex.edges[e][1];
    if (!k.curve_edge[e] || v < first_dual || k.exit[v] != kNone) continue;
    auto& [edge, endless] = longest[v - first_dual];
    endless += std::isinf(family.level_of(e));
    if (level(e) > level(edge[0]))
      edge = {e, edge[0]};
    else if (level(e) > level(edge[1]))
      edge[1] = e;
  }
  for (std::uint32_t v = first_dual; v < at.size(); ++v) {
    const auto& [edge, endless] = longest[v - first_dual];
    if (const std::uint32_t e = k.exit[v]; e != kNone) {
      at[v] = k.complex.edges[e][0] == v ? k.complex.edges[e][1] : k.complex.edges[e][0];
    } else if (edge[1] != kNone && endless < 3) {
      const std::uint32_t a = k.complex.edges[edge[0]][0], b = k.complex.edges[edge[1]][0];
      // The doors are in the order of their edges, and the first of two that burn at a time is taken.
      at[v] = k.burn_time[b] > k.burn_time[a] || (k.burn_time[b] == k.burn_time[a] && edge[1] < edge[0]) ? b : a;
    }
  }
  return at;
}

/// Per edge: a side of a face.
std::vector<char> sides_of_faces(const RefinedAxis& k) {
  std::vector<char> on_face(k.complex.edges.size(), 0);
  for (const std::uint32_t e : k.complex.face_edges) on_face[e] = 1;
  return on_face;
}

std::size_t curves_off_sheets(const RefinedAxis& k) {
  const std::vector<char> on_face = sides_of_faces(k);
  std::size_t count = 0;
  for (std::size_t e = 0; e < on_face.size(); ++e) count += k.curve_edge[e] && !on_face[e];
  return count;
}

/// The curves off the sheets of a family at its floor, and how many of them a theta1 leaves.
class CurvePruning {
 public:
  explicit CurvePruning(const SkeletonFamily& family) : k_(family.refined), peeler_(k_.complex.vertex_count) {
    const std::vector<char> on_face = sides_of_faces(k_);
    thickness_.assign(k_.complex.edges.size(), std::numeric_limits<float>::infinity());
    for (std::uint32_t e = 0; e < thickness_.size(); ++e) {
      if (family.edge_sheet_level[e] < 0) continue;
      for (const std::uint32_t v : k_.complex.edges[e]) peeler_.add(v, e);
      if (!k_.curve_edge[e] || on_face[e]) continue;
      ++free_curves_;
      thickness_[e] = base::rounded_down(family.thickness_of(e));
    }
  }

  std::size_t left(float theta1) const {
    base::GraphPeeler peeler = peeler_;
    std::size_t count = free_curves_;
    peeler.peel(
        [&](std::uint32_t e) -> const auto& { return k_.complex.edges[e]; },
        [&](std::uint32_t v, std::uint32_t e) { return !k_.medial_point[v] && thickness_[e] < theta1; },
        [&](std::uint32_t, std::uint32_t) { --count; });
    return count;
  }

  /// A theta1 that leaves at most `most` curves, and at least nine tenths of that if such a theta1 exists; where more
  /// are never pruned, the one that prunes all others. The set of curves changes only just above a thickness.
  float floor(std::size_t most) const {
    std::vector<float> steps;
    for (const float thickness : thickness_)
      if (std::isfinite(thickness)) steps.push_back(thickness);
    std::sort(steps.begin(), steps.end());
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    const auto above = [&](std::size_t i) { return std::nextafter(steps[i], std::numeric_limits<float>::infinity()); };
    std::size_t low = 0, high = steps.size();  // the step is in [low, high)
    while (low + 1 < high) {
      const std::size_t middle = (low + high - 1) / 2, count = left(above(middle));
      if (count <= most && count >= most / 10 * 9) return above(middle);
      if (count <= most)
        high = middle + 1;
      else
        low = middle + 1;
    }
    return low < steps.size() ? above(low) : 0;
  }

 private:
  const RefinedAxis& k_;
  base::GraphPeeler peeler_;
  std::vector<float> thickness_;  ///< per edge; infinite where it is not a curve or is on a sheet
  std::size_t free_curves_ = 0;
};

/// What sliders show below half of what was asked for may take this share of the triangles.
constexpr double kShareBelow = 0.4;

/// Raises the floor of theta2 as far as a budget of triangles asks for; returns the number of those that are left.
std::size_t keep_triangles(SkeletonFamily& family, std::size_t budget, double asked) {
  const CellComplex& c = family.refined.complex;
  const std::vector<float> levels = rounded_down(family.face_sheet_level);
  const page::FacesByLevel by_level(c, levels);
  float level = by_level.within(budget).level;
  if (std::isfinite(asked)) {
    const auto share = static_cast<std::size_t>(kShareBelow * static_cast<double>(budget));
    level = std::max(level, std::min(base::rounded_down(asked / 2), by_level.within(share).level));
  }
  std::size_t triangles = 0;
  for (std::size_t f = 0; f < c.face_count(); ++f)
    if (levels[f] >= level) triangles += c.corners(f).size() - 2;
  family = with_floor(std::move(family), level, 0);
  return triangles;
}

page::LayerCells cells_of(const SkeletonFamily& family) {
  page::LayerCells cells;
  cells.levels.push_back({"sheet_level", rounded_down(family.vertex_sheet_level), rounded_down(family.edge_sheet_level),
                          rounded_down(family.face_sheet_level)});
  const page::Levels& levels = cells.levels.front();
  for (const float level : levels.edge) cells.edge.push_back(level >= 0);
  for (const float level : levels.vertex) cells.vertex.push_back(level >= 0);
  cells.faces = page::FacesByLevel(family.refined.complex, levels.face).order();
  return cells;
}

/// The levels at the corners of faces, in their order.
std::vector<float> corner_levels(const SkeletonFamily& family, const std::vector<std::uint32_t>& faces) {
  const std::vector<std::uint32_t>& begin = family.refined.complex.face_offsets;
  std::vector<float> levels;
  for (const std::uint32_t f : faces)
    levels.insert(levels.end(), family.corner_sheet_level.begin() + begin[f],
                  family.corner_sheet_level.begin() + begin[f + 1]);
  return levels;
}

/// Which rows are curves and medial points, and the thickness of the curves.
void add_curves(Page& page, const SkeletonFamily& family, const page::LayerRows& rows) {
  const RefinedAxis& k = family.refined;
  std::vector<std::uint32_t> edges, medial_points;
  std::vector<float> thickness;
  for (std::uint32_t e = 0; e < k.curve_edge.size(); ++e)
    if (k.curve_edge[e] && rows.edge[e] != kNone) {
      edges.push_back(rows.edge[e]);
      thickness.push_back(e < 2 * k.doors ? std::numeric_limits<float>::infinity()
                                          : base::rounded_down(family.thickness_of(e)));
    }
  for (std::uint32_t v = 0; v < k.medial_point.size(); ++v)
    if (k.medial_point[v] && rows.vertex[v] != kNone) medial_points.push_back(rows.vertex[v]);
  page.arrays.push_back({"family/curve_edges", 1, std::move(edges)});
  page.arrays.push_back({"family/curve_thickness", 1, std::move(thickness)});
  page.arrays.push_back({"family/medial_points", 1, std::move(medial_points)});
}

/// The measures of the vertices, each at the place `at` where it is drawn.
void add_vertex_measures(Page& page, const RefinedAxis& k, const std::vector<std::uint32_t>& at,
                         const page::LayerRows& rows) {
  const auto add = [&](const char* name, const auto& value) {
    page::add_measure(page, "family", name, rows, [&](std::uint32_t v) { return value(at[v]); });
  };
  add("radius", [&](std::uint32_t v) { return k.radius[v]; });
  page::each_fire_measure(k, k.curve_vertex, add);
}

/// One sentence, where sliders do not reach what was asked for.
void note_floors(Page& page) {
  std::string begin;
  const auto add = [&](const char* name, double floor, const std::optional<double>& asked) {
    if (asked && base::rounded_down(*asked) < floor)
      begin += fmt::format("{}{} = {}", begin.empty() ? "" : " and ", name, page::length_text(page, floor));
  };
  add("theta2", *page.theta2_floor, page.theta2);
  add("theta1", *page.theta1_floor, page.theta1);
  if (!begin.empty())
    page.note = fmt::format("The sliders begin at {}: below, this shape has more triangles than the page holds{}",
                            begin, page::limit_text(page));
}

}  // namespace

// Why floors are harmless. Let L(t) = {sheet level >= t} with the curves, and P(X, s) what is left of a subcomplex X
// after the pruning for theta1 = s: as long as some vertex v that is not a medial point is in one edge e of X only, e
// is a curve, not a side of a face of X, and thickness(e) < s, the pair (v, e) is removed. Such a pair of X is one of
// every subcomplex of X that has e: fewer cells are around v and e there. (*)
//
// 1. P(X, s) does not depend on the order (a pair that could go can still go after others went).
// 2. Nested: P(L(t'), s') is part of P(L(t), s) for t' >= t, s' >= s. Let Y = P(L(t'), s'), part of L(t') and so of
//    L(t), and look at the first pair (v, e) of the pruning of L(t) that is not missing in Y. If e is in Y, the pair
//    could go from Y by (*), but nothing can go from Y. Else v is in Y and all its edges are not: v is a component of
//    Y. But members have the homotopy type of the axis, component by component, and every component that is a tree of
//    curves keeps its medial point, which v is not.
// 3. Hence with K0 = P(L(t), s), for t' >= t and s' >= s: P(L(t') with K0, s') = P(L(t'), s'), "with" for the common
//    cells. The pairs that go from L(t) in the pruning for s, those that L(t') has, can go from L(t') in the same order
//    by (*) (that v remains without e is excluded as in 2), all with thickness < s <= s', and what they leave is L(t')
//    with K0. The rest is 1.
//
// So a family or a page that holds the cells of K0 gives every member with theta2 >= t, theta1 >= s by the same rule.
std::size_t add_family(Page& page, SkeletonFamily family, std::size_t max_triangles) {
  const double asked = page.theta2.value_or(0);
  std::size_t triangles = keep_triangles(family, max_triangles, asked), curves = curves_off_sheets(family.refined);
  if (triangles + curves > max_triangles) {
    triangles = keep_triangles(family, max_triangles / 5 * 4, asked);
    curves = curves_off_sheets(family.refined);
  }
  if (triangles + curves > max_triangles) {
    const float theta1 = CurvePruning(family).floor(max_triangles - std::min(max_triangles, triangles));
    family = with_floor(std::move(family), 0, theta1);
  }

  const page::LayerCells cells = cells_of(family);
  const std::vector<std::uint32_t> at = drawn_at(family);
  const RefinedAxis& k = family.refined;
  std::vector<Vec3> points(at.size());
  base::for_indices(at.size(), [&](std::size_t v) { points[v] = k.points[at[v]]; });
  const page::LayerRows rows = page::add_layer(page, "family", k.complex, points, cells);
  page.arrays.push_back({"family/corner_level", 1, corner_levels(family, cells.faces)});
  add_curves(page, family, rows);
  add_vertex_measures(page, k, at, rows);

  page.theta2_floor = rounded_up(family.theta2_floor);
  page.theta1_floor = rounded_up(family.theta1_floor);
  note_floors(page);
  return triangles;
}

}  // namespace quench
