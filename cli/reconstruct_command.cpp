// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "axis_input.h"
#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/solid_stages.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {
namespace {

constexpr std::int64_t kDefaultResolution = 256;

struct Options {
  AxisInput axis;
  ShapeOptions shape;  ///< `resolution` alone; file and the rest are those of `axis`
  std::string output;
  bool envelope = false;
};

bool is_volume_name(const std::string& file) { return extension_of(file) == ".nrrd" || io::is_zarr_name(file); }

/// The shape that the solid is compared with: voxels as of the axis where its file says which.
pipeline::LoadedShape load_its_shape(const Options& o, const pipeline::LoadedAxis& axis, Session& session) {
  ShapeOptions options;
  options.file = o.axis.shape;
  options.how = o.axis.how;
  options.how.resolution = o.shape.how.resolution;
  take_recorded(options, axis.data, o.axis.file);
  // Meshes are compared with whatever the axis is fitted to.
  if (io::kind_of(options.file) == io::Kind::surface) options.how.surface = std::nullopt;
  options.how.core_follows = false;
  return load_shape(options, session);
}

/// The grid of the solid, where no shape has one.
Grid grid_of(const Options& o, const pipeline::LoadedAxis& axis, EnvelopeKind kind) {
  if (!o.shape.how.resolution)
    if (const auto grid = pipeline::grid_of(axis.data)) return *grid;
  const Envelope envelope(axis.axis, kind);
  const double side = (envelope.high() - envelope.low()).maxCoeff();
  const std::int64_t resolution = o.shape.how.resolution.value_or(kDefaultResolution);
  if (resolution == pipeline::kAutomaticResolution)
    throw Error(ErrorCode::usage, "the resolution 'auto' is one of a mesh; give a number, or the mesh", "resolution");
  if (!(side > 0))
    throw Error(ErrorCode::input, fmt::format("'{}' is one point without a radius; there is no solid", o.axis.file));
  Grid grid = grid_around(envelope, side / static_cast<double>(resolution));
  if (axis.axis.grid.is_plane()) {
    grid.dims[2] = 1;
    grid.origin[2] = 0;
    grid.make_plane();
  }
  return grid;
}

Json figures_json(const DistanceFigures& f) { return {{"mean", f.mean}, {"p99", f.p99}, {"largest", f.largest}}; }
Json distances_json(const OneSidedDistances& d) {
  return {{"outside", figures_json(d.outside)}, {"either_side", figures_json(d.either)}, {"places", d.places}};
}

Json solid_section(const pipeline::SolidResult& solid) {
  const bool plane = solid.voxels.grid().is_plane();
  return {{"kind", solid.envelope.kind() == EnvelopeKind::full ? "envelope" : "balls"},
          {"elements", solid.envelope.size()},
          {plane ? "pixels" : "voxels", solid.voxels.voxel_count()},
          {"cut_off", solid.cut_off},
          {"spacing", spacing_json(solid.voxels.grid())},
          {"euler", solid.topology.euler},
          {"betti", solid.topology.betti},
          {"axis_betti", solid.of_axis.betti}};
}

Json errors_section(const pipeline::SolidErrors& errors, double side, const pipeline::LoadedShape& shape) {
  Json section = {{"surface", name_of(errors.surface)}, {"longest_side", side}};
  if (errors.from_solid) section["surface_from_solid"] = distances_json(*errors.from_solid);
  if (errors.from_surface) section["solid_from_surface"] = distances_json(*errors.from_surface);
  const VolumeErrors& v = errors.volume;
  section["volume"] = {{"shape", v.shape}, {"solid", v.envelope}, {"missing", v.missing}, {"added", v.added}};
  section["shape_betti"] = shape.topology.betti;
  return section;
}

std::string betti_text(const Topology& t) { return fmt::format("{}/{}/{}", t.betti[0], t.betti[1], t.betti[2]); }

void say_solid(const pipeline::SolidResult& solid, const pipeline::LoadedShape* shape, double side, Session& session) {
  session.say(fmt::format("solid: {} of {}; components/tunnels/cavities {}, of the axis {}{}",
                          solid.envelope.kind() == EnvelopeKind::full ? "balls, cones and slabs" : "balls",
                          base::counted(solid.envelope.size(), "element"), betti_text(solid.topology),
                          betti_text(solid.of_axis), shape ? ", of the shape " + betti_text(shape->topology) : ""));
  if (solid.topology.betti != solid.of_axis.betti)
    session.say(solid.envelope.kind() == EnvelopeKind::full
                    ? "note: the topology is not that of the axis, as parts thinner than a voxel fall apart, or close parts "
                      "meet; a larger --resolution shows them"
                    : "note: the topology is not that of the axis: balls alone may not meet, or meet where they should "
                      "not; --envelope fills what is between them");
  if (!solid.errors) return;
  const VolumeErrors& v = solid.errors->volume;
  const auto share = [&](double part) { return v.shape > 0 ? 100 * part / v.shape : 0; };
  session.say(fmt::format("{}: {:.3g} % missing, {:.3g} % added", solid.voxels.grid().is_plane() ? "area" : "volume",
                          share(v.missing), share(v.added)));
  const auto say = [&](const char* what, const DistanceFigures& f) {
    session.say(fmt::format("{}: mean {:.3g}, 99 % {:.3g}, largest {:.3g} thousandths of the longest side", what,
                            1000 * f.mean / side, 1000 * f.p99 / side, 1000 * f.largest / side));
  };
  if (solid.errors->from_solid) say("the surface outside the solid", solid.errors->from_solid->outside);
  if (solid.errors->from_surface) say("the solid outside the surface", solid.errors->from_surface->outside);
}

}  // namespace

Action add_reconstruct(CLI::App& app) {
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->axis);
  app.add_flag("--envelope", o->envelope,
               "Also what lies between the balls: cones along edges, slabs over triangles, radii linear");
  add_resolution(app, o->shape,
                 "Voxels along the longest side, 1 to 16384: of a mesh --shape as of 'core', else of the solid "
                 "[default: the voxels that AXIS says, else 256]");
  app.add_option(
         "-o,--output", o->output,
         "The solid: as voxels .nrrd .zarr, on the grid of the shape; as a closed mesh .ply .obj .vtp, with its "
         "signed distance from --shape")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    session.check_output(o->output, o->axis.inputs());
    const bool as_volume = is_volume_name(o->output);
    if (!as_volume)
      check_mesh_format(o->output, "solids are written as voxels (.nrrd .zarr) or as meshes (.ply .obj .vtp)");
    AxisInput input = o->axis;
    input.shape.clear();  // read here, as a shape and not only for its size
    if (!o->axis.shape.empty()) {
      check_exists(o->axis.shape);
      input.how = {};
    }
    const pipeline::LoadedAxis axis = load_axis(input, session);
    if (axis.axis.grid.is_plane() && !as_volume)
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' is the axis of an image, whose solid is written as .nrrd or .zarr", o->axis.file));
    const EnvelopeKind kind = o->envelope ? EnvelopeKind::full : EnvelopeKind::balls;
    std::optional<pipeline::LoadedShape> shape;
    if (!o->axis.shape.empty()) {
      shape = load_its_shape(*o, axis, session);
      if (shape->shape.grid().is_plane() != axis.axis.grid.is_plane())
        throw Error(ErrorCode::usage, fmt::format("'{}' is not the medial axis of '{}': one of them is of the plane",
                                                  o->axis.file, o->axis.shape));
    }
    const Grid grid = shape ? shape->shape.grid() : grid_of(*o, axis, kind);
    const double side = shape ? shape->longest_side : axis.scale.longest_side;
    const pipeline::SolidResult solid =
        pipeline::solid_of(axis.axis, kind, grid, shape ? &*shape : nullptr, &session.context);
    io::OutputGroup outputs;
    if (as_volume) {
      io::write_volume(o->output, solid.on_grid, shape ? shape->coordinates : axis.coordinates, &session.context);
    } else {
      const Record mesh = pipeline::mesh_of(solid, &session.context);
      io::write_record(o->output, mesh, {"distance"});
    }
    session.finished("write");
    Json report = {{"input", input_section(o->axis, axis)}, {"solid", solid_section(solid)}};
    if (shape) report["errors"] = errors_section(*solid.errors, side, *shape);
    write_report(outputs, report, session);
    say_solid(solid, shape ? &*shape : nullptr, side, session);
    if (as_volume && solid.cut_off > 0)
      session.say(fmt::format("note: {} of the solid lie beyond the grid of the shape and are not in the file",
                              base::counted(solid.cut_off, grid.is_plane() ? "pixel" : "voxel")));
    session.say(fmt::format("{}; {:.1f} s", o->output, session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
