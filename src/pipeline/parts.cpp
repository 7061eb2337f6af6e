// SPDX-License-Identifier: Apache-2.0
#include "quench/parts.h"

#include <cmath>
#include <utility>

#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/solid_stages.h"

namespace quench::pipeline {

PartsOptions parts_options(const Vec3& voxel) { return {0.5 * voxel.minCoeff()}; }

namespace {

void even_triangles(PartsRun& run, const std::optional<Length>& remesh, const Scale& scale, Context* context) {
  if (!remesh) return;
  const double length = scale.resolve(*remesh, "remesh");
  if (!(length > 0) || !std::isfinite(length))
    throw Error(ErrorCode::usage, "the sides of triangles need a length above 0; give one such as '2%' or '3vox'",
                "remesh");
  double area = 0;
  for (const Sheet& sheet : run.parts.sheets) area += sheet.area;
  constexpr double kBytes = 600;  // per triangle, of what is worked on and what is written
  const double triangles = area / (0.433 * length * length) + static_cast<double>(run.mesh.triangles.size());
  require_memory(static_cast<std::int64_t>(std::min(kBytes * triangles, 1e18)), "sheets of such small triangles",
                 {"a larger length"}, context);
  run.mesh = remeshed(run.mesh, {.length = length}, context);
}

// The values of the faces, which come last among the cells; nothing where they are not there.
std::vector<double> of_faces(const Record& data, const char* name, std::size_t faces) {
  const DataArray* array = find_array(data.cell_data, name);
  if (!array || array->components != 1 || data.poly_count() != faces || array->size() != data.cell_count()) return {};
  const std::vector<double> values = array->numbers();
  return {values.end() - static_cast<std::ptrdiff_t>(faces), values.end()};
}

std::vector<double> of_points(const Record& data, const char* name, std::size_t points) {
  const DataArray* array = find_array(data.point_data, name);
  if (!array || array->components != 1 || array->size() != points) return {};
  return array->numbers();
}

}  // namespace

PartsRun run_parts(const Skeleton& skeleton, const Vec3& voxel, const std::optional<Length>& remesh, const Scale& scale,
                   Context* context) {
  PartsRun run;
  run.options = parts_options(voxel);
  run.parts = parts_of(skeleton, run.options, context);
  run.mesh = sheet_mesh(skeleton, run.parts, context);
  even_triangles(run, remesh, scale, context);
  return run;
}

PartsRun run_parts(const LoadedAxis& loaded, const std::optional<Length>& remesh, Context* context) {
  const MedialAxis& axis = loaded.axis;
  PartsRun run;
  const bool skeleton = field_text(loaded.data, "stage") == "skeleton";
  if (!loaded.scale.fitted && (loaded.voxel_core || skeleton)) run.options = parts_options(loaded.spacing);
  run.parts = parts_of(axis.complex, axis.points, axis.radius,
                       of_faces(loaded.data, "erosion_thickness", axis.complex.face_count()), run.options, context);
  run.mesh = sheet_mesh(axis.complex, axis.points, axis.radius,
                        of_points(loaded.data, "erosion_thickness", axis.points.size()), run.parts, context);
  even_triangles(run, remesh, loaded.scale, context);
  return run;
}

void add_parts_fields(Record& data, const Record& from) {
  for (const char* name : {"dims", "spacing", "origin", "direction", "longest_side", "lambda", "detail", "omega",
                           "surface", "units", "SPACE", "theta2", "theta1", "rims_above", "smooth", "parameters"})
    if (const DataArray* array = find_array(from.field_data, name)) data.field_data.push_back(*array);
  data.field_data.push_back({"stage", 1, std::vector<std::string>{"parts"}});
  data.field_data.push_back({"version", 1, std::vector<std::string>{QUENCH_VERSION}});
  data.field_data.push_back({"format_version", 1, std::vector<std::int64_t>{kFormatVersion}});
}

}  // namespace quench::pipeline
