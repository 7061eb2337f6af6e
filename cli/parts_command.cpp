// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/parts.h"
#include "quench/solid_stages.h"
#include "quench/tree.h"
#include "report.h"
#include "run_command.h"
#include "stage_options.h"
#include "units.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

constexpr std::array kMeshFormats{".vtp", ".vtu", ".ply", ".obj", ".stl"};
bool is_mesh_format(const std::string& extension) {
  return std::ranges::find(kMeshFormats, extension) != kMeshFormats.end();
}

/// The options of `quench parts`; of those of `quench run` the ones that lead to a skeleton.
struct PartsProgram : RunProgram {
  std::optional<pipeline::Length> remesh;
  bool whole = false;
  std::string format = "ply";
  std::size_t sheets = 100;  ///< that have files of their own
  std::string csv, seams, junctions;
};

/// What is written; empty names are not.
struct PartsFiles {
  explicit PartsFiles(const PartsProgram& o) {
    const fs::path output(o.folder);
    if (is_mesh_format(extension_of(output))) {
      all = output;
      sheet_csv = o.csv;
      seam_csv = o.seams;
      junction_csv = o.junctions;
      return;
    }
    in_folder = true;
    all = output / "parts.vtp";
    obj = output / "parts.obj";
    sheet_csv = output / "parts.csv";
    seam_csv = output / "seams.csv";
    junction_csv = output / "junctions.csv";
    report = output / "report.json";
    sheets = output / "sheets";
  }
  fs::path sheet(std::uint32_t number, const std::string& format) const {
    return sheets / fmt::format("sheet_{}.{}", number, format);
  }
  bool in_folder = false;
  fs::path all, obj, sheet_csv, seam_csv, junction_csv, report, sheets;
};

/// Whether a file of the folder of sheets is one of ours, of this run or an earlier one.
bool is_sheet_file(const fs::path& file) {
  const std::string stem = file.stem().string();
  constexpr std::string_view kName = "sheet_";
  std::uint32_t number = 0;
  const char* const end = stem.data() + stem.size();
  return stem.starts_with(kName) && is_mesh_format(file.extension().string()) &&
         std::from_chars(stem.data() + kName.size(), end, number).ptr == end;
}

void check_parts_options(const PartsProgram& o, const PartsFiles& files, const Session& session) {
  check_exists(o.shape.file);
  if (io::kind_of(o.shape.file) == io::Kind::polygons)
    throw Error(ErrorCode::usage, fmt::format("'{}' is of the plane, whose medial axis has no sheets; 'quench run' "
                                              "measures its branches",
                                              o.shape.file));
  const std::vector<fs::path> inputs{o.shape.file};
  session.check_report(inputs);
  if (!files.in_folder) {
    session.check_output(files.all, inputs);
    const std::pair<const char*, const std::string&> tables[] = {
        {"--csv", o.csv}, {"--seams", o.seams}, {"--junctions", o.junctions}};
    for (const auto& [option, file] : tables) {
      if (file.empty()) continue;
      session.check_output(file, inputs, option);
      if (extension_of(file) != ".csv")
        throw Error(ErrorCode::usage, fmt::format("{} '{}' does not end in .csv", option, file));
    }
    check_distinct({o.folder, o.csv, o.seams, o.junctions});
    return;
  }
  if (!(o.csv + o.seams + o.junctions).empty())
    throw Error(ErrorCode::usage,
                fmt::format("--csv, --seams and --junctions are tables beside a mesh, and '{}' is a folder, which has "
                            "them: parts.csv, seams.csv and junctions.csv",
                            o.folder));
  check_folder(o.folder);
  std::error_code error;
  if (!fs::exists(o.folder, error)) return;
  for (const fs::path& file : {files.all, files.obj, files.sheet_csv, files.seam_csv, files.junction_csv, files.report})
    session.check_output(file, inputs);
  for (fs::directory_iterator entry(files.sheets, error), end; !error && entry != end; entry.increment(error))
    if (is_sheet_file(entry->path())) session.check_output(entry->path(), inputs);
}

/// A medial axis or a skeleton: a file that may be one and has a radius per vertex.
std::optional<Record> axis_in(const std::string& file, Session& session) {
  constexpr std::array kExtensions{".vtp", ".ply", ".obj", ".ma"};
  if (std::ranges::find(kExtensions, extension_of(file)) == kExtensions.end()) return {};
  Record data = pipeline::read_surface(file, &session.context);
  if (!find_array(data.point_data, "radius") && extension_of(file) != ".ma") return {};
  return data;
}

void say_ignored_groups(const CLI::App& app, const std::vector<std::string>& groups, const std::string& why,
                        Session& session) {
  std::string names;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0 && std::ranges::find(groups, option->get_group()) != groups.end())
      names += (names.empty() ? "" : ", ") + option->get_name();
  if (!names.empty()) session.say(fmt::format("note: without effect: {}, as {}", names, why));
}

/// Parts, the record that says what they are of, and how coordinates are meant.
struct Found {
  pipeline::PartsRun run;
  Record from;
  Coordinates coordinates;
};

[[noreturn]] void refuse_plane_parts(const std::string& file) {
  throw Error(
      ErrorCode::usage,
      fmt::format("'{}' is of the plane, whose medial axis has no sheets; 'quench run' measures its branches", file));
}

Found parts_of_file(const PartsProgram& o, Record&& data, const CLI::App& app, Json& report, Session& session) {
  Context* context = &session.context;
  take_units(data, o.shape.file, session);
  pipeline::LoadedAxis loaded = pipeline::axis_of(std::move(data), o.shape.file, context);
  session.finished("read");
  if (loaded.axis.grid.is_plane()) refuse_plane_parts(o.shape.file);
  const bool skeleton = pipeline::field_text(loaded.data, "stage") == "skeleton";
  const CellComplex& c = loaded.axis.complex;
  report["input"] = {{"file", o.shape.file},       {"kind", skeleton ? "skeleton" : "medial axis"},
                     {"vertices", c.vertex_count}, {"edges", c.edges.size()},
                     {"faces", c.face_count()},    {"longest_side", loaded.scale.longest_side}};
  std::vector<std::string> groups{"Shape", "Medial axis"};
  if (skeleton || o.whole) groups.insert(groups.end(), {"Burning", "Skeleton"});
  say_ignored_groups(app, groups,
                     fmt::format("'{}' is a {} already{}", o.shape.file, skeleton ? "skeleton" : "medial axis",
                                 o.whole ? ", which is taken as it is" : ""),
                     session);
  Found found;
  found.coordinates = loaded.coordinates;
  if (skeleton || o.whole) {
    found.run = pipeline::run_parts(loaded, o.remesh, context);
    found.from = std::move(loaded.data);
    return found;
  }
  pipeline::BurningOptions burning = o.run.burning;
  pipeline::take_recorded(burning, loaded.data);
  pipeline::RunOptions options;
  options.burning = burning;
  options.skeleton = o.run.skeleton;
  options.graph = o.graph.graph;
  const Vec3 voxel = loaded.voxel_core ? loaded.spacing : Vec3(Vec3::Zero());
  options.graph.voxel = voxel;
  options.on_burned = [&](const pipeline::BurnFigures& burned) {
    say_burned(burned, loaded.axis.points.size(), session);
  };
  const pipeline::AxisRun axis = pipeline::run_axis(loaded.axis, std::move(loaded.data), loaded.voxel_core,
                                                    topology(loaded.axis.complex), loaded.scale, options, context);
  add_axis_sections(report, axis);
  found.run = pipeline::run_parts(axis.skeleton.skeleton, voxel, o.remesh, loaded.scale, context);
  found.from = pipeline::skeleton_file(axis.skeleton, axis.file);
  return found;
}

Found parts_of_shape(const PartsProgram& o, Json& report, Session& session) {
  if (o.whole)
    throw Error(
        ErrorCode::usage,
        fmt::format("--whole takes the sheets of a medial axis as they are, and '{}' is a shape", o.shape.file));
  pipeline::LoadedShape shape = load_shape(o.shape, session);
  if (shape.shape.grid().is_plane()) refuse_plane_parts(o.shape.file);
  pipeline::RunOptions options = o.run;
  options.graph = o.graph.graph;
  std::size_t vertices = 0;
  options.on_core = [&](const pipeline::CoreResult& core) {
    vertices = core.axis.points.size();
    say_core(shape, core, session);
  };
  options.on_burned = [&](const pipeline::BurnFigures& burned) { say_burned(burned, vertices, session); };
  const pipeline::RunResult result = pipeline::run(shape, options, &session.context);
  report["input"] = input_section(o.shape, shape);
  add_core_sections(report, shape, result.core);
  add_axis_sections(report, result.axis);
  Found found;
  found.coordinates = shape.coordinates;
  const Vec3 voxel = shape.surface ? Vec3(Vec3::Zero()) : shape.shape.grid().spacing;
  found.run = pipeline::run_parts(result.axis.skeleton.skeleton, voxel, o.remesh, shape.scale(), &session.context);
  found.from = pipeline::skeleton_file(result.axis.skeleton, result.axis.file);
  return found;
}

Json parts_section(const pipeline::PartsRun& run) {
  const Parts& parts = run.parts;
  double area = 0, volume = 0, least = 0, most = 0;
  for (const Sheet& sheet : parts.sheets) {
    least = area == 0 && volume == 0 ? sheet.min_thickness : std::min(least, sheet.min_thickness);
    most = std::max(most, sheet.max_thickness);
    area += sheet.area;
    volume += sheet.area * sheet.mean_thickness;
  }
  Json section = {{"sheets", parts.sheets.size()},          {"seams", parts.seams.size()},
                  {"junctions", parts.junctions.size()},    {"area", area},
                  {"triangles", run.mesh.triangles.size()}, {"more_radius", run.options.more_radius}};
  section["thickness"] = {{"mean", area > 0 ? Json(volume / area) : Json()},
                          {"min", parts.sheets.empty() ? Json() : Json(least)},
                          {"max", parts.sheets.empty() ? Json() : Json(most)}};
  return section;
}

/// Removes files of sheets that an earlier run left and this one has not written.
void remove_other_sheets(const PartsFiles& files, const std::vector<fs::path>& written) {
  std::error_code error;
  std::vector<fs::path> stale;
  for (fs::directory_iterator entry(files.sheets, error), end; !error && entry != end; entry.increment(error))
    if (is_sheet_file(entry->path()) && std::ranges::find(written, entry->path()) == written.end())
      stale.push_back(entry->path());
  for (const fs::path& file : stale) fs::remove(file, error);
}

int find_parts(const PartsProgram& o, const CLI::App& app, Session& session) {
  const PartsFiles files(o);
  check_parts_options(o, files, session);
  Json report;
  std::optional<Record> axis = axis_in(o.shape.file, session);
  const Found found =
      axis ? parts_of_file(o, std::move(*axis), app, report, session) : parts_of_shape(o, report, session);
  const pipeline::PartsRun& run = found.run;
  if (run.parts.sheets.empty())
    session.say("note: there are no sheets: all is curves; a smaller --theta2 keeps more sheets");
  Json& parameters = report["parameters"];
  if (parameters.is_null()) parameters = Json::object();
  parameters["theta2"] = pipeline::text_of(o.run.skeleton.theta2);
  parameters["theta1"] = pipeline::text_of(o.run.skeleton.theta1);
  parameters["tips"] = o.run.skeleton.full_tips ? "full" : "pruned";
  parameters["smooth"] = o.graph.graph.smooth;
  parameters["remesh"] = o.remesh ? Json(pipeline::text_of(*o.remesh)) : Json();
  report["parts"] = parts_section(run);

  const std::string& unit = found.coordinates.units;
  if (files.in_folder) create_folder(files.sheets.string());
  io::OutputGroup outputs;
  Record all = to_record(run.mesh, run.options);
  pipeline::add_parts_fields(all, found.from);
  const io::WriteOptions by_thickness{.quality_array = "thickness"};
  io::write_record(files.all, all, by_thickness);
  if (!files.obj.empty()) io::write_record(files.obj, all);
  if (!files.sheet_csv.empty()) io::write_table(files.sheet_csv, sheet_table(run.parts, unit));
  if (!files.seam_csv.empty()) io::write_table(files.seam_csv, seam_table(run.parts, unit));
  if (!files.junction_csv.empty()) io::write_table(files.junction_csv, junction_table(run.parts, unit));
  std::vector<fs::path> written;
  if (files.in_folder) {
    std::vector<Record> records = sheet_records(run.mesh, run.options);
    std::vector<std::uint32_t> order = run.parts.by_area();
    if (order.size() > o.sheets) order.resize(o.sheets);
    for (const std::uint32_t s : order) {
      pipeline::add_parts_fields(records[s], found.from);
      written.push_back(files.sheet(s, o.format));
      io::write_record(written.back(), records[s], by_thickness);
    }
    session.finished("write");
    write_report(files.report.string(), report, session);
  }
  session.finished("write");
  write_report(outputs, report, session);
  if (files.in_folder) remove_other_sheets(files, written);

  session.say(fmt::format("{}: {}, {}, {}; {:.1f} s", files.all.string(),
                          base::counted(run.parts.sheets.size(), "sheet"),
                          base::counted(run.parts.seams.size(), "seam"),
                          base::counted(run.parts.junctions.size(), "junction"), session.total_seconds()));
  if (files.in_folder)
    session.say(fmt::format(
        "{}, {} and {}: a row for each; {}: {} by themselves, {}", files.sheet_csv.string(), files.seam_csv.string(),
        files.junction_csv.string(), files.sheets.string(),
        written.size() == run.parts.sheets.size() ? "all sheets" : fmt::format("the {} largest sheets", written.size()),
        "." + o.format));
  return 0;
}

}  // namespace

Action add_parts(CLI::App& app) {
  auto o = std::make_shared<PartsProgram>();
  add_shape_options(app, o->shape);
  app.get_option("SHAPE")->description(
      "A medial axis or a skeleton (core.vtp or skeleton.vtp of 'quench run', or one of another program with radii), "
      "or a mesh or a volume, whose skeleton is made first");
  const auto group = "Parts";
  add_parsed(
      app, "--remesh",
      "Triangles with sides about this long: a fraction of the longest side (0.02 or 2%), 3vox, 0.5abs; seams stay "
      "common [default: the polygons of the medial axis in triangles]",
      [o](const std::string&, const std::string& text) { o->remesh = pipeline::parse_length(text, "remesh"); })
      ->type_name("LENGTH")
      ->group(group);
  app.add_flag("--whole", o->whole, "Of a medial axis: all of its sheets as they are, not those of a skeleton")
      ->group(group);
  app.add_option("--format", o->format, "Of the files of single sheets: ply, vtp, vtu, stl or obj")
      ->type_name("FORMAT")
      ->check(one_of({"ply", "vtp", "vtu", "stl", "obj"}))
      ->capture_default_str()
      ->group(group);
  add_number(app, "--sheets", o->sheets, "So many sheets, the largest, get a file of their own", std::size_t{0},
             std::size_t{1'000'000})
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  app.add_option("--csv", o->csv, "Beside a mesh: also write the table of sheets")->type_name("FILE")->group(group);
  app.add_option("--seams", o->seams, "Beside a mesh: also write the table of seams")->type_name("FILE")->group(group);
  app.add_option("--junctions", o->junctions, "Beside a mesh: also write the table of junctions")
      ->type_name("FILE")
      ->group(group);
  add_core_options(app, o->run.axis);
  add_burn_options(app, o->run.burning, true);
  add_skeleton_options(app, o->run.skeleton, o->graph);
  app.add_option("-o,--output", o->folder,
                 "Folder for parts.csv, seams.csv, junctions.csv, parts.vtp, parts.obj, report.json and a mesh of each "
                 "sheet; or one mesh of all sheets: .vtp .vtu .ply .obj .stl")
      ->type_name("DIR|FILE")
      ->required();
  return [o, &app](Session& session) { return find_parts(*o, app, session); };
}

}  // namespace quench::program
