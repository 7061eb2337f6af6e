// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "axis_input.h"
#include "base/text.h"
#include "burn_pipeline.h"
#include "core_pipeline.h"
#include "page_pipeline.h"
#include "program.h"
#include "quench/io.h"
#include "skeleton_pipeline.h"

namespace quench::program {
namespace {

/// The folder exists or can be created: told before a long computation, and created after it.
void check_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  check_name_length(fs::path(folder) / "skeleton.swc");
  const fs::path whole = fs::absolute(folder, error);
  fs::path existing = whole;
  for (; !fs::exists(existing, error) && existing.has_relative_path(); existing = existing.parent_path())
    if (fs::is_symlink(existing, error)) check_link(existing == whole ? fs::path(folder) : existing, "-o");
  if (!fs::is_directory(existing, error))
    throw Error(ErrorCode::usage,
                fmt::format("'{}' exists and is not a folder; give -o another name", existing.string()));
  if (const int reason = creation_error(existing))
    throw Error(ErrorCode::failed, fmt::format("cannot write to '{}': the folder '{}' is not writable: {}", folder,
                                               existing.string(), std::strerror(reason)));
}

}  // namespace

Action add_core(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    CorePipelineOptions core;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->core);
  app.add_option("-o,--output", o->output, "The medial axis: .vtp .ply .obj .ma .r .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    io::check_writable_format(o->output);
    check_core_options(o->core);
    const LoadedShape loaded = load_shape(o->shape, session);
    CorePipelineResult result = compute_core(loaded, o->core, session);
    io::OutputGroup outputs;
    io::write_record(o->output,
                     core_file(std::move(result.core), loaded.coordinates, json_text(result.report["parameters"])));
    session.finished("write");
    write_report(outputs, result.report, session);
    say_written(session, o->output, session.options.report == "-" ? "" : session.options.report, result.core, loaded);
    return 0;
  };
}

Action add_run(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    CorePipelineOptions core;
    BurnPipelineOptions burn;
    SkeletonPipelineOptions skeleton;
    PageOptions page;
    bool no_view = false;
    std::string folder;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->core);
  add_burn_options(app, o->burn);
  add_skeleton_options(app, o->skeleton);
  add_page_options(app, o->page);
  app.add_flag("--no-view", o->no_view, "Do not write view.html, the interactive page")->group("Page");
  app.add_option(
         "-o,--output", o->folder,
         "Folder for core.vtp, skeleton.vtp, skeleton.swc, branches.csv, report.json and view.html; created if absent")
      ->type_name("DIR")
      ->required();
  return [o](Session& session) {
    namespace fs = std::filesystem;
    const fs::path folder = o->folder, core = folder / "core.vtp", report = folder / "report.json";
    const fs::path skeleton_vtp = folder / "skeleton.vtp", swc = folder / "skeleton.swc", csv = folder / "branches.csv";
    const fs::path view = folder / "view.html";
    const bool with_page = !o->no_view && has_page_program();
    std::vector<fs::path> outputs_of_run{core, skeleton_vtp, swc, csv, report};
    if (with_page) outputs_of_run.push_back(view);
    check_folder(o->folder);
    std::error_code error;
    if (fs::exists(folder, error))
      for (const fs::path& file : outputs_of_run) session.check_output(file, {o->shape.file});
    session.check_report({o->shape.file});
    check_core_options(o->core);
    check_burn_options(o->burn);
    check_skeleton_options(o->skeleton);
    o->shape.keep_mesh = with_page;
    LoadedShape loaded = load_shape(o->shape, session);
    PageBuilder builder(o->page, session);
    if (with_page) {
      const Grid& grid = loaded.shape.grid();
      builder.set_origin(grid.world(Vec3::Zero()),
                         grid.world(Vec3(static_cast<double>(grid.dims[0]), static_cast<double>(grid.dims[1]),
                                         static_cast<double>(grid.dims[2]))));
      builder.page.title = title_of(o->shape.file);
      builder.page.files = {{"core", core.string()}, {"skeleton", skeleton_vtp.string()}, {"shape", o->shape.file}};
      builder.add_shape(loaded, o->shape);
      session.finished("page");
    }
    CorePipelineResult result = compute_core(loaded, o->core, session);
    const auto resolve = [&](const std::string& text, const std::string& option) {
      return parse_length(text, option).resolve(loaded.longest_side, loaded.shape.grid().spacing.minCoeff());
    };
    const MedialAxis& axis = result.core.axis;
    Record data = core_file(result.core, loaded.coordinates, json_text(result.report["parameters"]));
    Burning burning = compute_burning(axis, true, o->burn, true, resolve, result.report, session);
    add_burning(data, burning);
    if (with_page) {
      builder.page.lambda = field_number(data, "lambda");
      builder.page.burning = burning.options;
      builder.page.theta2 = resolve(o->skeleton.theta2, "--theta2");
      builder.page.theta1 = resolve(o->skeleton.theta1, "--theta1");
      builder.add_core(axis, data.point_data, true);
      session.finished("page");
    }
    const auto add_to_page = [&](const SkeletonFamily& family) {
      if (!with_page) return;
      builder.add_skeleton(family);
      session.finished("page");
    };
    const CheckedSkeleton skeleton =
        compute_skeleton(axis, std::move(burning), o->skeleton, loaded.shape.grid().spacing.minCoeff(), resolve,
                         result.report, session, add_to_page);
    fs::create_directories(o->folder, error);
    if (error)
      throw Error(ErrorCode::failed, fmt::format("the folder '{}' cannot be created: {}", o->folder, error.message()));
    auto& parameters = result.report["parameters"];
    parameters["omega"] = o->burn.omega;
    parameters["propagation"] = o->burn.propagation;
    parameters["radius"] = o->burn.radius;
    parameters["theta2"] = o->skeleton.theta2;
    parameters["theta1"] = o->skeleton.theta1;
    parameters["tips"] = o->skeleton.tips;
    parameters["smooth"] = o->skeleton.smooth;
    parameters["resample"] = o->skeleton.resample;
    result.report["skeleton"]["reconstructed"] = reconstructed_share(loaded.shape, skeleton.skeleton, &session.context);
    io::OutputGroup outputs;
    io::write_record(core, data);
    io::write_record(skeleton_vtp, skeleton_file(skeleton.skeleton, skeleton.topology, data));
    write_graph(skeleton.measured, {swc, {}, csv}, o->skeleton, &loaded.shape, loaded.shape.grid().spacing,
                loaded.coordinates, resolve, result.report, session);
    session.finished("write");
    if (with_page) builder.write(view, result.report, outputs);
    session.finished("page");
    write_report(report.string(), result.report, session);
    write_report(outputs, result.report, session);
    say_written(session, core.string(), report.string(), result.core, loaded);
    const CellComplex& c = skeleton.skeleton.complex;
    session.say(
        fmt::format("{}: {}, {}; topology as that of the shape; also {} and {}", skeleton_vtp.string(),
                    cells_text(c.vertex_count, c.edges.size(), c.face_count()),
                    base::counted(result.report["skeleton"]["branches"].get<std::size_t>(), "branch", "branches"),
                    swc.string(), csv.string()));
    if (with_page) session.say(fmt::format("{}: the interactive page; open it in a browser", view.string()));
    return 0;
  };
}

}  // namespace quench::program
