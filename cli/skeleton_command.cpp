// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "burn_pipeline.h"
#include "core_pipeline.h"
#include "program.h"
#include "quench/io.h"
#include "skeleton_pipeline.h"

namespace quench::program {
namespace {

void check_distinct(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!files[i].empty() && !files[j].empty() && is_same_place(files[i], files[j]))
        throw Error(ErrorCode::usage, fmt::format("two outputs are named '{}'; give them different names", files[i]));
}

}  // namespace

Action add_skeleton(CLI::App& app) {
  struct Options {
    AxisOptions axis;
    BurnPipelineOptions burn;
    SkeletonPipelineOptions skeleton;
    std::string output, swc, graphml, csv;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->axis);
  add_skeleton_options(app, o->skeleton);
  add_burn_options(app, o->burn);
  app.add_flag("--full", o->skeleton.full,
               "Write every part of a sheet with its own sheet_level, for any larger --theta2")
      ->group("Skeleton");
  app.add_option("--swc", o->swc, "Also write the curves as trees with radii")->type_name("FILE");
  app.add_option("--graphml", o->graphml, "Also write the graph of ends and junctions")->type_name("FILE");
  app.add_option("--csv", o->csv, "Also write a table of branches: length, radii, tortuosity ...")->type_name("FILE");
  app.add_option("-o,--output", o->output, "The skeleton: .vtp .ply .obj .csv")->type_name("FILE")->required();
  return [o](Session& session) {
    const std::pair<const char*, const std::string&> outputs_by_option[] = {
        {"-o", o->output}, {"--swc", o->swc}, {"--graphml", o->graphml}, {"--csv", o->csv}};
    for (const auto& [option, file] : outputs_by_option)
      if (!file.empty()) session.check_output(file, o->axis.inputs(), option);
    check_distinct({o->output, o->swc, o->graphml, o->csv});
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
    report["parameters"] = {{"omega", o->burn.omega},          {"propagation", o->burn.propagation},
                            {"radius", o->burn.radius},        {"theta2", o->skeleton.theta2},
                            {"theta1", o->skeleton.theta1},    {"smooth", o->skeleton.smooth},
                            {"resample", o->skeleton.resample}};
    Burning burning = compute_burning(loaded.axis, loaded.voxel_core, o->burn, true, resolve, report, session);
    add_burning(loaded.data, burning);
    const double finest = loaded.voxel > 0 ? loaded.voxel : burning.options.omega;
    const CheckedSkeleton result =
        compute_skeleton(loaded.axis, std::move(burning), o->skeleton, finest, resolve, report, session);
    io::OutputGroup outputs;
    io::write_record(o->output, skeleton_file(result.skeleton, result.topology, loaded.data));
    write_graph(result.measured, {o->swc, o->graphml, o->csv}, o->skeleton, nullptr,
                loaded.voxel_core ? loaded.spacing : Vec3(Vec3::Zero()), loaded.coordinates, resolve, report, session);
    session.finished("write");
    write_report(outputs, report, session);
    const CellComplex& c = result.skeleton.complex;
    session.say(fmt::format("{}: {}; {:.1f} s", o->output, cells_text(c.vertex_count, c.edges.size(), c.face_count()),
                            session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
