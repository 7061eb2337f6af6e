// SPDX-License-Identifier: Apache-2.0
#include "verification/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <variant>

#include "quench/error.h"
#include "quench/measures.h"

namespace quench::verification {

bool is_measure_of_cores(std::string_view name) { return find_measure_kind(name) != nullptr; }

bool is_in_every_file(const MeasureKind& measure, bool plane) {
  return measure.files == MeasureFiles::all || (measure.files == MeasureFiles::of_the_plane && plane);
}

bool has_numbers(const DataArray& array) { return !std::holds_alternative<std::vector<std::string>>(array.values); }

std::vector<double> numbers_or_empty(const std::vector<DataArray>& arrays, std::string_view name) {
  const DataArray* array = find_array(arrays, name);
  return array && has_numbers(*array) && array->components == 1 ? array->numbers() : std::vector<double>{};
}

std::string text_or_empty(const std::vector<DataArray>& arrays, std::string_view name) {
  const std::vector<std::string> texts = texts_or_empty(arrays, name);
  return texts.empty() ? std::string{} : texts.front();
}

std::vector<std::string> texts_or_empty(const std::vector<DataArray>& arrays, std::string_view name) {
  const DataArray* array = find_array(arrays, name);
  return array && !has_numbers(*array) ? std::get<std::vector<std::string>>(array->values) : std::vector<std::string>{};
}

Result::Result(const VoxelShape& voxels, const Record& file, const VerifyOptions& options)
    : shape(voxels), data(file), plane(voxels.grid().is_plane()) {
  const std::vector<double> reduced = numbers_or_empty(data.field_data, "main_axes");
  main_axes = reduced.size() == 1 && reduced[0] == 1;
  parse_cells();
  parse_arrays(options);
  recover_lattice();
  invert_incidences();
}

void Result::parse_cells() {
  std::vector<std::uint32_t> vertex_of(data.points.size(), kNone);
  for (std::uint32_t v : data.verts) vertex_of[v] = 0;
  for (const auto& line : data.lines) vertex_of[line[0]] = vertex_of[line[1]] = 0;
  for (std::uint32_t v : data.poly_corners) vertex_of[v] = 0;
  for (std::uint32_t p = 0; p < vertex_of.size(); ++p)
    if (vertex_of[p] != kNone) {
      vertex_of[p] = static_cast<std::uint32_t>(rows.size());
      rows.push_back(p);
    }

  std::vector<std::array<std::uint32_t, 2>> lines;
  for (const auto& line : data.lines) {
    const std::uint32_t a = vertex_of[line[0]], b = vertex_of[line[1]];
    lines.push_back({std::min(a, b), std::max(a, b)});
  }
  std::vector<std::uint32_t> corners;
  for (std::uint32_t v : data.poly_corners) corners.push_back(vertex_of[v]);
  complex = make_complex(static_cast<std::uint32_t>(rows.size()), lines, data.poly_offsets, std::move(corners));
  for (const auto& line : lines)
    line_edges.push_back(static_cast<std::uint32_t>(std::lower_bound(complex.edges.begin(), complex.edges.end(), line) -
                                                    complex.edges.begin()));
  for (std::uint32_t v : data.verts) vert_vertices.push_back(vertex_of[v]);
}

void Result::parse_arrays(const VerifyOptions& options) {
  const auto per_vertex = [&](std::string_view name) {
    const std::vector<double> all = numbers_or_empty(data.point_data, name);
    std::vector<double> kept;
    if (!all.empty())
      for (std::uint32_t row : rows) kept.push_back(all[row]);
    return kept;
  };
  ball_radius = per_vertex("radius");
  parse_surface();
  radius = fitted && has_voxel_geometry ? per_vertex("voxel_radius") : ball_radius;
  vertex_lambda = per_vertex("lambda");
  cell_lambda = numbers_or_empty(data.cell_data, "lambda");
  measures = texts_or_empty(data.field_data, "measures");
  if (!find_array(data.field_data, "measures")) measures.emplace_back(kLambda);

  const std::vector<double> a = numbers_or_empty(data.cell_data, "site_a");
  const std::vector<double> b = numbers_or_empty(data.cell_data, "site_b");
  const DataArray* sites = find_array(data.field_data, "sites");
  if (!a.empty() && !b.empty() && sites && sites->components == 3 && has_numbers(*sites)) {
    const std::vector<double> xyz = sites->numbers();
    const auto site = [&](double row) {
      LatticePoint p{-1, -1, -1};  // never a site: no voxel is at negative coordinates
      if (row >= 0 && 3 * row + 2 < static_cast<double>(xyz.size()))
        for (std::size_t i = 0; i < 3; ++i) p[i] = bounded(xyz[3 * static_cast<std::size_t>(row) + i]);
      return p;
    };
    for (std::size_t l = 0; plane && l < line_edges.size(); ++l)
      line_sites.push_back({site(a[data.verts.size() + l]), site(b[data.verts.size() + l])});
    for (std::size_t f = 0; f < complex.face_count(); ++f)
      face_sites.push_back({site(a[first_polygon() + f]), site(b[first_polygon() + f])});
  }

  stage = text_or_empty(data.field_data, "stage");
  ball_rule = text_or_empty(data.field_data, "lambda_rule") == "ball";
  const std::vector<double> threshold = numbers_or_empty(data.field_data, "lambda");
  lambda_given = options.lambda || !threshold.empty();
  lambda = options.lambda ? *options.lambda : threshold.empty() ? 0 : threshold[0];
  lambda_of_file = !threshold.empty() && threshold[0] == lambda;

  const std::vector<double> details = numbers_or_empty(data.field_data, kDetail);
  by_detail = options.detail || (!lambda_given && (!details.empty() || find_array(data.cell_data, "detail_level")));
  detail = options.detail ? *options.detail : details.empty() ? 0 : details[0];
  detail_of_file = !details.empty() && details[0] == detail;
  if (detail >= kInfiniteLevelInFiles) detail = std::numeric_limits<double>::infinity();
  auto_detail = 0.5 * shape.grid().diagonal();

  if (stage != "core" || by_detail || lambda_given) return;
  for (const MeasureKind& measure : kMeasures) {
    const std::string name(measure.name);
    const std::vector<double> least = numbers_or_empty(data.field_data, name);
    if (name == kLambda || (least.empty() && !find_array(data.cell_data, name + "_level"))) continue;
    by = name;
    if (!least.empty()) by_threshold = least[0];
  }
  if (by_threshold >= kInfiniteLevelInFiles) by_threshold = std::numeric_limits<double>::infinity();
}

void Result::parse_surface() {
  surface = text_or_empty(data.field_data, "surface");
  fitted = surface == "mesh" || surface == "grey" || surface == "smooth";
  if (!fitted) return;
  voxel_points_ = find_array(data.point_data, "voxel_point");
  has_voxel_geometry = voxel_points_ && has_numbers(*voxel_points_) && voxel_points_->components == 3 &&
                       !numbers_or_empty(data.point_data, "voxel_radius").empty();
  if (!has_voxel_geometry) voxel_points_ = nullptr;
}

Vec3 Result::voxel_point(std::uint32_t vertex) const {
  if (!voxel_points_) return point(vertex);
  return std::visit(
      [&]<class T>(const std::vector<T>& values) -> Vec3 {
        if constexpr (std::is_arithmetic_v<T>) {
          const T* at = values.data() + 3 * std::size_t{rows[vertex]};
          return Vec3(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]));
        }
        return Vec3::Zero();
      },
      voxel_points_->values);
}

Vec3 Result::scaled_point(std::uint32_t vertex) const {
  const Vec3 steps(static_cast<double>(scale[0]), static_cast<double>(scale[1]), static_cast<double>(scale[2]));
  return shape.grid().lattice(point(vertex)).cwiseProduct(steps);
}

void Result::recover_lattice() {
  scale = integer_spacing(shape.grid());
  const Vec3 steps(static_cast<double>(scale[0]), static_cast<double>(scale[1]), static_cast<double>(scale[2]));
  const Vec3 units = shape.grid().spacing.cwiseQuotient(steps);
  unit = units[0];
  slack = units.maxCoeff() / units.minCoeff() - 1;
  // A product and a sum per axis, each rounded, on the way to the file, and as many on the way back.
  double farthest = shape.grid().origin.cwiseAbs().maxCoeff();
  for (std::uint32_t row : rows) farthest = std::max(farthest, data.points[row].cwiseAbs().maxCoeff());
  rounding = 4 * std::numeric_limits<double>::epsilon() * farthest / unit;
  for (std::uint32_t v = 0; v < rows.size(); ++v) {
    lattice.push_back(shape.grid().lattice(voxel_point(v)));
    scaled.push_back(lattice.back().cwiseProduct(steps));
  }
}

void Result::invert_incidences() {
  edge_faces_count.assign(complex.edges.size(), 0);
  for (std::uint32_t e : complex.face_edges) ++edge_faces_count[e];
  vertex_edges = base::Csr<std::uint32_t>::group(rows.size(), [&](const auto& emit) {
    for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
      for (std::uint32_t v : complex.edges[e]) emit(v, e);
  });
  vertex_faces = base::Csr<std::uint32_t>::group(rows.size(), [&](const auto& emit) {
    for (std::uint32_t f = 0; f < complex.face_count(); ++f)
      for (std::uint32_t v : complex.corners(f)) emit(v, f);
  });
}

std::string Result::describe_vertex(std::uint32_t vertex) const {
  const Vec3& p = data.points[rows[vertex]];
  return plane ? fmt::format("point {} at ({:.9g}, {:.9g})", rows[vertex], p[0], p[1])
               : fmt::format("point {} at ({:.9g}, {:.9g}, {:.9g})", rows[vertex], p[0], p[1], p[2]);
}

std::string Result::describe_edge(std::uint32_t edge) const {
  return fmt::format("edge from {} to {}", describe_vertex(complex.edges[edge][0]),
                     describe_vertex(complex.edges[edge][1]));
}

std::string Result::describe_face(std::size_t face) const {
  return fmt::format("polygon {} with {}", face, describe_vertex(complex.corners(face)[0]));
}

std::vector<double> Result::largest_of_polygons(const std::vector<double>& of_cells) const {
  std::vector<double> largest(complex.edges.size(), 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) largest[e] = std::max(largest[e], of_cells[first_polygon() + f]);
  return largest;
}

Vec3 Result::centroid(std::size_t face) const {
  Vec3 sum = Vec3::Zero();
  for (std::uint32_t v : complex.corners(face)) sum += scaled[v];
  return sum / static_cast<double>(complex.corners(face).size());
}

void cover(Check& check, std::string_view array) { check.arrays.emplace_back(array); }

std::vector<std::uint32_t> sample(std::size_t count, std::size_t limit) {
  const std::size_t taken = std::min(count, limit);
  std::vector<std::uint32_t> indices(taken);
  for (std::size_t i = 0; i < taken; ++i)
    indices[i] =
        static_cast<std::uint32_t>(static_cast<double>(i) * static_cast<double>(count) / static_cast<double>(taken));
  return indices;
}

}  // namespace quench::verification
