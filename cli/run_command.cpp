// SPDX-License-Identifier: Apache-2.0
#include "run_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/platform/system_files.h"
#include "base/text.h"
#include "option_checks.h"
#include "plane_files.h"
#include "program.h"
#include "quench/io.h"
#include "quench/picture.h"
#include "report.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

/// The outputs of a run; `view` and `picture` are empty where there are none.
struct Files {
  explicit Files(const fs::path& folder, bool with_page, bool with_picture)
      : core(folder / "core.vtp"),
        skeleton(folder / "skeleton.vtp"),
        swc(folder / "skeleton.swc"),
        csv(folder / "branches.csv"),
        parts(folder / "parts.csv"),
        geojson(folder / "skeleton.geojson"),
        svg(folder / "skeleton.svg"),
        report(folder / "report.json"),
        view(with_page ? folder / "view.html" : fs::path()),
        picture(with_picture ? folder / "picture.png" : fs::path()) {}
  bool has_page() const { return !view.empty() || !picture.empty(); }
  fs::path core, skeleton, swc, csv, parts, geojson, svg, report, view, picture;
};

}  // namespace

void check_folder(const std::string& folder) {
  std::error_code error;
  check_name_length(fs::path(folder) / "skeleton.swc");
  const std::string extension = extension_of(folder);
  for (const char* file : {".svg", ".geojson", ".json", ".png", ".html", ".vtp", ".csv", ".swc"})
    if (extension == file && !fs::exists(folder, error) && !fs::is_symlink(folder, error))
      throw Error(ErrorCode::usage, fmt::format("'{}' would be a folder: -o names the folder for all files; leave out "
                                                "the {}",
                                                folder, file));
  const fs::path whole = fs::absolute(folder, error);
  fs::path existing = whole;
  for (; !fs::exists(existing, error) && existing.has_relative_path(); existing = existing.parent_path())
    if (fs::is_symlink(existing, error)) check_link(existing == whole ? fs::path(folder) : existing, "-o");
  if (!fs::is_directory(existing, error))
    throw Error(ErrorCode::usage,
                fmt::format("'{}' exists and is not a folder; give -o another name", existing.string()));
  if (const int reason = base::creation_error(existing))
    throw Error(ErrorCode::failed, fmt::format("cannot write to '{}': the folder '{}' is not writable: {}", folder,
                                               existing.string(), std::strerror(reason)));
}

void create_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::failed, fmt::format("the folder '{}' cannot be created: {}", folder, error.message()));
}

namespace {

void check_outputs(const RunProgram& o, const Files& files, const Session& session) {
  check_folder(o.folder);
  std::error_code error;
  if (fs::exists(o.folder, error))
    for (const fs::path& file :
         {files.core, files.skeleton, files.swc, files.csv, files.parts, files.report, files.view, files.picture})
      if (!file.empty()) session.check_output(file, {o.shape.file});
  session.check_report({o.shape.file});
}

Json report_of(const RunProgram& o, const pipeline::LoadedShape& shape, const pipeline::RunResult& result) {
  Json report = {{"input", input_section(o.shape, shape)}};
  add_core_sections(report, shape, result.core);
  add_axis_sections(report, result.axis);
  Json& parameters = report["parameters"];
  parameters.update(parameters_section(o.run.burning));
  if (!shape.shape.grid().is_plane()) parameters["theta2"] = pipeline::text_of(o.run.skeleton.theta2);
  parameters["theta1"] = pipeline::text_of(o.run.skeleton.theta1);
  parameters["tips"] = o.run.skeleton.full_tips ? "full" : "pruned";
  parameters["smooth"] = o.graph.graph.smooth;
  parameters["resample"] = pipeline::text_of(o.graph.graph.resample);
  report["skeleton"]["reconstructed"] = *result.axis.skeleton.reconstructed;
  if (result.thickness) report["thickness"] = thickness_section(*result.thickness, shape.shape.grid().is_plane());
  return report;
}

// Parts whose branches are all below theta1 are points, which tables of branches do not have.
void say_points(const CurveGraph& graph, Session& session) {
  const auto points = std::ranges::count(graph.nodes, CurveGraph::NodeKind::isolated, &CurveGraph::Node::kind);
  if (points > 0)
    session.say(fmt::format("note: {} of the shape {}, without a branch (smaller than theta1)",
                            base::counted(points, "part"), points == 1 ? "is a point" : "are points"));
}

// What a skeleton has of sheets, and how thick the shape is.
void say_sheets(const pipeline::RunResult& result, const fs::path& file, Session& session) {
  if (!result.axis.parts || !result.thickness) return;
  const std::size_t sheets = result.axis.parts->sheets.size();
  const ThicknessDistribution& shape = result.thickness->shape;
  session.say(fmt::format("{}: {}; the shape is {:.4g} thick on average, 90 % of it between {:.4g} and {:.4g}",
                          file.string(), base::counted(sheets, "sheet"), shape.mean(), shape.percentile(0.05),
                          shape.percentile(0.95)));
}

// Where a skeleton stands for little of a shape whose axis stands for most of it: what to turn.
void say_little(const pipeline::RunResult& result, Session& session) {
  constexpr double kLittle = 0.7;
  const double share = *result.axis.skeleton.reconstructed;
  if (share >= kLittle || result.core.reconstructed < kLittle) return;
  const Skeleton& skeleton = result.axis.skeleton.skeleton;
  if (!std::isfinite(skeleton.theta2)) return;  // curves only, as asked
  if (skeleton.main_axes) return;               // as asked
  if (skeleton.plane)
    return session.say("note: the skeleton stands for little of the shape; a smaller --theta1 keeps more branches");
  session.say(
      fmt::format("note: the skeleton stands for little of the shape; a smaller --theta2 (now {:.3g}) keeps more "
                  "sheets, a smaller --theta1 more branches",
                  skeleton.theta2));
}

bool holds_polygons(const RunProgram& o) { return io::kind_of(o.shape.file) == io::Kind::polygons; }

int run_pipeline(const RunProgram& o, Session& session) {
  check_exists(o.shape.file);
  if (holds_polygons(o) && !o.shape.how.feature && !pipeline::holds_one_feature(o.shape.file))
    return run_features(o, session);
  const Files files(o.folder, !o.no_view && pipeline::has_page_program(), !o.no_picture);
  check_outputs(o, files, session);
  ShapeOptions how = o.shape;
  how.how.keep_mesh = files.has_page();
  pipeline::LoadedShape shape = load_shape(how, session);
  const bool plane = shape.shape.grid().is_plane();
  if (plane) say_not_of_plane(o.run.skeleton, o.run.burning, session);
  if (std::error_code error; plane && fs::exists(o.folder, error))
    for (const fs::path& file : {files.geojson, files.svg}) session.check_output(file, {o.shape.file});
  pipeline::PageBuilder builder(o.max_triangles);
  builder.page.command = session.options.command;
  builder.page.limit_name = "--max-triangles";
  builder.page.title = pipeline::title_of(o.shape.file);
  builder.page.files = {{"core", files.core.string()}, {"skeleton", files.skeleton.string()}, {"shape", o.shape.file}};

  pipeline::RunOptions options = o.run;
  options.graph = o.graph.graph;
  options.measures = true;
  options.page = files.has_page() ? &builder : nullptr;
  options.page_sliders = !files.view.empty();
  std::size_t vertices = 0;
  options.on_core = [&](const pipeline::CoreResult& core) {
    vertices = core.axis.points.size();
    say_core(shape, core, session);
  };
  options.on_burned = [&](const pipeline::BurnFigures& burned) { say_burned(burned, vertices, session); };
  const pipeline::RunResult result = pipeline::run(shape, options, &session.context);

  create_folder(o.folder);
  Json report = report_of(o, shape, result);
  io::OutputGroup outputs;
  io::write_record(files.core, result.axis.file);
  io::write_record(files.skeleton, pipeline::skeleton_file(result.axis.skeleton, result.axis.file));
  write_graph(result.axis.graph, {files.swc, {}, files.csv}, o.graph,
              shape.surface || plane ? Vec3(Vec3::Zero()) : shape.shape.grid().spacing, shape.coordinates, report,
              session);
  if (result.axis.parts) io::write_table(files.parts, sheet_table(*result.axis.parts, shape.coordinates.units));
  if (plane) {
    const io::PlaneLines lines = plane_lines(shape, result);
    for (const fs::path& file : {files.geojson, files.svg})
      io::write_lines(file, lines, {.y_down = shape.coordinates.y_down});
  }
  session.finished("write");
  if (!files.view.empty()) write_page(builder, files.view, report, outputs);
  session.finished("page");
  if (!files.picture.empty()) write_picture(builder.page, {}, files.picture, report, session);
  write_report(files.report.string(), report, session);
  write_report(outputs, report, session);
  say_written(session, files.core.string(), files.report.string(), result.core, shape);
  session.say(fmt::format("{}: {}, {}; topology as that of the shape; {}; also {} and {}", files.skeleton.string(),
                          cells_text(pipeline::counts_of(result.axis.skeleton.skeleton.complex), plane),
                          base::counted(result.axis.graph.branches.size(), "branch", "branches"),
                          share_text(*result.axis.skeleton.reconstructed, plane), files.swc.string(),
                          files.csv.string()));
  if (plane)
    session.say(fmt::format("{} and {}: the branches as lines with their measures", files.geojson.string(),
                            files.svg.string()));
  say_sheets(result, files.parts, session);
  say_points(result.axis.graph, session);
  say_little(result, session);
  if (!files.picture.empty()) session.say(fmt::format("{}: a picture of the skeleton", files.picture.string()));
  if (!files.view.empty())
    session.say(fmt::format("{}: the interactive page; open it in a browser", files.view.string()));
  return 0;
}

}  // namespace

Action add_run(CLI::App& app) {
  auto o = std::make_shared<RunProgram>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->run.axis);
  add_burn_options(app, o->run.burning, false);
  add_skeleton_options(app, o->run.skeleton, o->graph);
  app.add_flag("--extend", o->graph.graph.extend,
               "Draw free ends out in a straight line to the boundary of the shape (of its voxels or pixels)")
      ->group("Skeleton");
  add_parsed(
      app, "--narrower",
      "Branches only where the shape is narrower than this; of images and polygons skeleton.geojson and "
      "skeleton.svg hold the rest as polygons: a fraction of the longest side, 12vox, 3.5abs",
      [o](const std::string&, const std::string& text) { o->run.narrower = pipeline::parse_length(text, "narrower"); })
      ->type_name("LENGTH")
      ->group("Skeleton");
  add_page_options(app, o->max_triangles);
  app.add_flag("--no-view", o->no_view, "Do not write view.html, the interactive page")->group("Page");
  app.add_flag("--no-picture", o->no_picture, "Do not write picture.png, a picture of the skeleton")->group("Page");
  app.add_option(
         "-o,--output", o->folder,
         "Folder for core.vtp, skeleton.vtp, skeleton.swc, branches.csv, parts.csv, report.json, picture.png and "
         "view.html, of images and polygons also skeleton.geojson and skeleton.svg; created if absent")
      ->type_name("DIR")
      ->required();
  return [o](Session& session) { return run_pipeline(*o, session); };
}

}  // namespace quench::program
