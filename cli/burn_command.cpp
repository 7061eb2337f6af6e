// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "report.h"

namespace quench::program {
namespace {

void check_holds_arrays(const std::string& file) {
  io::check_writable_format(file);
  const std::string extension = extension_of(file);
  if (extension == ".vtp" || extension == ".ply" || extension == ".csv") return;
  throw Error(ErrorCode::usage,
              fmt::format("{} files cannot hold burn times; name '{}' .vtp, .ply or .csv", extension, file));
}

}  // namespace

Action add_burn(CLI::App& app) {
  struct Options {
    AxisInput axis;
    pipeline::BurningOptions burning;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->axis);
  add_burn_options(app, o->burning, false);
  app.add_option("-o,--output", o->output,
                 "AXIS with the point arrays burn_time, erosion_thickness, unburned: .vtp (which 'quench skeleton' and "
                 "'quench view' do not burn again) .ply .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    session.check_output(o->output, o->axis.inputs());
    check_holds_arrays(o->output);
    pipeline::LoadedAxis loaded = load_axis(o->axis, session);
    if (loaded.axis.grid.is_plane()) say_not_of_plane({}, o->burning, session);
    const bool keeps_sequence = extension_of(o->output) == ".vtp";  // others have no place for it
    const Burning burning = pipeline::burning_of(loaded.axis, loaded.voxel_core, o->burning, keeps_sequence,
                                                 loaded.scale, &session.context);
    const pipeline::BurnFigures burned = pipeline::figures_of(burning);
    say_burned(burned, loaded.axis.points.size(), session);
    Json report = {{"input", input_section(o->axis, loaded)}, {"parameters", parameters_section(o->burning)}};
    add_burn_section(report, burned);
    add_burning(loaded.data, burning, keeps_sequence ? burn_sequence(loaded.axis, burning) : std::vector<DataArray>());
    io::OutputGroup outputs;
    io::write_record(o->output, loaded.data, {"erosion_thickness"});
    session.finished("write");
    write_report(outputs, report, session);
    session.say(fmt::format("{}: burn time up to {:.6g}{}; {:.1f} s", o->output, burning.max_burn_time,
                            loaded.coordinates.units.empty() ? "" : " " + loaded.coordinates.units,
                            session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
