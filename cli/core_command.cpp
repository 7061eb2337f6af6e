// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core_pipeline.h"
#include "program.h"
#include "quench/io.h"

namespace quench::program {

Action add_core(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    CorePipelineOptions core;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->core);
  app.add_option("-o,--output", o->output, "The medial axis: .vtp .ply .obj .ma .r .csv")->required();
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    io::check_writable_format(o->output);
    const LoadedShape loaded = load_shape(o->shape, session);
    const CorePipelineResult result = compute_core(loaded, o->core, session);
    io::write_poly_data(o->output, result.data);
    checkpoint(&session.context, "write", 1);
    if (!session.options.report.empty()) write_report(session.options.report, result.report, session);
    say_written(session, o->output, result, loaded);
    return 0;
  };
}

Action add_run(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    CorePipelineOptions core;
    std::string folder;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->core);
  app.add_option("-o,--output", o->folder, "Folder for core.vtp and report.json (made if absent; these files are replaced)")->required();
  return [o](Session& session) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::exists(o->folder, error) && !fs::is_directory(o->folder, error))
      throw Error(ErrorCode::usage, fmt::format("{} exists and is no folder; give -o another name", o->folder));
    const LoadedShape loaded = load_shape(o->shape, session);
    fs::create_directories(o->folder, error);
    if (error) throw Error(ErrorCode::failed, fmt::format("the folder {} cannot be made: {}", o->folder, error.message()));
    const CorePipelineResult result = compute_core(loaded, o->core, session);
    const std::string file = (fs::path(o->folder) / "core.vtp").string();
    io::write_poly_data(file, result.data);
    checkpoint(&session.context, "write", 1);
    write_report((fs::path(o->folder) / "report.json").string(), result.report, session);
    if (!session.options.report.empty()) write_report(session.options.report, result.report, session);
    say_written(session, file, result, loaded);
    return 0;
  };
}

}  // namespace quench::program
