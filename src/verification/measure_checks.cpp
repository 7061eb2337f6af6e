// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "quench/measures.h"
#include "verification/checks.h"
#include "verification/surface_ways.h"

namespace quench::verification {
namespace {

constexpr double kRelative = 1e-9;  // of values computed in two ways

/// The arrays of a measure.
struct Arrays {
  Arrays(const Result& of, std::string_view measure)
      : result(of),
        name(measure),
        point(numbers_or_empty(of.data.point_data, measure)),
        cell(numbers_or_empty(of.data.cell_data, measure)) {
    for (std::vector<double>* values : {&point, &cell})
      for (double& value : *values)
        if (value >= kInfiniteLevelInFiles) value = kUnbounded;
  }
  bool is_there() const { return !point.empty() || !cell.empty(); }
  bool is_whole() const { return !point.empty() && !cell.empty(); }
  Check lacks() const { return not_checked(check_name(), fmt::format("it needs '{}' of points and cells", name)); }
  std::string check_name() const {
    std::string words = name;
    std::ranges::replace(words, '_', ' ');
    return words;
  }

  std::size_t cells() const { return cell.size(); }
  /// The corners of a cell of the file.
  std::span<const std::uint32_t> corners(std::size_t row) const {
    const std::size_t verts = result.vert_vertices.size(), lines = result.line_edges.size();
    if (row < verts) return {&result.vert_vertices[row], 1};
    if (row < verts + lines) return result.complex.edges[result.line_edges[row - verts]];
    return result.complex.corners(row - verts - lines);
  }
  /// Whether it is not part of a larger cell of the file.
  bool is_top(std::size_t row) const {
    const std::size_t verts = result.vert_vertices.size(), lines = result.line_edges.size();
    if (row < verts) return result.vertex_edges[result.vert_vertices[row]].empty();
    return row >= verts + lines || result.edge_faces_count[result.line_edges[row - verts]] == 0;
  }
  std::string describe(std::size_t row) const {
    const std::size_t verts = result.vert_vertices.size(), lines = result.line_edges.size();
    if (row < verts) return result.describe_vertex(result.vert_vertices[row]);
    if (row < verts + lines) return result.describe_edge(result.line_edges[row - verts]);
    return result.describe_face(row - verts - lines);
  }

  const Result& result;
  std::string name;
  std::vector<double> point, cell;
};

/// Of what no formula is known here: that values are in a range, and those of sides not below those of cells.
std::string wrong_range(const Arrays& arrays, double least, double most, Context* context) {
  for (std::size_t row = 0; row < arrays.cells(); ++row)
    if (!(arrays.cell[row] >= least && arrays.cell[row] <= most))
      return fmt::format("{} has a {} of {:.9g}", arrays.describe(row), arrays.check_name(), arrays.cell[row]);
  return below_cells_around(arrays.result, arrays.check_name(), arrays.point, arrays.cell, kRelative, context);
}

Check passed(const Arrays& arrays, std::string detail) {
  Check check{arrays.check_name(), true, std::move(detail), {}};
  cover(check, "cell " + arrays.name);
  cover(check, "point " + arrays.name);
  return check;
}

Check check_circumradius(const Result& result, Context* context) {
  const Arrays arrays(result, kCircumradius);
  if (!arrays.is_whole() || result.radius.empty()) return arrays.lacks();
  if (std::string wrong = wrong_range(arrays, 0, kUnbounded, context); !wrong.empty())
    return failed(arrays.check_name(), std::move(wrong));
  const auto expected = [&](std::size_t row) {
    double least = kUnbounded;
    for (const std::uint32_t v : arrays.corners(row)) least = std::min(least, result.radius[v]);
    return least;
  };
  // A curve of a pruning may have been the rim of a sheet that had more.
  const bool whole_core = result.by == kCircumradius;
  const std::size_t bad = first_failure(arrays.cells(), context, "verify: measures", [&](std::size_t row) {
    const bool is_face = row >= result.first_polygon();
    if (!arrays.is_top(row) || (!is_face && whole_core)) return true;
    return std::abs(arrays.cell[row] - expected(row)) <= kRelative * expected(row);
  });
  if (bad < arrays.cells())
    return failed(arrays.check_name(),
                  fmt::format("{} has a circumradius of {:.9g}; the smallest of its balls has {:.9g}",
                              arrays.describe(bad), arrays.cell[bad], expected(bad)));
  return passed(arrays, fmt::format("that of {} cells is the smallest of their balls", arrays.cells()));
}

/// The factors between which that of a vertex lies, by all others.
std::array<double, 2> scales_of(const Result& result, std::uint32_t v) {
  constexpr double kEqualRadii = 1e-9;  // that are taken for the same may differ by so much
  std::array<double, 2> between{kUnbounded, kUnbounded};
  const double r = result.radius[v];
  const double off = 2 * kEqualRadii * r + 8 * result.rounding * result.unit;
  for (std::uint32_t w = 0; w < result.radius.size(); ++w) {
    const double more = result.radius[w] - r;
    if (!(more > -off)) continue;
    const double apart = (result.voxel_point(v) - result.voxel_point(w)).norm();
    if (v == w || !(apart > 0)) continue;
    if (more + off > 0) between[0] = std::min(between[0], std::max(1.0, apart / (more + off)));
    if (more - off > 0) between[1] = std::min(between[1], std::max(1.0, apart / (more - off)));
  }
  return between;
}

Check check_scale_axis(const Result& result, std::size_t samples, Context* context) {
  const Arrays arrays(result, kScaleAxis);
  if (!arrays.is_whole() || result.radius.empty()) return arrays.lacks();
  if (!result.has_voxel_geometry) return not_checked(arrays.check_name(), kNotOfVoxels);
  if (std::string wrong = wrong_range(arrays, 1, kUnbounded, context); !wrong.empty())
    return failed(arrays.check_name(), std::move(wrong));
  constexpr std::size_t kMostSamples = 64;  // each looks at all balls
  // Balls that a pruning by it has dropped may have swallowed some earlier; curves may have been rims of sheets.
  const bool of_whole_core = result.by == kScaleAxis;
  const std::vector<std::uint32_t> rows = sample(arrays.cells(), std::min(samples, kMostSamples));
  std::vector<std::array<double, 2>> between(rows.size(), {0, kUnbounded});
  const std::size_t bad = first_failure(rows.size(), context, "verify: measures", [&](std::size_t i) {
    if (!arrays.is_top(rows[i]) || (of_whole_core && rows[i] < result.first_polygon())) return true;
    between[i] = {kUnbounded, kUnbounded};
    for (const std::uint32_t v : arrays.corners(rows[i]))
      for (const std::size_t k : {0, 1}) between[i][k] = std::min(between[i][k], scales_of(result, v)[k]);
    const double written = arrays.cell[rows[i]];
    return written <= between[i][1] * (1 + kRelative) && (of_whole_core || written >= between[i][0] * (1 - kRelative));
  });
  if (bad < rows.size())
    return failed(arrays.check_name(),
                  fmt::format("{} has a scale axis of {:.9g}; by all balls it is between {:.9g} and {:.9g}",
                              arrays.describe(rows[bad]), arrays.cell[rows[bad]], between[bad][0], between[bad][1]));
  return passed(arrays, fmt::format("{} of {} cells as all balls of the file give {}", rows.size(), arrays.cells(),
                                    of_whole_core ? "a bound of it" : "it"));
}

Check check_chord_residual(const Result& result, const Sites& sites, std::size_t samples, Context* context) {
  const Arrays arrays(result, kChordResidual), mgf(result, kMgf);
  const auto& sites_of = result.plane ? result.line_sites : result.face_sites;
  const std::size_t first = result.plane ? result.vert_vertices.size() : result.first_polygon();
  if (!arrays.is_whole() || sites_of.size() + first != arrays.cells()) return arrays.lacks();
  if (std::string wrong = wrong_range(arrays, 0, kUnbounded, context); !wrong.empty())
    return failed(arrays.check_name(), std::move(wrong));
  const auto chord = [&](std::size_t i) {
    const auto& [a, b] = sites_of[i];
    return result.shape.grid().spacing.cwiseProduct(Vec3(a[0] - b[0], a[1] - b[1], a[2] - b[2])).norm();
  };
  const double rounding = 4 * kRelative + result.slack;
  const auto sentence = [&](std::size_t i, double way) {
    return fmt::format("{} has a chord residual of {:.9g}; the way is {:.9g}, the chord {:.9g}",
                       arrays.describe(first + i), arrays.cell[first + i], way, chord(i));
  };
  if (!mgf.cell.empty()) {
    const std::size_t bad = first_failure(sites_of.size(), context, "verify: measures", [&](std::size_t i) {
      const double way = mgf.cell[first + i], written = arrays.cell[first + i];
      return way == kUnbounded ? written == kUnbounded : std::abs(written + chord(i) - way) <= rounding * way;
    });
    if (bad < sites_of.size()) return failed(arrays.check_name(), sentence(bad, mgf.cell[first + bad]));
    return passed(arrays, fmt::format("of {} cells it is mgf without the chord", sites_of.size()));
  }
  constexpr std::size_t kMostSamples = 32;  // a way may lead over all of the surface
  const std::vector<std::uint32_t> rows = sample(sites_of.size(), std::min(samples, kMostSamples));
  const SurfaceWays ways(result.shape, sites);
  std::vector<double> way(rows.size());
  const std::size_t bad = first_failure(rows.size(), context, "verify: measures", [&](std::size_t i) {
    way[i] = ways.shortest(sites_of[rows[i]][0], sites_of[rows[i]][1]);
    const double written = arrays.cell[first + rows[i]] + chord(rows[i]);
    if (way[i] == kUnbounded) return written == kUnbounded;
    return written <= way[i] * (1 + rounding) && written >= way[i] / ways.most() * (1 - rounding);
  });
  if (bad < rows.size()) return failed(arrays.check_name(), sentence(rows[bad], way[bad]));
  return passed(arrays,
                fmt::format("with the chord, that of {} of {} polygons lies between the shortest way along sides "
                            "and diagonals and {:.3f} of it",
                            rows.size(), sites_of.size(), 1 / ways.most()));
}

/// Per vertex, edge and face of a whole core: what follows from the erosion thickness of its vertices, as faces have
/// the least of their corners, and sides the largest around.
struct FromErosion {
  FromErosion(const Arrays& arrays, const std::vector<double>& erosion) {
    const Result& result = arrays.result;
    const CellComplex& complex = result.complex;
    const bool share = arrays.name == kRelativeErosionThickness;
    std::vector<double> own(complex.vertex_count);
    for (std::uint32_t v = 0; v < own.size(); ++v) {
      const double e = erosion[result.rows[v]];
      own[v] = !share ? e : std::isinf(e) ? 1 : e / (e + result.radius[v]);
    }
    edge.assign(complex.edges.size(), -1);
    for (std::size_t f = 0; f < complex.face_count(); ++f) {
      double least = kUnbounded;
      for (const std::uint32_t v : complex.corners(f)) least = std::min(least, own[v]);
      face.push_back(least);
      for (const std::uint32_t e : complex.sides(f)) edge[e] = std::max(edge[e], least);
    }
    vertex.assign(own.size(), -1);
    for (std::size_t e = 0; e < edge.size(); ++e) {
      const auto [a, b] = complex.edges[e];
      if (edge[e] < 0) edge[e] = std::min(own[a], own[b]);
      for (const std::uint32_t v : {a, b}) vertex[v] = std::max(vertex[v], edge[e]);
    }
    for (std::size_t v = 0; v < own.size(); ++v)
      if (vertex[v] < 0) vertex[v] = own[v];
  }
  std::vector<double> vertex, edge, face;
};

std::string not_as_burned(const Arrays& arrays, const std::vector<double>& erosion) {
  const Result& result = arrays.result;
  const FromErosion again(arrays, erosion);
  const auto differs = [](double a, double b) { return a != b && !(std::abs(a - b) <= kRelative * b); };
  const auto sentence = [&](const std::string& cell, double written, double burned) {
    return fmt::format("{} has a {} of {:.9g}; burned again it is {:.9g}", cell, arrays.check_name(), written, burned);
  };
  const std::size_t verts = result.vert_vertices.size(), polygons = result.first_polygon();
  for (std::size_t row = 0; row < arrays.cells(); ++row) {
    const double burned = row < verts      ? again.vertex[result.vert_vertices[row]]
                          : row < polygons ? again.edge[result.line_edges[row - verts]]
                                           : again.face[row - polygons];
    if (differs(arrays.cell[row], burned)) return sentence(arrays.describe(row), arrays.cell[row], burned);
  }
  for (std::uint32_t v = 0; v < again.vertex.size(); ++v)
    if (const double written = arrays.point[result.rows[v]]; differs(written, again.vertex[v]))
      return sentence(result.describe_vertex(v), written, again.vertex[v]);
  return {};
}

// Only bounds where the whole core is not burned again.
Check check_erosion_of_core(const Arrays& arrays, double most, const std::vector<double>* erosion, Context* context) {
  if (!arrays.is_whole()) return arrays.lacks();
  if (std::string wrong = wrong_range(arrays, 0, most, context); !wrong.empty())
    return failed(arrays.check_name(), std::move(wrong));
  if (erosion && !arrays.result.radius.empty()) {
    if (std::string wrong = not_as_burned(arrays, *erosion); !wrong.empty())
      return failed(arrays.check_name(), std::move(wrong));
    return passed(arrays, fmt::format("that of {} cells is what burning the core again gives", arrays.cells()));
  }
  return {arrays.check_name(),
          true,
          fmt::format("that of {} cells is {}, and of sides at least that of the cells around; the whole core is not "
                      "burned again",
                      arrays.cells(), most == 1 ? "from 0 to 1" : "not negative"),
          {}};
}

}  // namespace

std::string below_cells_around(const Result& result, const std::string& measure, const std::vector<double>& of_points,
                               const std::vector<double>& of_cells, double rounding, Context* context) {
  const std::vector<double> largest = result.largest_of_polygons(of_cells);
  const std::size_t verts = result.vert_vertices.size(), edges = result.complex.edges.size();
  std::vector<double> of_edges = largest;
  for (std::size_t l = 0; l < result.line_edges.size(); ++l) {
    const std::uint32_t e = result.line_edges[l];
    if (!(of_cells[verts + l] >= largest[e] * (1 - rounding)))
      return fmt::format("{} has {} {:.9g}, less than a polygon at it", result.describe_edge(e), measure,
                         of_cells[verts + l]);
    of_edges[e] = of_cells[verts + l];
  }
  const std::size_t bad = first_failure(edges, context, "verify: measures", [&](std::size_t e) {
    const auto [a, b] = result.complex.edges[e];
    return std::min(of_points[result.rows[a]], of_points[result.rows[b]]) >= of_edges[e] * (1 - rounding);
  });
  if (bad == edges) return {};
  return fmt::format("an end of {} has a {} below {:.9g}, that of a line or polygon at it",
                     result.describe_edge(static_cast<std::uint32_t>(bad)), measure, of_edges[bad]);
}

std::vector<Check> check_other_measures(const Result& result, const Sites& sites, const VerifyOptions& options,
                                        Context* context) {
  std::vector<Check> checks;
  if (Arrays(result, kCircumradius).is_there()) checks.push_back(check_circumradius(result, context));
  if (Arrays(result, kScaleAxis).is_there()) checks.push_back(check_scale_axis(result, options.samples, context));
  if (Arrays(result, kChordResidual).is_there())
    checks.push_back(check_chord_residual(result, sites, options.samples, context));
  if (const Arrays arrays(result, kCoreErosionThickness); arrays.is_there())
    checks.push_back(check_erosion_of_core(arrays, kUnbounded, options.erosion_of_core, context));
  if (const Arrays arrays(result, kRelativeErosionThickness); arrays.is_there())
    checks.push_back(check_erosion_of_core(arrays, 1, options.erosion_of_core, context));
  return checks;
}

}  // namespace quench::verification
