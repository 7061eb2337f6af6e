// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "page/layer.h"

namespace quench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

std::vector<float> comparable(const std::vector<double>& levels) {
  std::vector<float> floats;
  floats.reserve(levels.size());
  for (const double level : levels) floats.push_back(page::rounded_down(level));
  return floats;
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

/// The curves off the sheets at the floor of theta2, and what the pruning for a theta1 leaves of them.
class CurvePruning {
 public:
  CurvePruning(const SkeletonFamily& family, const page::LayerCells& cells, const std::vector<char>& on_face)
      : k_(family.refined), degree_(k_.complex.vertex_count, 0), edges_xor_(degree_.size(), 0) {
    thickness_.assign(k_.complex.edges.size(), std::numeric_limits<float>::infinity());
    for (std::uint32_t e = 0; e < thickness_.size(); ++e) {
      if (!cells.edge[e]) continue;
      for (const std::uint32_t v : k_.complex.edges[e]) {
        ++degree_[v];
        edges_xor_[v] ^= e;
      }
      if (!k_.curve_edge[e] || on_face[e]) continue;
      ++free_curves_;
      thickness_[e] = page::rounded_down(family.thickness_of(e));
      if (std::isfinite(thickness_[e])) steps_.push_back(thickness_[e]);
    }
    std::sort(steps_.begin(), steps_.end());
    steps_.erase(std::unique(steps_.begin(), steps_.end()), steps_.end());
  }

  /// How many curves are left; takes what is pruned off `cells`. Fixed keys: any order gives the same.
  std::size_t left(float theta1, page::LayerCells* cells = nullptr) const {
    std::vector<std::uint32_t> degree = degree_, edges_xor = edges_xor_, stack;
    std::size_t count = free_curves_;
    const auto offer = [&](std::uint32_t v) {
      if (degree[v] == 1 && !k_.medial_point[v] && thickness_[edges_xor[v]] < theta1) stack.push_back(v);
    };
    for (std::uint32_t v = 0; v < degree.size(); ++v) offer(v);
    while (!stack.empty()) {
      const std::uint32_t v = stack.back();
      stack.pop_back();
      if (degree[v] != 1) continue;
      const std::uint32_t e = edges_xor[v];
      const auto [a, b] = k_.complex.edges[e];
      const std::uint32_t other = a == v ? b : a;
      degree[v] = 0;
      --degree[other];
      edges_xor[other] ^= e;
      --count;
      if (cells) cells->edge[e] = cells->vertex[v] = 0;
      offer(other);
    }
    return count;
  }

  /// A theta1 that leaves at most `most` curves, and nine tenths of that or as many as there can be; where what never
  /// goes is more, that at which the rest is gone. Sets change only just above a thickness.
  float floor(std::size_t most) const {
    const auto above = [&](std::size_t i) { return std::nextafter(steps_[i], std::numeric_limits<float>::infinity()); };
    std::size_t low = 0, high = steps_.size();  // the step is in [low, high)
    while (low + 1 < high) {
      const std::size_t middle = (low + high - 1) / 2, count = left(above(middle));
      if (count <= most && count >= most / 10 * 9) return above(middle);
      if (count <= most)
        high = middle + 1;
      else
        low = middle + 1;
    }
    return low < steps_.size() ? above(low) : 0;
  }

 private:
  const RefinedAxis& k_;
  std::vector<std::uint32_t> degree_, edges_xor_;
  std::vector<float> thickness_;  ///< infinite where an edge is no curve, or on a sheet
  std::vector<float> steps_;
  std::size_t free_curves_ = 0;
};

}  // namespace

// Why floors are harmless. Let L(t) = {sheet level >= t} with the curves, and P(X, s) what is left of a subcomplex X
// after the pruning for theta1 = s: as long as some vertex v that is no medial point is in one edge e of X only, e is a
// curve, no side of a face of X, and thickness(e) < s, the pair (v, e) goes. Such a pair of X is one of every
// subcomplex of X that has e: fewer cells are around v and e there. (*)
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
// So a page that holds the cells of K0 gives every member with theta2 >= t, theta1 >= s by the same rule.
std::size_t add_skeleton(Page& page, const SkeletonFamily& family, std::size_t max_triangles) {
  const RefinedAxis& k = family.refined;
  const CellComplex& c = k.complex;
  page::LayerCells cells;
  cells.levels.push_back({"sheet_level", comparable(family.vertex_sheet_level), comparable(family.edge_sheet_level),
                          comparable(family.face_sheet_level)});
  const page::Levels& levels = cells.levels.front();

  const page::FacesByLevel by_level(c, levels.face);
  page::Floor floor = by_level.within(max_triangles);
  std::vector<char> on_face;
  std::size_t free_curves = 0;
  const auto look_at_curves = [&] {
    on_face.assign(c.edges.size(), 0);
    for (const std::uint32_t f : floor.faces)
      for (const std::uint32_t e : c.sides(f)) on_face[e] = 1;
    free_curves = 0;
    for (std::size_t e = 0; e < c.edges.size(); ++e) free_curves += k.curve_edge[e] && !on_face[e];
  };
  look_at_curves();
  if (floor.triangles + free_curves > max_triangles) {
    floor = by_level.within(max_triangles / 5 * 4);
    look_at_curves();
  }
  for (const float level : levels.edge) cells.edge.push_back(level >= floor.level);
  for (const float level : levels.vertex) cells.vertex.push_back(level >= floor.level);

  float theta1_floor = 0;
  std::size_t curves_shown = free_curves;
  if (floor.triangles + free_curves > max_triangles) {
    const CurvePruning pruning(family, cells, on_face);
    theta1_floor = pruning.floor(max_triangles - std::min(max_triangles, floor.triangles));
    curves_shown = pruning.left(theta1_floor, &cells);
  }
  cells.faces = std::move(floor.faces);

  const std::vector<std::uint32_t> at = drawn_at(family);
  std::vector<Vec3> points(at.size());
  for (std::size_t v = 0; v < at.size(); ++v) points[v] = k.points[at[v]];
  const page::LayerRows rows = page::add_layer(page, "skeleton", c, points, cells);
  const auto add = [&](const char* name, PageArray::Values values) {
    page.arrays.push_back({std::string("skeleton/") + name, 1, std::move(values)});
  };
  std::vector<std::uint32_t> curve_edges, medial_points;
  std::vector<float> thickness;
  for (std::uint32_t e = 0; e < c.edges.size(); ++e)
    if (k.curve_edge[e] && rows.edge[e] != kNone) {
      curve_edges.push_back(rows.edge[e]);
      thickness.push_back(e < 2 * k.doors ? std::numeric_limits<float>::infinity()
                                          : page::rounded_down(family.thickness_of(e)));
    }
  for (std::uint32_t v = 0; v < c.vertex_count; ++v)
    if (k.medial_point[v] && rows.vertex[v] != kNone) medial_points.push_back(rows.vertex[v]);
  add("curve_edges", std::move(curve_edges));
  add("curve_thickness", std::move(thickness));
  add("medial_points", std::move(medial_points));

  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const auto measure = [&](const char* name, auto&& value) {
    page::add_measure(page, "skeleton", name, rows, [&](std::uint32_t v) { return value(at[v]); });
  };
  measure("radius", [&](std::uint32_t v) { return k.radius[v]; });
  measure("burn_time", [&](std::uint32_t v) { return k.burn_time[v]; });
  measure("erosion_thickness", [&](std::uint32_t v) { return std::max(0.0, k.burn_time[v] - k.radius[v]); });
  measure("curve_burn_time", [&](std::uint32_t v) { return k.curve_vertex[v] ? k.curve_burn_time[v] : kNothing; });
  measure("curve_erosion_thickness", [&](std::uint32_t v) {
    if (!k.curve_vertex[v]) return kNothing;
    return std::isinf(k.curve_burn_time[v]) ? kNever : std::max(0.0, k.curve_burn_time[v] - k.burn_time[v]);
  });

  page.theta2_floor = floor.level;
  page.theta1_floor = theta1_floor;
  if (floor.level > 0)
    page.notes.push_back(fmt::format(
        "The skeleton's sheets are shown from theta2 {} on, {} of their {} parts; what goes before is "
        "left out of this page (--max-triangles)",
        page::floor_text(page, floor.level), page::count_text(cells.faces.size()), page::count_text(c.face_count())));
  if (theta1_floor > 0)
    page.notes.push_back(fmt::format(
        "The skeleton's curves are shown from theta1 {} on, {} of {} pieces off the sheets; what goes "
        "before is left out of this page (--max-triangles)",
        page::floor_text(page, theta1_floor), page::count_text(curves_shown), page::count_text(free_curves)));
  const auto raise = [&](std::optional<double>& start, double least, const char* name) {
    if (!start || *start >= least) return;
    page.notes.push_back(fmt::format("{} starts at {} instead of {}", name, page::length_text(page, least),
                                     page::length_text(page, *start)));
    start = least;
  };
  raise(page.theta2, *page.theta2_floor, "theta2");
  raise(page.theta1, *page.theta1_floor, "theta1");
  return floor.triangles;
}

}  // namespace quench
