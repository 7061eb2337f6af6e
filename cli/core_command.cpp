// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>

#include "base/platform/system_files.h"
#include "program.h"
#include "quench/io.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {
namespace {

struct CoreProgram {
  ShapeOptions shape;
  pipeline::AxisOptions axis;
  std::string output;
  std::string bricks_in;  ///< empty: not in bricks; kBeside: in the folder of the output
};

// What CLI11 makes of a flag without a value.
constexpr const char* kBeside = "true";

int core(CoreProgram o, Session& session) {
  session.check_output(o.output, {o.shape.file});
  io::check_writable_format(o.output);
  if (!o.bricks_in.empty()) {
    const std::filesystem::path beside = std::filesystem::path(o.output).parent_path();
    o.axis.bricks_in = o.bricks_in != kBeside ? std::filesystem::path(o.bricks_in) : beside.empty() ? "." : beside;
    if (const int reason = base::creation_error(*o.axis.bricks_in))
      throw Error(ErrorCode::failed, fmt::format("cannot write in the folder '{}' of --in-bricks: {}",
                                                 o.axis.bricks_in->string(), std::strerror(reason)));
    choose_surface_in_bricks(o.shape, session);
  }
  const pipeline::LoadedShape shape = load_shape(o.shape, session);
  pipeline::CoreResult core = pipeline::core_of(shape, o.axis, &session.context);
  say_core(shape, core, session);
  Json report = {{"input", input_section(o.shape, shape)}};
  add_core_sections(report, shape, core);
  io::OutputGroup outputs;
  io::write_record(o.output, pipeline::core_file(std::move(core)));
  session.finished("write");
  write_report(outputs, report, session);
  say_written(session, o.output, session.options.report == "-" ? "" : session.options.report, core, shape);
  return 0;
}

}  // namespace

Action add_core(CLI::App& app) {
  auto o = std::make_shared<CoreProgram>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->axis);
  app.add_option("-o,--output", o->output, "The medial axis: .vtp .vtu .ply .obj .stl .ma .r .csv")
      ->type_name("FILE")
      ->required();
  app.add_flag("--in-bricks", o->bricks_in,
               "Work in bricks: less memory, the same medial axis, slower. What they have found lies in nameless files "
               "beside the output, or in the folder DIR of --in-bricks=DIR")
      ->group("Medial axis");
  return [o](Session& session) { return core(*o, session); };
}

}  // namespace quench::program
