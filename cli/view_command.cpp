// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "axis_input.h"
#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/picture.h"
#include "quench/simplify.h"
#include "report.h"
#include "shape_input.h"
#include "units.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  ShapeOptions shape;
  pipeline::BurningOptions burning;
  pipeline::SkeletonOptions skeleton;
  pipeline::Pruning pruning;  ///< where the page starts, if it says a threshold
  std::size_t max_triangles = kPageTriangles;
  std::string layer, color, camera;
  std::size_t vertices = 0;  ///< of the layer `simple`; 0: as the page starts
  bool dark = false, axes = false, no_caption = false;
  std::string output, png, size = "1600x1000";
};

PictureOptions picture_of(const Options& o) {
  const std::vector<double> size = numbers_in(o.size, 'x');
  const auto good = [](double x) { return x >= 16 && x <= 8192 && x == std::floor(x); };
  if (size.size() != 2 || !good(size[0]) || !good(size[1]))
    throw Error(ErrorCode::usage, fmt::format("--size '{}' is not WIDTHxHEIGHT in pixels, 16 to 8192 each", o.size));
  return {static_cast<int>(size[0]), static_cast<int>(size[1]), !o.no_caption, o.axes};
}

// A value in the address of the page: what is not a letter, a digit or one of -._~, is written as its number.
std::string in_address(const std::string& value) {
  std::string text;
  for (const char c : value) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~,").find(c) != std::string_view::npos;
    text += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return text;
}

void check_options(const Options& o) {
  if (!o.output.empty()) pipeline::require_page_program();
  if (!o.camera.empty() && numbers_in(o.camera, ',').size() != 9)
    throw Error(
        ErrorCode::usage,
        fmt::format("--camera '{}' is not nine numbers px,py,pz,tx,ty,tz,ux,uy,uz: position, target, up", o.camera));
  if (extension_of(o.output) == ".png")
    throw Error(ErrorCode::usage, fmt::format("-o is the page, in HTML; for a picture give --png {}", o.output));
  picture_of(o);
  const pipeline::ShapeOptions& how = o.shape.how;
  if (o.shape.file.empty() && (has_volume_options(how) || how.resolution || how.fill || how.topology))
    throw Error(ErrorCode::usage,
                "--threshold, --label, --resolution, --fill, --topology and the like say how --shape is read; give "
                "--shape too");
  for (const std::string& file : o.files) check_exists(file);
  if (!o.shape.file.empty()) check_shape_options(o.shape);
}

[[noreturn]] void refuse_shape(const std::string& file) {
  throw Error(ErrorCode::input,
              fmt::format("'{0}' is a shape, not a medial axis; 'quench run {0} -o {1}' computes one and writes its "
                          "page, {1}/view.html",
                          file, pipeline::title_of(file)));
}

// A medial axis with the levels of a core, or one that was burned: what there is a family of skeletons of.
bool is_axis(const Record& data) {
  if (!find_array(data.point_data, "radius")) return false;
  const std::string stage = pipeline::field_text(data, "stage").value_or("");
  return stage == "core" || (stage.empty() && pipeline::field_number(data, "omega"));
}

// --------------------------------------------------------------------------------------------------------------- plan

/// What a page is made of, read and checked.
struct Plan {
  std::string axis_file, still_file;  ///< empty: there is none
  Record axis, still;
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);  ///< box around both
};

void check_outputs(const Options& o, const Session& session) {
  std::vector<fs::path> inputs(o.files.begin(), o.files.end());
  if (!o.shape.file.empty()) inputs.emplace_back(o.shape.file);
  if (!o.output.empty()) session.check_output(o.output, inputs);
  if (!o.png.empty()) session.check_output(o.png, inputs, "--png");
  if (!o.png.empty() && extension_of(o.png) != ".png")
    throw Error(ErrorCode::usage, fmt::format("--png writes PNG; name '{}' .png", o.png));
  check_distinct({o.output, o.png});
}

Plan plan_page(const Options& o, Session& session) {
  Plan plan;
  for (const std::string& file : o.files) {
    if (io::kind_of(file) == io::Kind::volume) refuse_shape(file);
    Record data = pipeline::read_surface(file, &session.context);
    if (data.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' is empty", file));
    if (is_closed_mesh(data)) refuse_shape(file);
    const bool computed = is_axis(data);
    std::string& known = computed ? plan.axis_file : plan.still_file;
    if (!known.empty())
      throw Error(ErrorCode::usage,
                  fmt::format("a page shows one {} only; write one page of '{}' and one of '{}'",
                              computed ? "medial axis with its skeletons" : "other result", known, file));
    known = file;
    take_units(data, file, session);
    (computed ? plan.axis : plan.still) = std::move(data);
  }
  checkpoint(&session.context, "read", 1);
  for (const Record* data : {&plan.axis, &plan.still})
    for (const Vec3& p : data->points) {
      plan.low = plan.low.cwiseMin(p);
      plan.high = plan.high.cwiseMax(p);
    }
  if (!plan.low.allFinite() || !plan.high.allFinite())
    throw Error(ErrorCode::input, fmt::format("'{}' has coordinates that are not finite", o.files.front()));
  return plan;
}

// -------------------------------------------------------------------------------------------------------------- build

pipeline::LoadedShape add_shape(const Options& o, const Plan& plan, pipeline::PageBuilder& builder, Session& session) {
  ShapeOptions options = o.shape;
  const bool of_axis = !plan.axis_file.empty();
  take_recorded(options, of_axis ? plan.axis : plan.still, of_axis ? plan.axis_file : plan.still_file);
  options.how.keep_mesh = true;
  options.how.core_follows = false;
  options.how.surface = SurfaceKind::voxels;  // the axis is fitted already
  pipeline::LoadedShape shape = load_shape(options, session);
  builder.add_shape(shape);
  builder.page.files.emplace_back("shape", o.shape.file);
  session.finished("page");
  return shape;
}

/// Of voxels or pixels; zero where the file does not say it.
Vec3 spacing_of(const Record& data) {
  const DataArray* spacing = find_array(data.field_data, "spacing");
  const std::vector<double> numbers =
      spacing && spacing->size() == 3 ? spacing->numbers() : std::vector<double>(3, 0.0);
  return {numbers[0], numbers[1], numbers[2]};
}

void add_still(Plan& plan, pipeline::PageBuilder& builder, Session& session) {
  Page& page = builder.page;
  drop_unusable_fields(plan.still, plan.still_file, &session.context);
  const bool skeleton = pipeline::field_text(plan.still, "stage") == "skeleton";
  page.files.emplace_back(skeleton ? "skeleton" : "still", plan.still_file);
  if (page.unit.empty()) page.unit = pipeline::field_text(plan.still, "units").value_or("");
  if (page.side == 0)
    page.side = pipeline::field_number(plan.still, "longest_side").value_or((plan.high - plan.low).maxCoeff());
  if (pipeline::field_number(plan.still, "dimension") == 2)
    builder.set_plane(spacing_of(plan.still), pipeline::field_text(plan.still, "y_axis") == "down");
  builder.add_still(plan.still);
  session.finished("page");
}

/// The axis with all its skeletons. `shape`: where it was given. `threshold`: where the page starts, for its state.
void add_axis(const Options& o, Plan& plan, const std::optional<pipeline::LoadedShape>& shape,
              pipeline::PageBuilder& builder, Json& report, std::string& threshold, Session& session) {
  Context* context = &session.context;
  Page& page = builder.page;
  page.files.emplace_back("core", plan.axis_file);
  pipeline::LoadedAxis loaded = pipeline::axis_of(std::move(plan.axis), plan.axis_file, context);
  if (const bool plane = loaded.axis.grid.is_plane(); shape && shape->shape.grid().is_plane() != plane)
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is of the plane, '{}' is not: the one is not the medial axis of the other",
                            plane ? plan.axis_file : o.shape.file, plane ? o.shape.file : plan.axis_file));
  const pipeline::Scale& scale = loaded.scale;
  if (page.side == 0 || pipeline::field_number(loaded.data, "longest_side")) page.side = scale.longest_side;
  if (scale.voxel > 0) page.voxel = scale.voxel;
  if (page.unit.empty()) page.unit = loaded.coordinates.units;
  if (loaded.axis.grid.is_plane()) builder.set_plane(loaded.spacing, loaded.coordinates.y_down);
  if (o.pruning.threshold)
    threshold = fmt::format("{}", static_cast<float>(scale.resolve(*o.pruning.threshold, o.pruning.measure)));

  pipeline::RunOptions options;
  options.burning = o.burning;
  options.skeleton = o.skeleton;
  options.page = &builder;
  options.measures = true;
  if (loaded.voxel_core) options.graph.voxel = loaded.spacing;
  if (shape && loaded.voxel_core) options.graph.shape = &shape->shape;
  pipeline::take_recorded(options.burning, loaded.data);
  options.on_burned = [&](const pipeline::BurnFigures& burned) {
    say_burned(burned, loaded.axis.points.size(), session);
  };
  if (shape) builder.add_thickness(loaded.axis, context);
  if (!loaded.axis.grid.is_plane()) {
    const bool known = shape && loaded.voxel_core;  // else the surface it is fitted to is not at hand
    builder.add_meshes(loaded.axis, known ? boundary_points(shape->shape) : boundary_points(loaded.axis), known,
                       context);
  }
  take_levels(loaded.axis, loaded.data);  // where they are not known the axis itself is not shown
  const pipeline::AxisRun run = pipeline::run_axis(loaded.axis, std::move(loaded.data), loaded.voxel_core,
                                                   topology(loaded.axis.complex), scale, options, context);
  add_axis_sections(report, run);
  if (!page.topology) page.topology = run.skeleton.topology;
}

/// Refuses to start with a pruning by a measure that the page does not have.
void check_pruning(const pipeline::Pruning& pruning, const Page& page) {
  const auto is_its = [&](const PageMeasure& measure) { return measure.name == pruning.measure; };
  if (!pruning.threshold || std::ranges::any_of(page.measures, is_its)) return;
  std::string names;
  for (const PageMeasure& measure : page.measures) names += (names.empty() ? "" : ", ") + measure.name;
  throw Error(ErrorCode::usage,
              names.empty()
                  ? fmt::format("--{} prunes a medial axis with its levels, as 'quench core' and 'quench run' "
                                "write it, and there is none in this page",
                                pruning.measure)
                  : fmt::format("--{0} prunes by levels that this page does not have; it has those of {1} "
                                "('quench core --{0} ...' makes an axis with them)",
                                pruning.measure, names));
}

/// The colour of the surface by its local thickness.
constexpr std::string_view kThickness = "thickness";

bool is_column_of_sheets(const Page& page, const std::string& color) {
  return std::ranges::any_of(page.columns, [&](const PageColumn& column) {
    return column.table == "sheets" && column.words.empty() && "sheets/" + column.name == color;
  });
}

/// What the page starts with, in the form of its address; refuses what the page does not have.
std::string state_of(const Options& o, const Page& page, bool has_axis, const std::string& threshold) {
  check_pruning(o.pruning, page);
  if (!o.layer.empty() && !page.find(o.layer + "/points"))
    throw Error(ErrorCode::usage, fmt::format("there is no layer '{}' in this page", o.layer));
  if (o.vertices > 0 && o.layer != "simple")
    throw Error(ErrorCode::usage, "--vertices is of the medial meshes; give --layer simple, too");
  const std::string layer = !o.layer.empty() ? o.layer : has_axis ? "skeleton" : "still";
  const std::string prefix = layer + "/point/";
  const bool of_surface = o.color == kThickness && !page.find(prefix + o.color);
  if (of_surface && !page.find("shape/point/thickness"))
    throw Error(ErrorCode::usage,
                "the surface of a shape is coloured by thickness; give a medial axis of it and --shape SHAPE");
  const bool of_parts =
      layer == "skeleton" && (o.color == "sheet" || o.color == "branch" || is_column_of_sheets(page, o.color));
  if (!o.color.empty() && o.color != "none" && !of_parts && !of_surface && !page.find(prefix + o.color)) {
    std::string names;
    for (const PageArray& array : page.arrays)
      if (array.name.starts_with(prefix)) names += (names.empty() ? "" : ", ") + array.name.substr(prefix.size());
    for (const PageColumn& column : page.columns)
      if (layer == "skeleton" && is_column_of_sheets(page, "sheets/" + column.name)) names += ", sheets/" + column.name;
    throw Error(ErrorCode::usage,
                fmt::format("there is no array '{}' to colour the layer '{}' by; there are {}", o.color, layer, names));
  }
  std::string state;
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) state += fmt::format("{}{}={}", state.empty() ? "" : "&", name, in_address(value));
  };
  add("layer", o.layer);
  if (of_surface) {
    add("surface", o.color);
    add("shapeOpacity", "1");
  } else {
    add("color", o.color);
  }
  if (o.vertices > 0) add("vertices", std::to_string(o.vertices));
  if (!threshold.empty()) add("measure", std::string(o.pruning.measure));
  add("threshold", threshold);
  add("camera", o.camera);
  if (o.dark) add("dark", "1");
  return state;
}

pipeline::PageBuilder build_page(const Options& o, Plan& plan, Json& report, Session& session) {
  pipeline::PageBuilder builder(o.max_triangles);
  Page& page = builder.page;
  page.command = session.options.command;
  page.limit_name = "--max-triangles";
  page.title = pipeline::title_of(o.files.front());
  builder.set_origin(plan.low, plan.high);
  std::string threshold;
  std::optional<pipeline::LoadedShape> shape;
  if (!o.shape.file.empty()) shape = add_shape(o, plan, builder, session);
  if (!plan.still_file.empty()) add_still(plan, builder, session);
  if (!plan.axis_file.empty()) add_axis(o, plan, shape, builder, report, threshold, session);
  if (!(page.side > 0)) page.side = std::max((plan.high - plan.low).maxCoeff(), 1e-30);
  page.state = state_of(o, page, !plan.axis_file.empty(), threshold);
  return builder;
}

// -------------------------------------------------------------------------------------------------------------- write

void write_outputs(const Options& o, const pipeline::PageBuilder& builder, Json& report, Session& session) {
  io::OutputGroup outputs;
  if (!o.output.empty()) write_page(builder, o.output, report, outputs);
  session.finished("page");
  if (!o.png.empty()) write_picture(builder.page, picture_of(o), o.png, report, session);
  write_report(outputs, report, session);
  if (!builder.page.note.empty()) session.say("note: " + builder.page.note);
  for (const std::string& note : builder.page.notes) session.say("note: " + note);
  for (const std::string& file : {o.output, o.png})
    if (!file.empty()) {
      std::error_code ignored;
      session.say(fmt::format("{}: {}, {}; {:.1f} s", file,
                              base::bytes_text(static_cast<std::int64_t>(fs::file_size(file, ignored))),
                              base::counted(builder.triangles(), "triangle"), session.total_seconds()));
    }
}

int view(Options& o, Session& session) {
  if (o.output.empty() && o.png.empty()) o.output = fs::path(o.files.front()).replace_extension(".html").string();
  check_options(o);
  check_outputs(o, session);

  Plan plan = plan_page(o, session);
  Json report;
  report["input"] = {{"files", o.files}};
  if (!o.shape.file.empty()) report["input"]["shape"] = o.shape.file;
  const pipeline::PageBuilder builder = build_page(o, plan, report, session);
  write_outputs(o, builder, report, session);
  return 0;
}

}  // namespace

Action add_view(CLI::App& app) {
  auto o = std::make_shared<Options>();
  app.add_option("FILE", o->files,
                 "A medial axis of Quench (core.vtp, burned or not), shown with all its skeletons, and beside or "
                 "instead of it one other result: .vtp .ply .obj .off .ma")
      ->type_name("")
      ->required();
  const auto shape = "Shape";
  app.add_option("--shape", o->shape.file,
                 "The mesh or volume it is of: drawn around it; balls then show where they touch and how much of it "
                 "they fill")
      ->type_name("FILE")
      ->group(shape);
  add_resolution(app, o->shape, "Of a --shape that is a mesh [default: what FILE says, else 256]")->group(shape);
  add_fill(app, o->shape,
           "What is inside of a --shape that is a mesh: 'nonzero', 'evenodd', 'winding' or 'auto' [default: what "
           "FILE says, else nonzero]")
      ->group(shape);
  add_topology(app, o->shape, "Of a --shape that is a mesh: 'mesh' or 'voxels' [default: what FILE says, else mesh]")
      ->group(shape);
  add_volume_options(app, o->shape.how, "Of a --shape that is a volume, instead of what FILE says: ", shape);
  const auto start = "What the page starts with";
  add_length(app, "--theta2", o->skeleton.theta2, "Skeleton: erosion thickness below which sheets go")->group(start);
  add_theta1(app, o->skeleton, "Skeleton: erosion thickness, or radii of what they leave (0.5r), below which curves go")
      ->group(start);
  const auto add_pruning = [&](const char* name, std::string_view measure, const char* help) {
    return add_parsed(app, name, help,
                      [o, measure](const std::string&, const std::string& text) {
                        o->pruning = {measure, pipeline::parse_length(text, measure)};
                      })
        ->type_name("LENGTH")
        ->group(start);
  };
  CLI::Option* detail = add_pruning("--detail", kDetail, "Core: detail below which cells go [default: that of FILE]");
  add_pruning("--lambda", kLambda, "Core: radius below which cells go [default: that of FILE]")->excludes(detail);
  app.add_option(
         "--layer", o->layer,
         "'skeleton', 'core' (the medial axis), 'simple' (a medial mesh of some vertices) or 'still' (a file of "
         "another kind)")
      ->type_name("NAME")
      ->check(one_of({"skeleton", "core", "simple", "still"}))
      ->group(start);
  add_number(app, "--vertices", o->vertices, "Of the medial mesh [default: 200]", std::size_t{1},
             std::size_t{1'000'000'000})
      ->type_name("N")
      ->group(start);
  app.add_option("--color", o->color,
                 "Array to colour by, e.g. radius, detail, lambda, burn_time, erosion_thickness; 'sheet' or 'branch': "
                 "parts of the skeleton; 'sheets/area' and the like: columns of parts.csv; 'thickness': the surface of "
                 "--shape by its local thickness")
      ->type_name("ARRAY")
      ->group(start);
  app.add_option("--camera", o->camera, "Position, target and up: px,py,pz,tx,ty,tz,ux,uy,uz in world units")
      ->type_name("NUMBERS")
      ->group(start);
  app.add_flag("--dark", o->dark, "On a dark ground")->group(start);
  add_page_options(app, o->max_triangles);
  add_burn_options(app, o->burning, true);
  app.add_option("-o,--output", o->output, "The page [default: FILE with .html, unless there is --png]")
      ->type_name("FILE");
  app.add_option("--png", o->png, "A picture of what the page shows first instead")
      ->type_name("FILE")
      ->group("Picture");
  app.add_option("--size", o->size, "Of the picture, in pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->group("Picture");
  app.add_flag("--no-caption", o->no_caption, "Nothing is written into the picture")->group("Picture");
  app.add_flag("--axes", o->axes, "The directions of x, y and z are drawn into the picture")->group("Picture");
  return [o](Session& session) { return view(*o, session); };
}

}  // namespace quench::program
