// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "option_checks.h"
#include "plane_files.h"
#include "program.h"
#include "quench/io.h"
#include "report.h"

namespace quench::program {
namespace {

/// Lines are written in the format of the extension, which is that of the option.
void check_line_formats(const std::vector<std::pair<std::string, std::string>>& files) {
  for (const auto& [option, file] : files)
    if (!file.empty() && extension_of(file) != "." + option.substr(2))
      throw Error(ErrorCode::usage, fmt::format("{} '{}' does not end in .{}", option, file, option.substr(2)));
}

}  // namespace

Action add_skeleton(CLI::App& app) {
  struct Options {
    AxisInput axis;
    pipeline::BurningOptions burning;
    pipeline::SkeletonOptions skeleton;
    GraphFileOptions graph;
    std::string output, swc, graphml, csv, geojson, svg, wkt;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->axis);
  add_skeleton_options(app, o->skeleton, o->graph);
  add_burn_options(app, o->burning, true);
  app.add_flag("--full", o->skeleton.parts,
               "Write every part of a sheet with its own sheet_level, for any larger --theta2")
      ->group("Skeleton");
  app.add_option("--swc", o->swc, "Also write the curves as trees with radii")->type_name("FILE");
  app.add_option("--graphml", o->graphml, "Also write the graph of ends and junctions")->type_name("FILE");
  app.add_option("--csv", o->csv, "Also write a table of branches: length, radii, tortuosity ...")->type_name("FILE");
  app.add_option("--geojson", o->geojson, "Also write the branches as lines for GIS programs; images and polygons only")
      ->type_name("FILE");
  app.add_option("--svg", o->svg, "Also write the branches as a drawing; images and polygons only")->type_name("FILE");
  app.add_option("--wkt", o->wkt, "Also write the branches as well-known text; images and polygons only")
      ->type_name("FILE");
  app.add_option("-o,--output", o->output, "The skeleton: .vtp .ply .obj .csv")->type_name("FILE")->required();
  return [o](Session& session) {
    const std::pair<const char*, const std::string&> outputs_by_option[] = {
        {"-o", o->output},         {"--swc", o->swc}, {"--graphml", o->graphml}, {"--csv", o->csv},
        {"--geojson", o->geojson}, {"--svg", o->svg}, {"--wkt", o->wkt}};
    for (const auto& [option, file] : outputs_by_option)
      if (!file.empty()) session.check_output(file, o->axis.inputs(), option);
    check_distinct({o->output, o->swc, o->graphml, o->csv, o->geojson, o->svg, o->wkt});
    check_line_formats({{"--geojson", o->geojson}, {"--svg", o->svg}, {"--wkt", o->wkt}});
    io::check_writable_format(o->output);
    pipeline::LoadedAxis loaded = load_axis(o->axis, session);
    Context* context = &session.context;
    const bool plane = loaded.axis.grid.is_plane();
    if (!plane && !(o->geojson + o->svg + o->wkt).empty())
      throw Error(ErrorCode::usage, fmt::format("'{}' is not of the plane; --geojson, --svg and --wkt write results of "
                                                "images and polygons",
                                                o->axis.file));
    if (plane) say_not_of_plane(o->skeleton, o->burning, session);
    pipeline::take_recorded(o->burning, loaded.data);
    Json report = {{"input", input_section(o->axis, loaded)}, {"parameters", parameters_section(o->burning)}};
    Json& parameters = report["parameters"];
    if (!plane) parameters["theta2"] = pipeline::text_of(o->skeleton.theta2);
    parameters["theta1"] = pipeline::text_of(o->skeleton.theta1);
    parameters["tips"] = o->skeleton.full_tips ? "full" : "pruned";
    parameters["smooth"] = o->graph.graph.smooth;
    parameters["resample"] = pipeline::text_of(o->graph.graph.resample);

    pipeline::RunOptions options;
    options.burning = o->burning;
    options.skeleton = o->skeleton;
    options.on_burned = [&](const pipeline::BurnFigures& burned) {
      say_burned(burned, loaded.axis.points.size(), session);
    };
    options.graph = o->graph.graph;
    if (loaded.voxel_core) options.graph.voxel = loaded.spacing;
    if (loaded.sites) options.graph.sites = &*loaded.sites;
    const pipeline::AxisRun run = pipeline::run_axis(loaded.axis, std::move(loaded.data), loaded.voxel_core,
                                                     topology(loaded.axis.complex), loaded.scale, options, context);
    add_axis_sections(report, run);

    io::OutputGroup outputs;
    io::write_record(o->output, pipeline::skeleton_file(run.skeleton, run.file));
    write_graph(run.graph, {o->swc, o->graphml, o->csv}, o->graph, plane ? Vec3(Vec3::Zero()) : options.graph.voxel,
                loaded.coordinates, report, session);
    for (const std::string& file : {o->geojson, o->svg, o->wkt})
      if (!file.empty()) io::write_lines(file, plane_lines(run.graph), {.y_down = loaded.coordinates.y_down});
    session.finished("write");
    write_report(outputs, report, session);
    session.say(fmt::format("{}: {}; {:.1f} s", o->output,
                            cells_text(pipeline::counts_of(run.skeleton.skeleton.complex), plane),
                            session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
