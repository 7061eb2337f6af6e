// SPDX-License-Identifier: Apache-2.0
#include "program.h"
#include "quench/io.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {

Action add_core(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    pipeline::AxisOptions axis;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->axis);
  app.add_option("-o,--output", o->output, "The medial axis: .vtp .ply .obj .ma .r .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    io::check_writable_format(o->output);
    const pipeline::LoadedShape shape = load_shape(o->shape, session);
    pipeline::CoreResult core = pipeline::core_of(shape, o->axis, &session.context);
    say_core(shape, core, session);
    Json report = {{"input", input_section(o->shape, shape)}};
    add_core_sections(report, shape, core);
    io::OutputGroup outputs;
    io::write_record(o->output, pipeline::core_file(std::move(core)));
    session.finished("write");
    write_report(outputs, report, session);
    say_written(session, o->output, session.options.report == "-" ? "" : session.options.report, core, shape);
    return 0;
  };
}

}  // namespace quench::program
