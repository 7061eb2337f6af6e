// SPDX-License-Identifier: Apache-2.0
// The measure `detail` (docs/algorithms/pruning.md), from the cap heights of a file.
//
// Of the cells that are part of no larger one in the unpruned core ("top cells"), h is the cap height, lowered by a
// factor so that heights that equal a detail up to rounding are not above it, a the automatic detail, and v the detail.
// Before anything is raised for the balls to cover,
//   v0(c) = h(c) where h(c) < a, else the largest min(d, peak / sqrt(3)) over d from a to h(c), where peak is the
//   largest h in the component of { h >= d } that c is in;
// what is raised is raised to a exactly, but for vertices, which are raised further. Let w(c) be the same of the cells
// of the file alone, pruned at t. Then:
// - v >= v0 >= w: more cells make larger components.
// - If v differs from a, then v = v0 <= h. If besides v >= t, then v = w: let h(c) >= a, and d and P be where v0(c) is
//   attained, so v0(c) = min(d, P / sqrt(3)). The cells of that component of { h >= d } all have a v0 of at least this,
//   which is at least t, so all are in the file, and in the file their component has the same peak.
// In a result that is fitted to a surface, polygons with h >= a that the surface does not bear out count with a lower
// h, below a / 2. They are among those with v <= a. If v > a, so is the v0 of all cells of the component of d and P: so
// w is the same when the h of all polygons with v <= a is taken as low. Edges that are no top cells have the largest v
// of their polygons in the unpruned core, or a. Of a polygon that is not in the file v < t; so, where v >= t and v
// differs from a, v is the largest of the polygons in the file. Vertices have the largest v of their edges at least;
// what is more is from edges that are not in the file, and below t, or was raised, and is at least a.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/union_find.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kBelowTies = 1 - 2e-9;   // of cap heights
constexpr double kBorneOut = 0.5;         // of the automatic detail: h of polygons that the surface does not bear out
constexpr double kDetailRounding = 1e-9;  // relative; values computed in two ways agree to some 1e-15

struct TopCell {
  double height;
  std::uint32_t cell;  ///< polygons first, then edges, then vertices
};

/// w of the top cells of a file.
class DetailsOfHeights {
 public:
  DetailsOfHeights(const CellComplex& complex, std::vector<TopCell> cells, double least)
      : complex_(complex), sets_(complex.vertex_count), newest_(complex.vertex_count, kNone) {
    value.assign(complex.face_count() + complex.edges.size() + complex.vertex_count, -1);
    std::sort(cells.begin(), cells.end(), [](const TopCell& a, const TopCell& b) { return a.height > b.height; });
    const auto above = std::find_if(cells.begin(), cells.end(), [&](const TopCell& c) { return !(c.height >= least); });
    for (auto c = above; c != cells.end(); ++c) value[c->cell] = c->height;
    cells.erase(above, cells.end());
    // Each cell, from the highest down, joins the components it touches to one, whose peak is then this.
    peak_.resize(cells.size());
    joined_to_.assign(cells.size(), kNone);
    for (std::uint32_t i = 0; i < cells.size(); ++i) join(i, cells[i]);
    // A component is part of those it was joined to later: at their d, their peak counts.
    for (std::size_t i = cells.size(); i-- > 0;) {
      double& w = value[cells[i].cell];
      w = std::min(cells[i].height, peak_[i] / std::sqrt(3.0));
      if (joined_to_[i] != kNone) w = std::max(w, value[cells[joined_to_[i]].cell]);
    }
  }

  std::vector<double> value;  ///< per cell; -1 where it is no top cell

 private:
  void join(std::uint32_t i, const TopCell& cell) {
    peak_[i] = cell.height;
    std::uint32_t first = kNone;
    for_corners(cell.cell, [&](std::uint32_t v) {
      if (const std::uint32_t other = newest_[sets_.find(v)]; other != kNone && other != i) {
        joined_to_[other] = i;
        peak_[i] = std::max(peak_[i], peak_[other]);
      }
      if (first == kNone) first = v;
      sets_.unite(first, v);
      newest_[sets_.find(v)] = i;
    });
  }
  template <class Visit>
  void for_corners(std::uint32_t cell, const Visit& visit) const {
    const std::size_t faces = complex_.face_count(), edges = complex_.edges.size();
    if (cell < faces)
      for (const std::uint32_t v : complex_.corners(cell)) visit(v);
    else if (cell < faces + edges)
      for (const std::uint32_t v : complex_.edges[cell - faces]) visit(v);
    else
      visit(static_cast<std::uint32_t>(cell - faces - edges));
  }

  const CellComplex& complex_;
  base::UnionFind sets_;
  std::vector<std::uint32_t> newest_, joined_to_;  // per root the cell that made the component; per cell the next one
  std::vector<double> peak_;                       // per cell, of the component it made
};

class Details {
 public:
  Details(const Result& result, const Sites& sites, const VertexSites& vertex_sites)
      : result_(result),
        complex_(result.complex),
        sites_(sites),
        vertex_sites_(vertex_sites),
        of_(result.shape, sites, result.unit, result.ball_rule),
        cell_(numbers_or_empty(result.data.cell_data, kDetail)),
        height_(numbers_or_empty(result.data.cell_data, kCapHeight)),
        point_(numbers_or_empty(result.data.point_data, kDetail)),
        automatic_(result.auto_detail),
        threshold_(result.detail * (1 - 1e-12)) {}

  /// Sites of ends of edges without polygons and of isolated vertices must be prepared.
  std::string first_wrong() {
    if (std::string wrong = wrong_number(); !wrong.empty()) return wrong;
    const std::vector<TopCell> cells = top_cells();
    const DetailsOfHeights expected(complex_, cells, automatic_);
    spread_to_edges();
    std::vector<char> is_top(complex_.edges.size(), 0);
    for (const auto& [height, cell] : cells) {
      if (cell >= complex_.face_count() + complex_.edges.size()) continue;  // vertices may be raised
      const bool is_face = cell < complex_.face_count();
      if (!is_face) is_top[cell - complex_.face_count()] = 1;
      const double written = is_face ? cell_[result_.first_polygon() + cell] : of_edge_[cell - complex_.face_count()];
      if (std::string wrong = wrong_top(cell, written, height, expected.value[cell]); !wrong.empty()) return wrong;
    }
    for (std::size_t l = 0; l < result_.line_edges.size(); ++l)
      if (const std::uint32_t e = result_.line_edges[l]; !is_top[e])
        if (std::string wrong = wrong_line(l, e); !wrong.empty()) return wrong;
    for (std::uint32_t v = 0; v < result_.rows.size(); ++v)
      if (std::string wrong = wrong_vertex(v); !wrong.empty()) return wrong;
    return two_infinite();
  }

 private:
  bool is_automatic(double detail) const { return std::abs(detail - automatic_) <= kDetailRounding * automatic_; }

  std::string wrong_number() {
    for (double& x : point_)
      if (x >= kInfiniteLevelInFiles) x = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < cell_.size(); ++c)
      if (!(cell_[c] >= 0 && height_[c] >= 0))
        return fmt::format("cell {} has detail {:.9g} and cap height {:.9g}", c, cell_[c], height_[c]);
    for (std::size_t i = 0; i < result_.vert_vertices.size(); ++i) {
      const std::uint32_t v = result_.vert_vertices[i];
      if (std::min(point_[result_.rows[v]], kInfiniteLevelInFiles) != cell_[i])
        return fmt::format("the vertex cell of {} has detail {:.9g}, the point {:.9g}", result_.describe_vertex(v),
                           cell_[i], point_[result_.rows[v]]);
    }
    return {};
  }

  // With heights below ties.
  std::vector<TopCell> top_cells() const {
    std::vector<TopCell> cells;
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
      cells.push_back({lowered(height_[result_.first_polygon() + f], cell_[result_.first_polygon() + f]), f});
    const auto edge = static_cast<std::uint32_t>(complex_.face_count());
    for (std::size_t l = 0; l < result_.line_edges.size(); ++l)
      if (const std::uint32_t e = result_.line_edges[l]; result_.edge_faces_count[e] == 0 && has_no_core_face(e))
        cells.push_back({height_[result_.vert_vertices.size() + l], edge + e});
    const auto vertex = static_cast<std::uint32_t>(edge + complex_.edges.size());
    for (std::size_t i = 0; i < result_.vert_vertices.size(); ++i)
      if (const std::uint32_t v = result_.vert_vertices[i]; result_.vertex_edges[v].empty() && has_no_core_edge(v))
        cells.push_back({height_[i], vertex + v});
    for (TopCell& cell : cells) cell.height *= kBelowTies;
    return cells;
  }
  double lowered(double height, double written) const {
    if (!result_.fitted || written > automatic_ * (1 + kDetailRounding) || height * kBelowTies < automatic_)
      return height;
    return is_automatic(written) || written < kBorneOut * automatic_ ? std::min(written / kBelowTies, 0.99 * automatic_)
                                                                     : height;
  }
  bool has_no_core_face(std::uint32_t e) const {
    if (result_.plane) return true;
    const Ids set = edge_sites(result_, vertex_sites_, e);
    return set.size() >= 3 && of_.has_only_boundary_edges(convex_cycle(sites_, set));
  }
  bool has_no_core_edge(std::uint32_t v) const {
    if (result_.plane) {
      const Ids& set = vertex_sites_.at(v);
      return set.size() >= 3 && of_.has_only_boundary_edges(convex_cycle(sites_, set));
    }
    const std::vector<Ids> facets = hull_facets(sites_, vertex_sites_.at(v));
    return std::all_of(facets.begin(), facets.end(), [&](const Ids& facet) { return of_.is_boundary_square(facet); });
  }
  void spread_to_edges() {
    of_edge_ = of_faces_ = result_.largest_of_polygons(cell_);
    for (std::size_t l = 0; l < result_.line_edges.size(); ++l)
      of_edge_[result_.line_edges[l]] = cell_[result_.vert_vertices.size() + l];
  }

  std::string wrong_top(std::uint32_t cell, double written, double height, double expected) const {
    const char* relation = nullptr;
    const double rounding = kDetailRounding * std::max(expected, written);
    if (!(written >= expected - rounding))
      relation = "at least";
    else if (is_automatic(written))
      return {};
    else if (written >= threshold_ && !(written <= expected + rounding))
      relation = "exactly";
    else if (!(written <= height + rounding))
      relation = "at most its cap height, and no less than";
    if (!relation) return {};
    const std::size_t faces = complex_.face_count();
    return fmt::format(
        "{} has detail {:.9g}; the cap heights of the file give {} {:.9g}",
        cell < faces ? result_.describe_face(cell) : result_.describe_edge(static_cast<std::uint32_t>(cell - faces)),
        written, relation, expected);
  }
  std::string wrong_line(std::size_t l, std::uint32_t e) const {
    const double written = cell_[result_.vert_vertices.size() + l], rounding = kDetailRounding * written;
    if (written >= of_faces_[e] - rounding &&
        (is_automatic(written) || written < threshold_ || written <= of_faces_[e] + rounding))
      return {};
    return fmt::format("{} has detail {:.9g}, the largest of its polygons {:.9g}", result_.describe_edge(e), written,
                       of_faces_[e]);
  }
  std::string wrong_vertex(std::uint32_t v) const {
    double largest = 0;
    for (const std::uint32_t e : result_.vertex_edges[v]) largest = std::max(largest, of_edge_[e]);
    const double written = point_[result_.rows[v]];
    const double rounding = kDetailRounding * largest;
    const bool may_differ =
        result_.vertex_edges[v].empty() || is_automatic(written) || written > automatic_ || written < threshold_;
    if (written >= largest - rounding && (may_differ || written <= largest + rounding)) return {};
    return fmt::format("{} has detail {:.9g}, the largest of its edges {:.9g}", result_.describe_vertex(v), written,
                       largest);
  }
  std::string two_infinite() const {
    const std::vector<std::uint32_t> component = components(complex_);
    std::vector<std::uint32_t> first(complex_.vertex_count, kNone);
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      if (point_[result_.rows[v]] != std::numeric_limits<double>::infinity()) continue;
      if (std::uint32_t& other = first[component[v]]; other == kNone)
        other = v;
      else
        return fmt::format("{} and {} have an infinite detail, and are connected", result_.describe_vertex(other),
                           result_.describe_vertex(v));
    }
    return {};
  }

  const Result& result_;
  const CellComplex& complex_;
  const Sites& sites_;
  const VertexSites& vertex_sites_;
  LambdaOfSites of_;
  std::vector<double> cell_, height_, point_;
  double automatic_, threshold_;
  std::vector<double> of_edge_, of_faces_;  // per edge: as the file says, the largest of its polygons
};

}  // namespace

Check check_details(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context) {
  const std::string name = "details";
  for (const auto& [arrays, array] : {std::pair{&result.data.point_data, kDetail},
                                      {&result.data.cell_data, kDetail},
                                      {&result.data.cell_data, kCapHeight}})
    if (numbers_or_empty(*arrays, array).empty())
      return not_checked(name, "they need the arrays 'detail' of points and cells, and 'cap_height' of cells");
  std::vector<std::uint32_t> needed;
  for (const std::uint32_t e : result.line_edges)
    if (result.edge_faces_count[e] == 0)
      needed.insert(needed.end(), result.complex.edges[e].begin(), result.complex.edges[e].end());
  for (const std::uint32_t v : result.vert_vertices)
    if (result.vertex_edges[v].empty()) needed.push_back(v);
  vertex_sites.prepare(needed, context);
  if (std::string wrong = Details(result, sites, vertex_sites).first_wrong(); !wrong.empty())
    return failed(name, std::move(wrong));
  return {name, true, "as the cap heights of the file give them, or raised for the balls to cover", {}};
}

}  // namespace quench::verification
