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
  if (extension_of(output) != ".nrrd")
    throw Error(ErrorCode::usage, fmt::format("cannot write '{}': volumes are written as .nrrd", output.string()));
}

Action add_voxelize(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  o->shape.how.core_follows = false;
  app.add_option("-o,--output", o->output, "The volume: .nrrd, 1 inside and 0 outside")->type_name("FILE")->required();
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    check_volume_format(o->output);
    const pipeline::LoadedShape loaded = load_shape(o->shape, session);
    io::OutputGroup outputs;
    io::write_volume(o->output, loaded.shape, loaded.coordinates, &session.context);
    session.finished("write");
    Json report;
    if (!session.options.report.empty()) {
      report["input"] = input_section(o->shape, loaded);
      report["parameters"] = loaded.parameters.empty() ? Json() : Json::parse(loaded.parameters);
      report["shape"] = shape_section(loaded);
    }
    write_report(outputs, report, session);
    session.say(fmt::format("{}: {} inside; {:.1f} s", o->output, base::counted(loaded.shape.voxel_count(), "voxel"),
                            session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
