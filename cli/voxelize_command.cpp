// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {

void check_volume_format(const std::filesystem::path& output) {
  if (extension_of(output) != ".nrrd" && !io::is_zarr_name(output))
    throw Error(ErrorCode::usage,
                fmt::format("cannot write '{}': volumes are written as .nrrd or .zarr", output.string()));
}

Action add_voxelize(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    std::string output, surface;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  o->shape.how.core_follows = false;
  app.add_option("-o,--output", o->output, "The volume: .nrrd or .zarr (OME-Zarr), 1 inside and 0 outside")
      ->type_name("FILE")
      ->required();
  app.add_option("--surface-file", o->surface,
                 "Also the surface that --surface says, as triangles: .ply .obj .vtp; voxels have none")
      ->type_name("FILE");
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    check_volume_format(o->output);
    if (!o->surface.empty()) {
      session.check_output(o->surface, {o->shape.file, o->output});
      check_mesh_format(o->surface, "surfaces are written as .ply, .obj or .vtp");
    } else if (!o->shape.how.surface) {
      o->shape.how.surface = SurfaceKind::voxels;  // nobody looks at it
    }
    const pipeline::LoadedShape loaded = load_shape(o->shape, session);
    if (!o->surface.empty() && !loaded.surface)
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' has no surface but that of its voxels; --surface smooth makes one", o->shape.file));
    io::OutputGroup outputs;
    io::write_volume(o->output, loaded.shape, loaded.coordinates, &session.context);
    if (loaded.surface && !o->surface.empty()) {
      io::write_record(o->surface, to_record(loaded.surface->mesh()));
      session.say(fmt::format("{}: {} vertices, {} triangles ({})", o->surface, loaded.surface->mesh().points.size(),
                              loaded.surface->mesh().triangles.size(), name_of(loaded.surface->kind())));
    }
    session.finished("write");
    Json report;
    if (!session.options.report.empty()) {
      report["input"] = input_section(o->shape, loaded);
      report["parameters"] = loaded.parameters.empty() ? Json() : Json::parse(loaded.parameters);
      report["shape"] = shape_section(loaded);
    }
    write_report(outputs, report, session);
    session.say(
        fmt::format("{}: {} inside; {:.1f} s", o->output,
                    base::counted(loaded.shape.voxel_count(), loaded.shape.grid().is_plane() ? "pixel" : "voxel"),
                    session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
