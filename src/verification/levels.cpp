// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "quench/measures.h"
#include "verification/checks.h"
#include "verification/polytope.h"

namespace quench::verification {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double rounding_of_keys = 1e-9;  // relative; values computed in two ways agree to some 1e-15

/// A measure and its levels of all cells, also of those that the file does not write.
struct Levels {
  std::string name;
  std::vector<double> vertex_value, edge_value, face_value, vertex_level, edge_level, face_level;
  double rounding = rounding_of_keys;  ///< relative, of values computed here against those of the file
};

// A vertex or edge that is no cell of the file has the largest level of the cells around it: that is why it is not
// written. The sentence about a written one with a lower level, else empty.
std::string spread(const Result& result, const std::vector<double>& level, Levels& all) {
  const CellComplex& complex = result.complex;
  const std::size_t line_row = result.data.verts.size(), face_row = line_row + result.data.lines.size();
  all.face_level.assign(level.begin() + static_cast<std::ptrdiff_t>(face_row), level.end());
  all.edge_level.assign(complex.edges.size(), 0);
  all.vertex_level.assign(complex.vertex_count, 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) all.edge_level[e] = std::max(all.edge_level[e], all.face_level[f]);
  for (std::size_t l = 0; l < result.line_edges.size(); ++l) {
    double& known = all.edge_level[result.line_edges[l]];
    if (!(level[line_row + l] >= known))
      return fmt::format("line {} has level {:.9g}, a polygon at it {:.9g}", l, level[line_row + l], known);
    known = level[line_row + l];
  }
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    for (const std::uint32_t v : complex.edges[e])
      all.vertex_level[v] = std::max(all.vertex_level[v], all.edge_level[e]);
  for (std::size_t i = 0; i < result.vert_vertices.size(); ++i) {
    double& known = all.vertex_level[result.vert_vertices[i]];
    if (!(level[i] >= known))
      return fmt::format("vertex cell {} has level {:.9g}, a line or polygon at it {:.9g}", i, level[i], known);
    known = level[i];
  }
  return {};
}

// Values of a measure from the arrays of the file. An edge that is not a line of the file has the largest value of its
// polygons. That is why it is not written, but for lambda: by the rule `coface` an edge has the largest lambda of its
// polygons in the unpruned core. Those that are not in the file went below the file's lambda, so their lambda is below
// it; so is that of a pair that could be taken for one of a larger key, and it is a counterexample either way.
void take_values(const Result& result, const std::vector<double>& point, const std::vector<double>& cell, Levels& all) {
  const std::size_t line_row = result.data.verts.size();
  all.face_value.assign(cell.begin() + static_cast<std::ptrdiff_t>(result.first_polygon()), cell.end());
  for (const std::uint32_t row : result.rows) all.vertex_value.push_back(point[row]);
  all.edge_value = result.largest_of_polygons(cell);
  for (std::size_t l = 0; l < result.line_edges.size(); ++l) all.edge_value[result.line_edges[l]] = cell[line_row + l];
  for (std::vector<double>* values : {&all.vertex_value, &all.edge_value, &all.face_value})
    for (double& value : *values)
      if (value >= kInfiniteLevelInFiles) value = never;
}

// Lambda by the rule `ball` of the edges that are not lines of the file, from their sites.
void take_edge_lambdas(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context,
                       Levels& all) {
  all.rounding += 2 * result.slack;
  vertex_sites.prepare(sample(result.rows.size(), result.rows.size()), context);
  const LambdaOfSites lambda(result.shape, sites, result.unit, true);
  std::vector<char> is_line(all.edge_value.size(), 0);
  for (const std::uint32_t e : result.line_edges) is_line[e] = 1;
  first_failure(all.edge_value.size(), context, "verify: levels", [&](std::size_t e) {
    if (is_line[e]) return true;
    const Ids set = edge_sites(result, vertex_sites, static_cast<std::uint32_t>(e));
    all.edge_value[e] = set.size() >= 3 ? lambda.edge(convex_cycle(sites, set)) : 0;
    return true;
  });
}

/// Takes cells away by ascending level and looks whether a thinning could have done so: whenever it comes to a level,
/// no simple pair of a smaller key may be left, and the cells of a level must go by simple pairs among themselves,
/// whose keys are not above the level. This is all that levels promise, whichever of equal keys went first. That the
/// order within a level does not matter: faces become removable and stay so; what is then left of the level is a graph
/// that either falls to its leaves or, in any order, does not.
class Replay {
 public:
  Replay(const Result& result, const Levels& levels)
      : result_(result),
        complex_(result.complex),
        levels_(levels),
        edge_faces_(complex_.edges.size()),
        vertex_edges_(complex_.vertex_count),
        face_gone_(complex_.face_count(), 0),
        edge_gone_(complex_.edges.size(), 0),
        vertex_gone_(complex_.vertex_count, 0) {
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
      for (const std::uint32_t e : complex_.sides(f)) edge_faces_[e].add(f);
    for (std::uint32_t e = 0; e < complex_.edges.size(); ++e)
      for (const std::uint32_t v : complex_.edges[e]) vertex_edges_[v].add(e);
  }

  /// The first thing that no thinning does, else empty.
  std::string run() {
    if (const std::string low = below_value(); !low.empty()) return low;
    for (std::uint32_t e = 0; e < complex_.edges.size(); ++e) offer_edge(e);
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) offer_vertex(v);
    std::vector<Cell> order;
    const auto list = [&](const std::vector<double>& level, int dimension) {
      for (std::uint32_t i = 0; i < level.size(); ++i)
        if (level[i] < never) order.push_back({level[i], dimension, i});
    };
    list(levels_.vertex_level, 0);
    list(levels_.edge_level, 1);
    list(levels_.face_level, 2);
    std::sort(order.begin(), order.end());
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
      const double level = order[begin].level;
      while (end < order.size() && order[end].level == level) ++end;
      if (const std::string left = overdue(level); !left.empty()) return left;
      for (std::size_t i = begin; i < end; ++i) waiting_.push_back(order[i]);
      take_all(level);
      for (std::size_t i = begin; i < end; ++i)
        if (!gone(order[i]))
          return fmt::format("{} of level {:.9g} cannot go at that level without changing the topology",
                             describe(order[i].dimension, order[i].index), level);
    }
    return overdue(never);
  }

 private:
  struct Cell {
    double level;
    int dimension;
    std::uint32_t index;
    auto operator<=>(const Cell&) const = default;
  };
  struct Pair {
    double key;
    bool edge_is_free;
    std::uint32_t free;
    bool operator<(const Pair& other) const { return key > other.key; }  // the smallest on top
  };

  std::string below_value() const {
    const auto first = [&](const std::vector<double>& value, const std::vector<double>& level, int dimension) {
      for (std::uint32_t i = 0; i < value.size(); ++i)
        if (!(level[i] >= value[i] * (1 - levels_.rounding)))
          return fmt::format("{} has level {:.9g}, below its own {} {:.9g}", describe(dimension, i), level[i],
                             levels_.name, value[i]);
      return std::string{};
    };
    std::string found = first(levels_.face_value, levels_.face_level, 2);
    if (found.empty()) found = first(levels_.edge_value, levels_.edge_level, 1);
    if (found.empty()) found = first(levels_.vertex_value, levels_.vertex_level, 0);
    return found;
  }

  bool simple(bool edge_is_free, std::uint32_t free) const {
    if (edge_is_free) return !edge_gone_[free] && edge_faces_[free].count == 1;
    return !vertex_gone_[free] && vertex_edges_[free].count == 1 && edge_faces_[vertex_edges_[free].only()].count == 0;
  }
  void offer_edge(std::uint32_t e) {
    if (simple(true, e))
      pairs_.push({std::max(levels_.edge_value[e], levels_.face_value[edge_faces_[e].only()]), true, e});
  }
  void offer_vertex(std::uint32_t v) {
    if (simple(false, v))
      pairs_.push({std::max(levels_.vertex_value[v], levels_.edge_value[vertex_edges_[v].only()]), false, v});
  }

  // The simple pair that should have gone below the level; empty when there is none.
  std::string overdue(double level) {
    while (!pairs_.empty() && !simple(pairs_.top().edge_is_free, pairs_.top().free)) pairs_.pop();
    if (pairs_.empty() || pairs_.top().key >= level * (1 - levels_.rounding)) return {};
    const Pair& pair = pairs_.top();
    const std::uint32_t other = pair.edge_is_free ? edge_faces_[pair.free].only() : vertex_edges_[pair.free].only();
    return fmt::format("{} could have gone with {} at {} {:.9g}, and is still there at level {:.9g}",
                       describe(pair.edge_is_free ? 2 : 1, other), describe(pair.edge_is_free ? 1 : 0, pair.free),
                       levels_.name, pair.key, level);
  }

  bool gone(const Cell& cell) const {
    return cell.dimension == 2   ? face_gone_[cell.index]
           : cell.dimension == 1 ? edge_gone_[cell.index]
                                 : vertex_gone_[cell.index];
  }

  void take_all(double level) {
    while (!waiting_.empty()) {
      const Cell cell = waiting_.back();
      waiting_.pop_back();
      if (cell.dimension == 1 && simple(true, cell.index)) {
        if (const std::uint32_t f = edge_faces_[cell.index].only(); levels_.face_level[f] == level)
          take_face(f, cell.index, level);
      } else if (cell.dimension == 0 && simple(false, cell.index)) {
        if (const std::uint32_t e = vertex_edges_[cell.index].only(); levels_.edge_level[e] == level)
          take_edge(e, cell.index, level);
      }
    }
  }
  void take_face(std::uint32_t f, std::uint32_t free, double level) {
    face_gone_[f] = 1;
    edge_gone_[free] = 1;
    for (const std::uint32_t e : complex_.sides(f)) {
      edge_faces_[e].remove(f);
      if (e == free) continue;
      offer_edge(e);
      wait(1, e, levels_.edge_level[e], level);
      if (edge_faces_[e].count == 0)
        for (const std::uint32_t v : complex_.edges[e]) lay_free(v, level);
    }
    for (const std::uint32_t v : complex_.edges[free]) leave(v, free, level);
  }
  void take_edge(std::uint32_t e, std::uint32_t free, double level) {
    edge_gone_[e] = 1;
    vertex_gone_[free] = 1;
    for (const std::uint32_t v : complex_.edges[e]) leave(v, e, level);
  }
  void leave(std::uint32_t v, std::uint32_t e, double level) {
    vertex_edges_[v].remove(e);
    lay_free(v, level);
  }
  void lay_free(std::uint32_t v, double level) {
    offer_vertex(v);
    wait(0, v, levels_.vertex_level[v], level);
  }
  void wait(int dimension, std::uint32_t index, double own, double level) {
    if (own == level) waiting_.push_back({level, dimension, index});
  }

  std::string describe(int dimension, std::uint32_t index) const {
    return dimension == 2   ? result_.describe_face(index)
           : dimension == 1 ? result_.describe_edge(index)
                            : result_.describe_vertex(index);
  }

  const Result& result_;
  const CellComplex& complex_;
  const Levels& levels_;
  std::vector<Cofaces> edge_faces_, vertex_edges_;
  std::vector<char> face_gone_, edge_gone_, vertex_gone_;
  std::priority_queue<Pair> pairs_;
  std::vector<Cell> waiting_;
};

Check check_levels_of(const std::string& measure, const Result& result, const Sites& sites, VertexSites& vertex_sites,
                      Context* context) {
  const bool is_lambda = measure == kLambda;
  const std::string name = is_lambda ? "nested levels" : fmt::format("nested levels of {}", measure);
  const std::string array = measure + "_level";
  std::vector<double> level = numbers_or_empty(result.data.cell_data, array);
  if (!find_array(result.data.cell_data, array)) return not_checked(name, fmt::format("no array '{}'", array));
  if (result.stage != "core")
    return not_checked(
        name, fmt::format("they are those of {} cores, which the file does not claim", pixel_or_voxel(result)));
  const std::vector<double> point = numbers_or_empty(result.data.point_data, measure),
                            cell = numbers_or_empty(result.data.cell_data, measure);
  if (point.empty() || cell.empty())
    return not_checked(name, fmt::format("they need the arrays '{}' of points and cells", measure));
  std::size_t never_go = 0;
  double lowest = never;
  const double at_least = is_lambda                                ? result.lambda
                          : measure == kDetail && result.by_detail ? result.detail
                          : measure == result.by                   ? result.by_threshold
                                                                   : 0;
  for (std::size_t c = 0; c < level.size(); ++c) {
    if (level[c] == kInfiniteLevelInFiles) {
      level[c] = never;
      ++never_go;
      continue;
    }
    if (!(level[c] >= at_least * (1 - rounding_of_keys)))
      return failed(name, fmt::format("cell {} has level {:.9g}, below {} {:.9g}", c, level[c], measure, at_least));
    if (level[c] > kInfiniteLevelInFiles)
      return failed(name, fmt::format("cell {} has level {:.9g}, which is neither a level nor {:.9g}, which stands for "
                                      "infinity",
                                      c, level[c], kInfiniteLevelInFiles));
    lowest = std::min(lowest, level[c]);
  }
  Levels all;
  all.name = measure;
  if (std::string wrong = spread(result, level, all); !wrong.empty()) return failed(name, std::move(wrong));
  take_values(result, point, cell, all);
  if (is_lambda && result.ball_rule) take_edge_lambdas(result, sites, vertex_sites, context, all);
  checkpoint(context, "verify: levels", 0.3);
  if (std::string wrong = Replay(result, all).run(); !wrong.empty()) return failed(name, std::move(wrong));
  Check check{name, true, {}, {}};
  cover(check, "cell " + array);
  check.detail = fmt::format("thinning by the keys of simple pairs gives those of all {} cells; ", level.size());
  check.detail += never_go == level.size() ? "all" : fmt::format("lowest {:.9g}, {}", lowest, never_go);
  check.detail += " never go";
  return check;
}

}  // namespace

std::vector<Check> check_levels(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context) {
  std::vector<Check> checks;
  for (const std::string& measure : result.measures)
    if ((measure == kLambda && !result.by_detail && result.by.empty()) ||
        find_array(result.data.cell_data, measure + "_level"))
      checks.push_back(check_levels_of(measure, result, sites, vertex_sites, context));
  if (checks.empty()) checks.push_back(not_checked("nested levels", "no measure with levels"));
  return checks;
}

Check check_measures(const Result& result) {
  const std::string name = "format and measures";
  const Record& data = result.data;
  if (result.stage.empty()) return not_checked(name, "no FieldData 'stage'");
  Check check{name, true, {}, {}};
  if (const auto version = numbers_or_empty(data.field_data, "format_version"); !version.empty()) {
    if (version[0] != static_cast<double>(kFormatVersion))
      return failed(name, fmt::format("the file says format version {:.9g}; files that say theirs are of version {}",
                                      version[0], kFormatVersion));
    cover(check, "field format_version");
    check.detail = fmt::format("format version {}", kFormatVersion);
  }
  if (!find_array(data.field_data, "measures")) return check;
  std::set<std::string> names;
  for (const std::string& measure : result.measures) {
    if (!names.insert(measure).second) return failed(name, fmt::format("the measure '{}' is there twice", measure));
    // That arrays of those that every file has, or the pruning needs, are missing is said by other checks.
    const MeasureKind* kind = find_measure_kind(measure);
    const bool is_expected = measure == result.pruned_by() || (kind && is_in_every_file(*kind, result.plane));
    if (!is_expected && !find_array(data.cell_data, measure) && !find_array(data.cell_data, measure + "_level"))
      return failed(name, fmt::format("there is no cell array of '{}', which is a measure of the file", measure));
  }
  for (const DataArray& array : data.cell_data)
    if (is_measure_of_cores(array.name) && !names.contains(array.name))
      return failed(name,
                    fmt::format("the measures of the file do not have '{}', of which there is an array", array.name));
  cover(check, "field measures");
  check.detail += fmt::format("{}{}", check.detail.empty() ? "" : "; ", fmt::join(result.measures, ", "));
  return check;
}

}  // namespace quench::verification
