// SPDX-License-Identifier: Apache-2.0
// What is checked in the plane only: that the file is of the plane, and the ways along the boundary.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kOffThePlane = 1e-9;  // of a pixel

/// The arrays `mgf` by the sites that are found here.
class BoundaryWays {
 public:
  BoundaryWays(const Result& result, const Sites& sites, const VertexSites& vertex_sites,
               const BoundaryCurves& boundary)
      : result_(result),
        sites_(sites),
        vertex_sites_(vertex_sites),
        boundary_(boundary),
        of_(result.shape, sites, result.unit, result.ball_rule) {}

  double of_edge(std::uint32_t e) const {
    const Ids set = edge_sites(result_, vertex_sites_, e);
    return set.size() == 2 ? way(set[0], set[1]) : 0;
  }
  // The largest of the edges of the unpruned core. Without any, the vertex is the centre of a pixel by itself, and two
  // opposite corners are as far apart as two points of its outline can be.
  double of_vertex(std::uint32_t v) const {
    double largest = 0;
    bool has_edges = false;
    for (const Ids& side : sides_of_polygon(sites_, vertex_sites_.at(v)))
      if (!of_.is_boundary_edge(side[0], side[1])) {
        has_edges = true;
        largest = std::max(largest, way(side[0], side[1]));
      }
    if (has_edges) return largest;
    const auto& pixel = result_.scale;
    return result_.unit * static_cast<double>(pixel[0] + pixel[1]);
  }

 private:
  double way(std::uint32_t a, std::uint32_t b) const { return result_.unit * boundary_.shorter_way(a, b); }

  const Result& result_;
  const Sites& sites_;
  const VertexSites& vertex_sites_;
  const BoundaryCurves& boundary_;
  LambdaOfSites of_;
};

std::string defect_of_dimension(const Result& result) {
  const DataArray* field = find_array(result.data.field_data, "dimension");
  const std::vector<double> dimension = numbers_or_empty(result.data.field_data, "dimension");
  if ((field || !result.stage.empty()) && (dimension == std::vector<double>{2}) != result.plane)
    return result.plane ? "the shape is of the plane, made of pixels; the result does not say that it is (no field "
                          "array 'dimension' of 2)"
                        : "the result says that it is of the plane (field array 'dimension'); the shape is not, it is "
                          "made of voxels";
  if (!result.plane) return {};
  if (result.complex.face_count() > 0)
    return fmt::format("the shape is of the plane, made of pixels; the result has {} polygons",
                       result.complex.face_count());
  const double off = kOffThePlane + 4 * result.rounding / static_cast<double>(result.scale[2]);
  for (std::uint32_t v = 0; v < result.rows.size(); ++v)
    if (!(std::abs(result.lattice[v][2]) <= off))
      return fmt::format("{} is not in the plane of the pixels: its z is {:.9g}", result.describe_vertex(v),
                         result.point(v)[2]);
  return {};
}

}  // namespace

Check check_dimension(const Result& result) {
  const std::string name = "dimension";
  if (std::string defect = defect_of_dimension(result); !defect.empty()) return failed(name, std::move(defect));
  return {name, true, result.plane ? "shape and result are of the plane" : "shape and result are of space", {}};
}

Check check_mgf(const Result& result, const Sites& sites, VertexSites& vertex_sites, const BoundaryCurves& boundary,
                Context* context) {
  const std::string name = "ways along the boundary";
  const std::vector<double> point = numbers_or_empty(result.data.point_data, kMgf),
                            cell = numbers_or_empty(result.data.cell_data, kMgf);
  if (point.empty() && cell.empty()) return not_checked(name, "no array 'mgf'");
  vertex_sites.prepare(sample(result.rows.size(), result.rows.size()), context);
  const BoundaryWays ways(result, sites, vertex_sites, boundary);
  const auto same = [&](double written, double expected) {
    if (std::isinf(expected)) return written >= kInfiniteLevelInFiles;
    return std::abs(written - expected) <= (1e-9 + result.slack) * expected;
  };
  const auto sentence = [&](const std::string& what, double written, double expected) {
    return fmt::format("{} has mgf {:.9g}, the shorter way along the boundary is {:.9g}", what, written, expected);
  };
  Check check{name, true, {}, {}};
  const std::size_t lines = result.line_edges.size(), verts = result.vert_vertices.size();
  if (!cell.empty()) {
    const auto expected = [&](std::size_t row) {
      return row < verts ? ways.of_vertex(result.vert_vertices[row]) : ways.of_edge(result.line_edges[row - verts]);
    };
    const std::size_t bad = first_failure(verts + lines, context, "verify: boundary",
                                          [&](std::size_t row) { return same(cell[row], expected(row)); });
    if (bad < verts + lines)
      return failed(name, sentence(bad < verts ? result.describe_vertex(result.vert_vertices[bad])
                                               : result.describe_edge(result.line_edges[bad - verts]),
                                   cell[bad], expected(bad)));
    cover(check, "cell mgf");
  }
  if (!point.empty()) {
    const auto expected = [&](std::size_t v) { return ways.of_vertex(static_cast<std::uint32_t>(v)); };
    const std::size_t bad = first_failure(result.rows.size(), context, "verify: boundary",
                                          [&](std::size_t v) { return same(point[result.rows[v]], expected(v)); });
    if (bad < result.rows.size())
      return failed(name, sentence(result.describe_vertex(static_cast<std::uint32_t>(bad)), point[result.rows[bad]],
                                   expected(bad)));
    cover(check, "point mgf");
  }
  check.detail = fmt::format("mgf of {} vertices and {} lines is that between their sites", result.rows.size(), lines);
  return check;
}

}  // namespace quench::verification
