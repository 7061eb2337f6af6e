// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "burn_pipeline.h"
#include "core_pipeline.h"
#include "program.h"
#include "quench/io.h"
#include "skeleton_pipeline.h"

namespace quench::program {

Action add_skeleton(CLI::App& app) {
  struct Options {
    AxisOptions axis;
    BurnPipelineOptions burn;
    SkeletonPipelineOptions skeleton;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->axis);
  add_skeleton_options(app, o->skeleton);
  add_burn_options(app, o->burn);
  app.add_flag("--full", o->skeleton.full,
               "Write every part of a sheet with its own sheet_level, for any larger --theta2")
      ->group("Skeleton");
  app.add_option("-o,--output", o->output, "The skeleton: .vtp .ply .obj .csv")->type_name("FILE")->required();
  return [o](Session& session) {
    session.check_output(o->output, o->axis.inputs());
    io::check_writable_format(o->output);
    check_burn_options(o->burn);
    check_skeleton_options(o->skeleton);
    LoadedAxis loaded = load_axis(o->axis, session);
    const auto resolve = [&](const std::string& text, const std::string& option) {
      return loaded.resolve(text, option);
    };
    nlohmann::ordered_json report;
    report["input"] = loaded.input;
    take_burn_parameters(o->burn, loaded.data);
    Burning burning = compute_burning(loaded.axis, loaded.voxel_core, o->burn, true, resolve, report, session);
    const SkeletonPipelineResult result =
        compute_skeleton(loaded.axis, std::move(burning), o->skeleton, resolve, report, session);
    io::write_poly_data(o->output, to_poly_data(result.skeleton));
    session.finished("write");
    if (!session.options.report.empty()) write_report(session.options.report, report, session);
    const CellComplex& c = result.skeleton.complex;
    session.say(fmt::format("{}: {} vertices, {} edges, {} faces; {:.1f} s", o->output, c.vertex_count, c.edges.size(),
                            c.face_count(), session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
