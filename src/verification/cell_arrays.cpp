// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "quench/measures.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

// Calls visit(row, dimension, a vertex of the cell) for every cell of the file until it returns false.
template <class Visit>
void for_cells(const Result& result, const Visit& visit) {
  std::size_t row = 0;
  for (const std::uint32_t v : result.vert_vertices)
    if (!visit(row++, 0, v)) return;
  for (const std::uint32_t e : result.line_edges)
    if (!visit(row++, 1, result.complex.edges[e][0])) return;
  for (std::size_t f = 0; f < result.complex.face_count(); ++f)
    if (!visit(row++, 2, result.complex.corners(f)[0])) return;
}

std::string wrong_kind(const Result& result, const std::vector<double>& kind) {
  std::string wrong;
  for_cells(result, [&](std::size_t row, int dimension, std::uint32_t v) {
    const bool has_larger = dimension == 0 ? !result.vertex_edges[v].empty()
                            : dimension == 1
                                ? result.edge_faces_count[result.line_edges[row - result.vert_vertices.size()]] > 0
                                : false;
    const int expected = has_larger ? 0 : 2 - dimension;
    if (kind[row] != expected)
      wrong = fmt::format("cell {} has kind {:.9g}; it is {} ({})", row, kind[row], expected,
                          expected == 0   ? "part of a sheet"
                          : expected == 1 ? "a curve"
                                          : "a point");
    return wrong.empty();
  });
  return wrong;
}

std::string wrong_component(const Result& result, const std::vector<double>& component) {
  const std::vector<std::uint32_t> number = components(result.complex);
  std::string wrong;
  for_cells(result, [&](std::size_t row, int, std::uint32_t v) {
    if (component[row] != number[v])
      wrong = fmt::format("cell {} has component {:.9g}; counted by their first points it is {}", row, component[row],
                          number[v]);
    return wrong.empty();
  });
  return wrong;
}

double angle(double lambda, double squared_radius) {
  return squared_radius > 0
             ? 2 * std::asin(std::min(1.0, lambda / std::sqrt(squared_radius))) * (180 / std::numbers::pi)
             : 180;
}

// Whether the angle is that of lambda and a squared distance that may be off by `unsure`.
bool is_angle(double written, double lambda, double squared, double unsure) {
  const double least = angle(lambda, squared + unsure), most = angle(lambda, squared - unsure);
  return written >= least * (1 - kSingle) - 1e-9 && written <= most * (1 + kSingle) + 1e-9;
}

}  // namespace

std::vector<std::uint32_t> components(const CellComplex& complex) {
  std::vector<std::uint32_t> parent(complex.vertex_count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b] : complex.edges) {
    const std::uint32_t p = root(a), q = root(b);
    parent[std::max(p, q)] = std::min(p, q);
  }
  std::vector<std::uint32_t> number(complex.vertex_count);
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v) number[v] = root(v) == v ? count++ : number[root(v)];
  return number;
}

namespace {

// Per face the number of its sheet, by walking from face to face over edges of two.
std::vector<double> sheets(const Result& result) {
  const CellComplex& c = result.complex;
  std::vector<std::vector<std::uint32_t>> faces_at(c.edges.size());
  for (std::uint32_t f = 0; f < c.face_count(); ++f)
    for (const std::uint32_t e : c.sides(f)) faces_at[e].push_back(f);
  std::vector<double> number(c.face_count(), -1);
  double next = 0;
  for (std::uint32_t first = 0; first < c.face_count(); ++first) {
    if (number[first] >= 0) continue;
    number[first] = next;
    std::vector<std::uint32_t> walk{first};
    while (!walk.empty()) {
      const std::uint32_t f = walk.back();
      walk.pop_back();
      for (const std::uint32_t e : c.sides(f)) {
        if (faces_at[e].size() != 2) continue;
        for (const std::uint32_t g : faces_at[e])
          if (number[g] < 0) {
            number[g] = next;
            walk.push_back(g);
          }
      }
    }
    ++next;
  }
  return number;
}

std::string wrong_sheet(const Result& result, const std::vector<double>& sheet) {
  const std::vector<double> expected = sheets(result);
  const std::size_t first = result.data.cell_count() - result.complex.face_count();
  for (std::size_t row = 0; row < sheet.size(); ++row)
    if (const double is = row < first ? -1 : expected[row - first]; sheet[row] != is)
      return fmt::format("cell {} has sheet {:.9g}; it is {:.9g}", row, sheet[row], is);
  return {};
}

// Per vertex the number of the seam, a line of edges of three polygons or more, that runs on over it, by walking along
// each from its first edge; -1 elsewhere. `at`: per vertex its edges of seams.
std::vector<double> seams(const Result& result, const std::vector<std::vector<std::uint32_t>>& at) {
  const CellComplex& c = result.complex;
  std::vector<double> number(c.vertex_count, -1);
  std::vector<char> walked(c.edges.size(), 0);
  double next = 0;
  for (std::uint32_t first = 0; first < c.edges.size(); ++first) {
    if (result.edge_faces_count[first] <= 2 || walked[first]) continue;
    std::vector<std::uint32_t> walk{first};
    while (!walk.empty()) {
      const std::uint32_t e = walk.back();
      walk.pop_back();
      walked[e] = 1;
      for (const std::uint32_t v : c.edges[e]) {
        if (at[v].size() != 2) continue;
        number[v] = next;
        for (const std::uint32_t other : at[v])
          if (!walked[other]) walk.push_back(other);
      }
    }
    ++next;
  }
  return number;
}

std::string wrong_seam(const Result& result, const std::vector<double>& seam, const std::vector<double>& junction) {
  const CellComplex& c = result.complex;
  std::vector<std::vector<std::uint32_t>> at(c.vertex_count);
  for (std::uint32_t e = 0; e < c.edges.size(); ++e)
    if (result.edge_faces_count[e] > 2)
      for (const std::uint32_t v : c.edges[e]) at[v].push_back(e);
  const std::vector<double> expected = seams(result, at);
  for (std::uint32_t v = 0; v < c.vertex_count; ++v) {
    const std::size_t row = result.rows[v];
    const double meet = !at[v].empty() && at[v].size() != 2;
    if (seam[row] != expected[v] || junction[row] != meet)
      return fmt::format("{} has seam {:.9g} and junction {:.9g}; they are {:.9g} and {:.9g}",
                         result.describe_vertex(v), seam[row], junction[row], expected[v], meet);
  }
  return {};
}

}  // namespace

Check check_kinds(const Result& result) {
  const std::string name = "kinds and components";
  const std::vector<double> kind = numbers_or_empty(result.data.cell_data, "kind"),
                            component = numbers_or_empty(result.data.cell_data, "component");
  if (result.stage.empty())
    return not_checked(name, "no FieldData 'stage'");  // arrays of another program may mean something else
  Check check{name, true, {}, {}};
  if (find_array(result.data.cell_data, "kind")) {
    if (std::string wrong = wrong_kind(result, kind); !wrong.empty()) return failed(name, std::move(wrong));
    cover(check, "cell kind");
  }
  if (find_array(result.data.cell_data, "component")) {
    if (std::string wrong = wrong_component(result, component); !wrong.empty()) return failed(name, std::move(wrong));
    cover(check, "cell component");
  }
  if (find_array(result.data.cell_data, "sheet")) {
    const std::vector<double> sheet = numbers_or_empty(result.data.cell_data, "sheet");
    if (std::string wrong = wrong_sheet(result, sheet); !wrong.empty()) return failed(name, std::move(wrong));
    cover(check, "cell sheet");
  }
  const std::vector<double> seam = numbers_or_empty(result.data.point_data, "seam"),
                            junction = numbers_or_empty(result.data.point_data, "junction");
  if (!seam.empty() && seam.size() == junction.size()) {
    if (std::string wrong = wrong_seam(result, seam, junction); !wrong.empty()) return failed(name, std::move(wrong));
    cover(check, "point seam");
    cover(check, "point junction");
  }
  if (check.arrays.empty()) return not_checked(name, "no array 'kind' or 'component'");
  check.detail = fmt::format("{} cells as their complex gives them", result.data.cell_count());
  return check;
}

Check check_angles(const Result& result) {
  const std::string name = "object angles";
  const std::vector<double> point = numbers_or_empty(result.data.point_data, "object_angle"),
                            cell = numbers_or_empty(result.data.cell_data, "object_angle");
  Check check{name, true, {}, {}};
  if (result.stage.empty()) return not_checked(name, "no FieldData 'stage'");
  if (result.radius.empty()) return not_checked(name, "no array 'radius'");
  // In a core pruned by them, edges and vertices have the largest of the cells around.
  const bool of_top_cells = result.by == kObjectAngle;
  if (of_top_cells && !point.empty() && !cell.empty())
    if (std::string low = below_cells_around(result, "object angle", point, cell, kSingle, nullptr); !low.empty())
      return failed(name, std::move(low));
  if (!point.empty() && !result.vertex_lambda.empty()) {
    for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
      if (of_top_cells) break;
      const double r = result.radius[v], squared = r * r;
      if (is_angle(point[result.rows[v]], result.vertex_lambda[v], squared, kSingle * squared)) continue;
      return failed(name, fmt::format("{} has an object angle of {:.9g}; lambda {:.9g} and radius {:.9g} give {:.9g}",
                                      result.describe_vertex(v), point[result.rows[v]], result.vertex_lambda[v], r,
                                      angle(result.vertex_lambda[v], squared)));
    }
    cover(check, "point object_angle");
  }
  if (!cell.empty() && !result.cell_lambda.empty()) {
    std::string wrong;
    for_cells(result, [&](std::size_t row, int dimension, std::uint32_t v) {
      std::vector<std::uint32_t> corners{v};
      if (of_top_cells && dimension < 2) return true;  // a curve of a pruning may have been the rim of a sheet
      if (dimension == 1) {
        const auto& ends = result.complex.edges[result.line_edges[row - result.vert_vertices.size()]];
        corners.assign(ends.begin(), ends.end());
      } else if (dimension == 2) {
        const auto all = result.complex.corners(row - result.vert_vertices.size() - result.line_edges.size());
        corners.assign(all.begin(), all.end());
      }
      // The squared distance of the centre of points to a site is their mean one less their mean squared distance to
      // the centre. Each corner may be off by `rounding` along each axis, in the file and in the sums over corners.
      const double n = static_cast<double>(corners.size());
      Vec3 centre = Vec3::Zero();
      for (const std::uint32_t c : corners) centre += result.scaled[c] / n;
      double squared = 0, size = 0;
      for (const std::uint32_t c : corners) {
        const double r = result.radius[c] / result.unit;
        squared += (r * r - (result.scaled[c] - centre).squaredNorm()) / n;
        size = std::max({size, r, (result.scaled[c] - centre).norm()});
      }
      const double unsure = size * (size * (kSingle + 4 * result.slack) + 8 * n * result.rounding);
      const double lambda = result.cell_lambda[row] / result.unit;
      if (!is_angle(cell[row], lambda, squared, unsure))
        wrong = fmt::format("cell {} has an object angle of {:.9g}; lambda and radii give {:.9g}", row, cell[row],
                            angle(lambda, squared));
      return wrong.empty();
    });
    if (!wrong.empty()) return failed(name, std::move(wrong));
    cover(check, "cell object_angle");
  }
  if (check.arrays.empty()) return not_checked(name, "no array 'object_angle', or no 'lambda'");
  check.detail = "as lambda and radius give them";
  return check;
}

Check check_sites(const Result& result, const Sites& sites) {
  const std::string name = result.plane ? "sites of lines" : "sites of polygons";
  const std::vector<double> a = numbers_or_empty(result.data.cell_data, "site_a"),
                            b = numbers_or_empty(result.data.cell_data, "site_b");
  const DataArray* array = find_array(result.data.field_data, "sites");
  if (a.empty() || b.empty() || !array || array->components != 3 || !has_numbers(*array) || result.radius.empty())
    return not_checked(name, "no arrays 'site_a', 'site_b', 'sites' and 'radius'");
  const std::vector<double> xyz = array->numbers();
  const auto before = [](const LatticePoint& p, const LatticePoint& q) {
    return std::tie(p[2], p[1], p[0]) < std::tie(q[2], q[1], q[0]);
  };
  std::vector<LatticePoint> rows;
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3)
    rows.push_back({bounded(xyz[i]), bounded(xyz[i + 1]), bounded(xyz[i + 2])});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!std::binary_search(sites.lattice().begin(), sites.lattice().end(), rows[i], before))
      return failed(name, fmt::format("site {} is ({}, {}, {}), which is no boundary vertex of the shape", i,
                                      rows[i][0], rows[i][1], rows[i][2]));
    if (i > 0 && !before(rows[i - 1], rows[i]))
      return failed(name, fmt::format("sites {} and {} are not in the order of z, y, x", i - 1, i));
  }
  // The cells that have two sites: polygons, in the plane lines.
  const bool plane = result.plane;
  const std::size_t first = plane ? result.vert_vertices.size() : result.first_polygon(), count = a.size() - first;
  const auto corners = [&](std::size_t i) {
    return plane ? std::span<const std::uint32_t>(result.complex.edges[result.line_edges[i]])
                 : result.complex.corners(i);
  };
  const auto describe = [&](std::size_t i) {
    return plane ? result.describe_edge(result.line_edges[i]) : result.describe_face(i);
  };
  for (std::size_t row = 0; row < first; ++row)
    if (a[row] != -1 || b[row] != -1)
      return failed(name, fmt::format("cell {} is not a {}, but has the sites {:.9g} and {:.9g} instead of -1", row,
                                      plane ? "line" : "polygon", a[row], b[row]));
  std::vector<char> named(rows.size(), 0);
  for (std::size_t f = 0; f < count; ++f) {
    const double p = a[first + f], q = b[first + f];
    if (!(p >= 0 && p < q && q < static_cast<double>(rows.size())))
      return failed(
          name, fmt::format("{} has the sites {:.9g} and {:.9g} of {}, smaller first", describe(f), p, q, rows.size()));
    const auto scaled = [&](double row) {
      const LatticePoint& s = rows[static_cast<std::size_t>(row)];
      named[static_cast<std::size_t>(row)] = 1;
      return Vec3(static_cast<double>(s[0] * result.scale[0]), static_cast<double>(s[1] * result.scale[1]),
                  static_cast<double>(s[2] * result.scale[2]));
    };
    const Vec3 s = scaled(p), t = scaled(q);
    for (const std::uint32_t v : corners(f)) {
      const double r = result.radius[v] / result.unit;
      for (const Vec3& site : {s, t})
        if (const double distance = (result.scaled[v] - site).norm();  // to the tolerance of radii
            !(std::abs(distance - r) <= distance * (1e-5 + result.slack) + 4 * result.rounding))
          return failed(name, fmt::format("{} is not at the distance of its radius from a site of {}",
                                          result.describe_vertex(v), describe(f)));
    }
    const double half = 0.5 * result.unit * (s - t).norm();
    if (!result.cell_lambda.empty() &&
        !(std::abs(result.cell_lambda[first + f] - half) <= (kSingle + result.slack) * half))
      return failed(name, fmt::format("{} has lambda {:.9g}, half the distance of its sites is {:.9g}", describe(f),
                                      result.cell_lambda[first + f], half));
  }
  // All boundary vertices, or those of these cells only.
  const auto unused = std::find(named.begin(), named.end(), 0);
  if (rows.size() != sites.lattice().size() && unused != named.end())
    return failed(name,
                  fmt::format("site {} does not belong to a {}", unused - named.begin(), plane ? "line" : "polygon"));
  Check check{name, true, {}, {}};
  for (const char* covered : {"cell site_a", "cell site_b", "field sites"}) cover(check, covered);
  check.detail = fmt::format("{} boundary vertices; the two of each of {} {} are at the radius from its {}",
                             rows.size(), count, plane ? "lines" : "polygons", plane ? "ends" : "corners");
  return check;
}

Check check_fields(const Result& result, const VerifyOptions& options) {
  const std::string name = "what the file says of the shape";
  if (result.stage.empty()) return not_checked(name, "no FieldData 'stage'");
  const Grid& grid = result.shape.grid();
  Check check{name, true, {}, {}};
  std::string wrong;
  // Up to the last bits, which text may have lost.
  const auto compare = [&](const std::string& array, const std::vector<double>& expected, double length) {
    const DataArray* found = find_array(result.data.field_data, array);
    if (!found || !wrong.empty()) return;
    const std::vector<double> written = found->numbers();
    for (std::size_t i = 0; i < expected.size() && wrong.empty(); ++i)
      if (written.size() != expected.size() || !(std::abs(written[i] - expected[i]) <= 1e-12 * length))
        wrong = fmt::format("the field array '{}' has {:.12g} where the shape has {:.12g}", array,
                            i < written.size() ? written[i] : 0, expected[i]);
    cover(check, fmt::format("field {}", array));
  };
  const auto largest = [](const auto& values) { return values.cwiseAbs().maxCoeff(); };
  compare("dims", {grid.dims.begin(), grid.dims.end()}, 0);
  compare("spacing", {grid.spacing.data(), grid.spacing.data() + 3}, grid.spacing.minCoeff());
  compare("origin", {grid.origin.data(), grid.origin.data() + 3}, largest(grid.origin));
  std::vector<double> direction;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) direction.push_back(grid.direction(r, c));
  compare("direction", direction, 1);
  if (result.plane) {
    compare("dimension", {2}, 0);
    const std::string y_axis = text_or_empty(result.data.field_data, "y_axis");
    if (options.y_down && !y_axis.empty()) {
      if (wrong.empty() && (y_axis == "down") != *options.y_down)
        wrong = fmt::format("the field array 'y_axis' is '{}' where y of the shape grows {}", y_axis,
                            *options.y_down ? "down" : "up");
      cover(check, "field y_axis");
    }
  }
  if (options.longest_side) compare("longest_side", {*options.longest_side}, *options.longest_side);
  // Where nothing was pruned, the cells do not depend on the threshold that was chosen.
  for (const std::string_view measure : {kLambda, kDetail}) {
    const std::vector<double> pruned_at = numbers_or_empty(result.data.field_data, measure);
    if (result.stage == "core" && !pruned_at.empty() && pruned_at[0] > 0)
      compare(fmt::format("{}_chosen", measure), pruned_at, pruned_at[0]);
  }
  cover(check, "field stage");
  if (!wrong.empty()) return failed(name, std::move(wrong));
  for (const std::string& array : check.arrays)
    check.detail += (check.detail.empty() ? "" : ", ") + array.substr(std::string_view("field ").size());
  return check;
}

}  // namespace quench::verification
