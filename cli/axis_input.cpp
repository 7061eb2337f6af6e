// SPDX-License-Identifier: Apache-2.0
#include "axis_input.h"

#include <fmt/format.h>

#include "option_checks.h"
#include "quench/geometry.h"
#include "quench/io.h"
#include "shape_input.h"
#include "units.h"

namespace quench::program {
namespace {

void check_axis_options(const AxisInput& options) {
  for (const auto& file : options.inputs()) check_exists(file);
  if (io::kind_of(options.file) == io::Kind::volume)
    throw Error(
        ErrorCode::input,
        fmt::format("'{0}' is a volume, not a medial axis; 'quench core {0}' computes one of it", options.file));
  if (options.shape.empty() && has_volume_options(options.how))
    throw Error(ErrorCode::usage, "--threshold and the like say which voxels of --shape are meant; give --shape too");
}

/// What lengths refer to where a shape is given.
void take_scale(const AxisInput& options, Session& session, pipeline::Scale& scale) {
  if (io::kind_of(options.shape) == io::Kind::surface) {
    const Record mesh = pipeline::read_surface(options.shape, &session.context);
    refuse_result(mesh, options.shape);
    const double side = longest_side_of(mesh.points);
    if (side > 0) scale.longest_side = side;
    return;
  }
  ShapeOptions shape;
  shape.file = options.shape;
  shape.how = options.how;
  shape.how.surface = SurfaceKind::voxels;  // the axis says what it is fitted to
  const bool fitted = scale.fitted;
  scale = load_shape(shape, session).scale();
  scale.fitted = fitted;
}

/// What has no radii may be a shape.
void refuse_mesh(const Record& data, const std::string& file) {
  if (find_array(data.point_data, "radius") || data.poly_count() == 0) return;
  if (is_closed_mesh(data))
    throw Error(
        ErrorCode::input,
        fmt::format("'{0}' is a mesh, not a medial axis; 'quench core {0}' computes one of it; --radii gives an axis "
                    "that has none its radii",
                    file));
  throw Error(
      ErrorCode::input,
      fmt::format("'{0}' has no radius per vertex (a point array 'radius'); give those of a medial axis with --radii "
                  "(a .r file), or compute the axis of a shape with 'quench core {0}'",
                  file),
      "radii");
}

}  // namespace

std::vector<std::filesystem::path> AxisInput::inputs() const {
  std::vector<std::filesystem::path> list{file};
  if (!radii.empty()) list.emplace_back(radii);
  if (!shape.empty()) list.emplace_back(shape);
  return list;
}

void add_axis_options(CLI::App& app, AxisInput& o) {
  app.add_option("AXIS", o.file, "A medial axis, of Quench or of another program: .vtp .ply .obj .off .ma")
      ->type_name("")
      ->required();
  const auto group = "Medial axis";
  app.add_option("--radii", o.radii, "Radii of the vertices (a .r file: x y z r per line), matched by position")
      ->type_name("FILE")
      ->group(group);
  app.add_option(
         "--shape", o.shape,
         "The mesh or volume the axis is of: fractions refer to its longest side [default: what AXIS says, else "
         "the bounding box of AXIS]")
      ->type_name("FILE")
      ->group(group);
  add_volume_options(app, o.how, "Of a --shape that is a volume: ", group);
}

bool is_closed_mesh(const Record& data) {
  if (data.poly_count() == 0 || !data.lines.empty() || find_array(data.point_data, "radius")) return false;
  const SurfaceTopology surface = surface_topology(to_triangle_mesh(data));
  return surface.manifold && surface.boundary_edges == 0;
}

pipeline::LoadedAxis load_axis(const AxisInput& options, Session& session) {
  check_axis_options(options);
  Record data = pipeline::read_surface(options.file, &session.context);
  if (!options.radii.empty())
    pipeline::take_radii(data, options.radii, &session.context);
  else
    refuse_mesh(data, options.file);
  take_units(data, options.file, session);
  pipeline::LoadedAxis axis = pipeline::axis_of(std::move(data), options.file, &session.context);
  if (!options.shape.empty()) take_scale(options, session, axis.scale);
  return axis;
}

pipeline::LoadedShape load_shape_of(const AxisInput& options, const pipeline::LoadedAxis& axis, Session& session) {
  ShapeOptions shape;
  shape.file = options.shape;
  shape.how = options.how;
  take_recorded(shape, axis.data, options.file);
  if (io::kind_of(shape.file) == io::Kind::surface) shape.how.surface = std::nullopt;
  shape.how.core_follows = false;
  return load_shape(shape, session);
}

nlohmann::ordered_json input_section(const AxisInput& options, const pipeline::LoadedAxis& axis) {
  const CellComplex& c = axis.axis.complex;
  return {{"file", options.file},    {"kind", "medial axis"},   {"vertices", c.vertex_count},
          {"edges", c.edges.size()}, {"faces", c.face_count()}, {"longest_side", axis.scale.longest_side}};
}

}  // namespace quench::program
