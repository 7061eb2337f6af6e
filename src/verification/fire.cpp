// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"
#include "verification/point_measure.h"

/// What can be checked of burn times without burning again: relations among the arrays, and bounds.
namespace quench::verification {

namespace {

std::vector<char> pocket_vertices(const CellComplex& complex) {
  const std::vector<char> there = pocket_faces(complex);
  std::vector<char> pocket(complex.vertex_count, 0);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    if (there[f])
      for (const std::uint32_t v : complex.corners(f)) pocket[v] = 1;
  return pocket;
}

/// How the polygons lie around a vertex.
enum class Star { no_polygons, disk, half_disk, other };

Star star_of(const Result& result, std::uint32_t v) {
  const CellComplex& complex = result.complex;
  const auto faces = result.vertex_faces[v];
  if (faces.empty()) return Star::no_polygons;
  std::vector<std::array<std::uint32_t, 2>> sides;  // edge at v, polygon at it
  for (const std::uint32_t f : faces)
    for (const std::uint32_t e : complex.sides(f))
      if (complex.edges[e][0] == v || complex.edges[e][1] == v) sides.push_back({e, f});
  std::sort(sides.begin(), sides.end());
  std::size_t free_edges = 0;
  for (const auto& [e, f] : sides) {
    if (result.edge_faces_count[e] > 2) return Star::other;
    free_edges += result.edge_faces_count[e] == 1;
  }
  // All polygons that are reached from the first one across edges at v.
  std::vector<std::uint32_t> reached{faces[0]};
  for (std::size_t r = 0; r < reached.size(); ++r)
    for (std::size_t i = 1; i < sides.size(); ++i) {
      if (sides[i][0] != sides[i - 1][0]) continue;
      for (const auto& [from, to] : {std::pair{sides[i - 1][1], sides[i][1]}, std::pair{sides[i][1], sides[i - 1][1]}})
        if (from == reached[r] && std::find(reached.begin(), reached.end(), to) == reached.end()) reached.push_back(to);
    }
  if (reached.size() != faces.size()) return Star::other;
  return free_edges > 0 ? Star::half_disk : Star::disk;
}

// Where the star of a vertex is a disk, fire that has burned a neighbour comes along the edge between them; at the rim
// of a sheet it starts.
std::string wrong_time(const Result& result, const PointMeasure& time, std::size_t& bounded_vertices) {
  const CellComplex& complex = result.complex;
  const std::vector<double> omega = numbers_or_empty(result.data.field_data, "omega");
  const double late = 4 * result.rounding * result.unit + (omega.size() == 1 ? kOffByLabels * omega[0] : 0);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v) {
    if (time.infinite[v] != 0) continue;
    const double r = result.ball_radius[v];
    if (!(time.value[v] >= r * (1 - kSingle)))
      return fmt::format("{} burns at {:.9g}, before its radius {:.9g}", result.describe_vertex(v), time.value[v], r);
    const Star star = star_of(result, v);
    if (star == Star::other) continue;
    ++bounded_vertices;
    double latest = r * (1 + kSingle);
    if (star == Star::disk) {
      latest = std::numeric_limits<double>::infinity();
      for (const std::uint32_t e : result.vertex_edges[v]) {
        const std::uint32_t other = complex.edges[e][0] == v ? complex.edges[e][1] : complex.edges[e][0];
        if (result.edge_faces_count[e] == 0 || time.infinite[other] != 0) continue;
        const double length = (result.point(v) - result.point(other)).norm();
        latest = std::min(latest, time.value[other] * (1 + kSingle) + length * (1 + kOffAlongEdges) + late);
      }
    }
    if (!(time.value[v] <= latest))
      return fmt::format("{} burns at {:.9g}, but fire from the edges and points around it is there by {:.9g}",
                         result.describe_vertex(v), time.value[v], latest);
  }
  return {};
}

// Nodes of the network that a spacing gives, least and most: edges of polygons in equal parts, no longer than the
// spacing to 1e-12, two at least at seams.
std::array<double, 2> nodes_of(const Result& result, double omega) {
  const CellComplex& complex = result.complex;
  std::vector<char> at_seam(complex.vertex_count, 0);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (result.edge_faces_count[e] > 2)
      for (const std::uint32_t v : complex.edges[e]) at_seam[v] = 1;
  std::array<double, 2> nodes{static_cast<double>(complex.vertex_count), static_cast<double>(complex.vertex_count)};
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e) {
    const auto& [a, b] = complex.edges[e];
    const double length = (result.point(a) - result.point(b)).norm();
    if (result.edge_faces_count[e] == 0 || !(length > 0)) continue;
    const double least = at_seam[a] || at_seam[b] ? 2 : 1;
    nodes[0] += std::max(least, std::ceil(length / omega * (1 - 1.5e-12))) - 1;
    nodes[1] += std::max(least, std::ceil(length / omega * (1 - 0.5e-12))) - 1;
  }
  return nodes;
}

std::string wrong_network(const Result& result, const PointMeasure& time, Check& check) {
  const std::vector<double> omega = numbers_or_empty(result.data.field_data, "omega"),
                            nodes = numbers_or_empty(result.data.field_data, "burn_nodes"),
                            most = numbers_or_empty(result.data.field_data, "max_burn_time");
  if (omega.size() == 1 && nodes.size() == 1) {
    if (!(omega[0] > 0)) return fmt::format("omega {:.9g} is not a distance", omega[0]);
    const auto [least, largest] = nodes_of(result, omega[0]);
    if (!(nodes[0] >= least && nodes[0] <= largest))
      return fmt::format("burn_nodes is {:.12g}; edges cut by omega {:.9g} have {:.12g}", nodes[0], omega[0], least);
    cover(check, "field burn_nodes");
  }
  if (most.size() == 1) {
    if (!(std::abs(most[0] - time.largest) <= kSingle * time.largest))
      return fmt::format("max_burn_time is {:.9g}, the largest is {:.9g}", most[0], time.largest);
    cover(check, "field max_burn_time");
  }
  return {};
}

std::string wrong_curves(const Result& result, const PointMeasure& time, Check& check) {
  const PointMeasure thickness(result, "curve_erosion_thickness", "curve_unburned");
  PointMeasure curve(result, "curve_burn_time", "curve_unburned");
  if (!thickness.known() || !curve.known()) return {};
  // Off the curves of a pocket the time of the sheet stands in the array, which is infinite there, and thickness is 0.
  for (std::size_t v = 0; v < curve.value.size(); ++v) {
    if (curve.infinite[v] != 0 && curve.infinite[v] != 1)
      return fmt::format("{} has the flag {:.9g} in 'curve_unburned'",
                         result.describe_vertex(static_cast<std::uint32_t>(v)), curve.infinite[v]);
    curve.largest = std::max(curve.largest, curve.infinite[v] != 0 ? 0 : curve.value[v]);
  }
  std::vector<double> from = time.value;
  for (std::size_t v = 0; v < from.size(); ++v)
    if (time.infinite[v] != 0 && curve.infinite[v] == 0) {
      if (thickness.value[v] != 0)
        return fmt::format("{} is on a pocket, which does not burn, and has a curve_erosion_thickness of {:.9g}",
                           result.describe_vertex(static_cast<std::uint32_t>(v)), thickness.value[v]);
      from[v] = curve.value[v];
    }
  std::string wrong = wrong_thickness(result, "curve_erosion_thickness", thickness, curve, from);
  if (wrong.empty()) cover(check, "point curve_erosion_thickness");
  return wrong;
}

}  // namespace

std::vector<char> pocket_faces(const CellComplex& complex) {
  std::vector<Cofaces> faces(complex.edges.size());
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) faces[e].add(f);
  std::vector<char> there(complex.face_count(), 1);
  std::vector<std::uint32_t> open;
  for (std::uint32_t e = 0; e < faces.size(); ++e)
    if (faces[e].count == 1) open.push_back(e);
  while (!open.empty()) {
    const std::uint32_t e = open.back();
    open.pop_back();
    if (faces[e].count != 1) continue;
    const std::uint32_t f = faces[e].only();
    there[f] = 0;
    for (const std::uint32_t side : complex.sides(f)) {
      faces[side].remove(f);
      if (faces[side].count == 1) open.push_back(side);
    }
  }
  return there;
}

Check check_burning(const Result& result) {
  const std::string name = "burning";
  const PointMeasure time(result, "burn_time", "unburned"), thickness(result, "erosion_thickness", "unburned");
  if (!time.known() || !thickness.known() || result.ball_radius.empty())
    return not_checked(name, "no arrays 'burn_time', 'erosion_thickness' and 'unburned'");
  Check check{name, true, {}, {}};
  const std::vector<char> pocket = pocket_vertices(result.complex);
  std::size_t pockets = 0;
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    if (time.infinite[v] != pocket[v])
      return failed(name, fmt::format("{} has {:.9g} in 'unburned', and it is {} a closed pocket",
                                      result.describe_vertex(v), time.infinite[v], pocket[v] ? "on" : "not on"));
    pockets += pocket[v] != 0;
  }
  cover(check, "point unburned");
  cover(check, "point erosion_thickness");
  std::string wrong = wrong_thickness(result, "erosion_thickness", thickness, time, result.ball_radius);
  std::size_t bounded_vertices = 0;
  if (wrong.empty() && result.stage == "skeleton")
    wrong = wrong_curves(result, time, check);
  else if (wrong.empty() && result.stage == "core")  // radii of other programs need not be distances
    wrong = wrong_time(result, time, bounded_vertices);
  if (wrong.empty() && result.stage != "skeleton") wrong = wrong_network(result, time, check);
  if (!wrong.empty()) return failed(name, std::move(wrong));
  check.detail = fmt::format("erosion thickness is burn time less radius at {} points, {} on closed pockets",
                             result.rows.size(), pockets);
  if (result.stage == "core")
    check.detail += fmt::format("; {} burn when fire from around them must be there at the latest", bounded_vertices);
  return check;
}

Check check_skeleton_levels(const Result& result) {
  const std::string name = "skeleton levels";
  if (result.stage != "skeleton") return not_checked(name, "the file does not say that it is a skeleton");
  const auto& cells = result.data.cell_data;
  const std::vector<double> theta2 = numbers_or_empty(result.data.field_data, "theta2"),
                            theta1 = numbers_or_empty(result.data.field_data, "theta1"),
                            sheet = numbers_or_empty(cells, "sheet_level"),
                            curve = numbers_or_empty(cells, "curve_level"),
                            thickness = numbers_or_empty(cells, "erosion_thickness"),
                            curve_thickness = numbers_or_empty(cells, "curve_erosion_thickness");
  const std::size_t rows = result.data.cell_count();
  if (theta2.size() != 1 || theta1.size() != 1)
    return failed(name, "the stage is 'skeleton', but there are no field arrays 'theta2' and 'theta1'");
  for (const double theta : {theta2[0], theta1[0]})
    if (!(theta >= 0 && theta <= kInfiniteLevelInFiles))
      return failed(name,
                    fmt::format("theta2 {:.9g} and theta1 {:.9g} are not negative, and 3.4e38 stands for infinity",
                                theta2[0], theta1[0]));
  for (const auto* array : {&sheet, &curve, &thickness, &curve_thickness})
    if (array->size() != rows) return not_checked(name, "cell arrays of levels or thickness are missing");
  const double most = rows == 0 ? 0 : *std::max_element(curve_thickness.begin(), curve_thickness.end());
  const std::size_t line_row = result.vert_vertices.size(), face_row = line_row + result.line_edges.size();
  const auto wrong = [&](std::size_t row, const char* what) {
    return failed(name, fmt::format("cell {}: sheet_level {:.9g}, curve_level {:.9g}, erosion_thickness {:.9g}, "
                                    "curve_erosion_thickness {:.9g}: {}",
                                    row, sheet[row], curve[row], thickness[row], curve_thickness[row], what));
  };
  constexpr double kInfinite = kInfiniteLevelInFiles;
  // Sheets may have grown back below theta2; how far is not known without the field.
  const std::vector<double> rims = numbers_or_empty(result.data.field_data, "rims_above");
  const bool full = text_or_empty(result.data.field_data, "tips") == "full";
  const double least_level = rims.size() == 1 ? std::min(theta2[0], rims[0]) : full ? 0 : theta2[0];
  const std::string below = fmt::format("its sheet_level is below {:.9g}", least_level);
  for (std::size_t row = 0; row < rows; ++row) {
    if (!(thickness[row] >= 0 && curve_thickness[row] >= 0 && sheet[row] >= 0 && curve[row] >= 0 &&
          sheet[row] <= kInfinite && curve[row] <= kInfinite))
      return wrong(row, "they are not negative, and 3.4e38 stands for infinity");
    if (row >= face_row) {
      if (curve[row] != kInfinite || curve_thickness[row] != 0) return wrong(row, "polygons have none of curves");
      if (!(sheet[row] >= least_level * (1 - 1e-9))) return wrong(row, below.c_str());
      continue;
    }
    if (sheet[row] != kInfinite || thickness[row] != 0) return wrong(row, "only polygons have those of sheets");
    if (row < line_row) {
      if (curve[row] != kInfinite || curve_thickness[row] != 0) return wrong(row, "points have none of curves");
      continue;
    }
    // What never burns has the largest finite value.
    if (curve_thickness[row] < most && !(curve[row] >= curve_thickness[row] * (1 - 1e-9)))
      return wrong(row, "a curve stays at least as long as its thickness");
  }
  if (std::string free = wrong_free_branch(result, theta1[0], curve_thickness); !free.empty())
    return failed(name, std::move(free));
  Check check{name, true, {}, {}};
  check.detail =
      fmt::format("no polygon below {} {:.9g}, no free curve below theta1 {:.9g}",
                  least_level < theta2[0] ? "the level from which rims grew back," : "theta2", least_level, theta1[0]);
  return check;
}

}  // namespace quench::verification
