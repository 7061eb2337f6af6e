// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "base/text.h"
#include "burn_pipeline.h"
#include "core_pipeline.h"
#include "option_checks.h"
#include "page_pipeline.h"
#include "page_program.h"
#include "picture.h"
#include "program.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/voxelize.h"
#include "skeleton_pipeline.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  ShapeOptions shape;
  BurnPipelineOptions burn;
  SkeletonPipelineOptions skeleton;
  PageOptions page;
  std::string lambda, layer, color, camera, state;
  bool dark = false;
  std::string output, png, size = "1600x1000";
};

Picture picture_of(const Options& o) {
  Picture picture;
  const std::vector<double> size = numbers_in(o.size, 'x');
  const auto good = [](double x) { return x >= 16 && x <= 8192 && x == std::floor(x); };
  if (size.size() != 2 || !good(size[0]) || !good(size[1]))
    throw Error(ErrorCode::usage, fmt::format("--size '{}' is not WIDTHxHEIGHT in pixels, 16 to 8192 each", o.size));
  picture.width = static_cast<int>(size[0]);
  picture.height = static_cast<int>(size[1]);
  return picture;
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
  require_page_program();
  if (!o.camera.empty() && numbers_in(o.camera, ',').size() != 9)
    throw Error(
        ErrorCode::usage,
        fmt::format("--camera '{}' is not nine numbers px,py,pz,tx,ty,tz,ux,uy,uz: position, target, up", o.camera));
  if (extension_of(o.output) == ".png")
    throw Error(ErrorCode::usage, fmt::format("-o is the page, in HTML; for a picture give --png {}", o.output));
  if (!o.png.empty() && !(extension_of(o.png) == ".png"))
    throw Error(ErrorCode::usage, fmt::format("--png writes PNG; name '{}' .png", o.png));
  picture_of(o);
  if (!o.lambda.empty()) parse_length(o.lambda, "--lambda");
  check_burn_options(o.burn);
  check_skeleton_options(o.skeleton);
  if (o.shape.file.empty() &&
      (o.shape.foreground.threshold || o.shape.foreground.label || o.shape.resolution_given || o.shape.fill_given))
    throw Error(ErrorCode::usage,
                "--threshold, --label, --resolution and --fill say how --shape is read; give --shape too");
  std::error_code ignored;
  for (const std::string& file : o.files)
    if (!fs::exists(file, ignored)) throw Error(ErrorCode::failed, fmt::format("'{}' does not exist", file));
  if (!o.shape.file.empty()) check_shape_options(o.shape);
}

[[noreturn]] void refuse_shape(const std::string& file) {
  throw Error(ErrorCode::input,
              fmt::format("'{0}' is a shape, not a medial axis; 'quench run {0} -o {1}' computes one and writes its "
                          "page, {1}/view.html",
                          file, title_of(file)));
}

// A surface without any measure that encloses something is a shape.
bool is_closed_mesh(const Record& data) {
  if (data.poly_count() == 0 || !data.lines.empty() || find_array(data.point_data, "radius")) return false;
  const SurfaceTopology surface = surface_topology(to_triangle_mesh(data));
  return surface.manifold && surface.boundary_edges == 0;
}

// A medial axis with the levels of a core, or one that was burned: what there is a family of skeletons of.
bool is_axis(const Record& data) {
  if (!find_array(data.point_data, "radius")) return false;
  const std::string stage = field_text(data, "stage").value_or("");
  return stage == "core" || (stage.empty() && field_number(data, "omega"));
}

void add_axis(const Options& o, const std::string& file, Record&& data, PageBuilder& builder,
              nlohmann::ordered_json& report, std::string& lambda_state, Session& session) {
  Page& page = builder.page;
  AxisOptions axis_options;
  axis_options.file = file;
  LoadedAxis loaded = make_axis(axis_options, std::move(data), session);
  if (page.side == 0 || field_number(loaded.data, "longest_side")) page.side = loaded.longest_side;
  if (loaded.voxel > 0) page.voxel = loaded.voxel;
  if (page.unit.empty()) page.unit = loaded.coordinates.units;
  const auto resolve = [&](const std::string& text, const std::string& option) { return loaded.resolve(text, option); };
  page.theta2 = resolve(o.skeleton.theta2, "--theta2");
  page.theta1 = resolve(o.skeleton.theta1, "--theta1");
  if (!o.lambda.empty()) lambda_state = fmt::format("{}", static_cast<float>(resolve(o.lambda, "--lambda")));
  page.lambda = field_number(loaded.data, "lambda");
  BurnPipelineOptions burn_options = o.burn;
  take_burn_parameters(burn_options, loaded.data);
  Burning burning = compute_burning(loaded.axis, loaded.voxel_core, burn_options, true, resolve, report, session);
  add_burning(loaded.data, burning);
  page.burning = burning.options;
  if (take_levels(loaded.axis, loaded.data)) builder.add_core(loaded.axis, loaded.data.point_data, true);
  session.finished("page");
  const double finest = loaded.voxel > 0 ? loaded.voxel : burning.options.omega;
  const CheckedSkeleton result = compute_skeleton(loaded.axis, std::move(burning), o.skeleton, finest, resolve, report,
                                                  session, [&](const SkeletonFamily& family) {
                                                    builder.add_skeleton(family);
                                                    session.finished("page");
                                                  });
  if (!page.topology) page.topology = result.topology;
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
  app.add_option("--resolution", o->shape.resolution, "Of a --shape that is a mesh [default: what FILE says, else 256]")
      ->type_name("N")
      ->group(shape)
      ->each([o](const std::string& text) {
        parse_resolution(text);
        o->shape.resolution_given = true;
      });
  app.add_option("--fill", o->shape.fill,
                 "What is inside of a --shape that is a mesh: 'nonzero', 'evenodd', 'winding' or 'auto' [default: what "
                 "FILE says, else nonzero]")
      ->type_name("RULE")
      ->check(one_of({"nonzero", "evenodd", "winding", "auto"}))
      ->group(shape)
      ->each([o](const std::string&) { o->shape.fill_given = true; });
  add_threshold(app, o->shape.foreground.threshold,
                "--shape is a volume: its voxels of at least this value [default: what FILE says]")
      ->type_name("T")
      ->group(shape);
  add_label(app, o->shape.foreground.label,
            "--shape is a volume: its voxels of exactly this value [default: what FILE says]")
      ->type_name("K")
      ->group(shape);
  const auto start = "What the page starts with";
  app.add_option("--theta2", o->skeleton.theta2, "Skeleton: erosion thickness below which sheets go")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(start);
  app.add_option("--theta1", o->skeleton.theta1, "Skeleton: erosion thickness below which curves go")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(start);
  app.add_option("--lambda", o->lambda, "Core: radius below which cells go [default: that of FILE]")
      ->type_name("LENGTH")
      ->group(start);
  app.add_option("--layer", o->layer, "'skeleton', 'core' or 'still' (a file of another kind)")
      ->type_name("NAME")
      ->check(one_of({"skeleton", "core", "still"}))
      ->group(start);
  app.add_option("--color", o->color, "Array to colour by, e.g. radius, lambda, burn_time, erosion_thickness")
      ->type_name("ARRAY")
      ->group(start);
  app.add_option("--camera", o->camera, "Position, target and up: px,py,pz,tx,ty,tz,ux,uy,uz in world units")
      ->type_name("NUMBERS")
      ->group(start);
  app.add_flag("--dark", o->dark, "On a dark ground")->group(start);
  add_page_options(app, o->page);
  add_burn_options(app, o->burn);
  app.add_option("-o,--output", o->output, "The page [default: FILE with .html, unless there is --png]")
      ->type_name("FILE");
  app.add_option("--png", o->png, "A picture of the page instead, drawn by Chromium without a window")
      ->type_name("FILE")
      ->group("Picture");
  app.add_option("--size", o->size, "Of the picture, in pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->group("Picture");
  return [o](Session& session) {
    check_options(*o);
    const fs::path first = o->files.front();
    if (o->output.empty() && o->png.empty()) o->output = fs::path(first).replace_extension(".html").string();
    std::vector<fs::path> inputs(o->files.begin(), o->files.end());
    if (!o->shape.file.empty()) inputs.emplace_back(o->shape.file);
    if (!o->output.empty()) session.check_output(o->output, inputs);
    if (!o->png.empty()) session.check_output(o->png, inputs, "--png");
    if (!o->output.empty() && o->output == o->png)
      throw Error(ErrorCode::usage, fmt::format("two outputs are named '{}'; give them different names", o->png));
    const fs::path chromium = o->png.empty() ? fs::path() : find_chromium();
    std::optional<TemporaryFolder> folder;
    if (!o->png.empty()) folder.emplace();

    std::string axis_file, still_file;
    Record axis, still;
    for (const std::string& file : o->files) {
      if (io::kind_of(file) == io::Kind::volume) refuse_shape(file);
      Record data = read_axis_file(file, session);
      if (data.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' is empty", file));
      if (is_closed_mesh(data)) refuse_shape(file);
      const bool computed = is_axis(data);
      std::string& known = computed ? axis_file : still_file;
      if (!known.empty())
        throw Error(ErrorCode::usage,
                    fmt::format("a page shows one {} only; write one page of '{}' and one of '{}'",
                                computed ? "medial axis with its skeletons" : "other result", known, file));
      known = file;
      (computed ? axis : still) = std::move(data);
    }
    checkpoint(&session.context, "read", 1);

    PageBuilder builder(o->page, session);
    Page& page = builder.page;
    nlohmann::ordered_json report;
    report["input"] = {{"files", o->files}};
    if (!o->shape.file.empty()) report["input"]["shape"] = o->shape.file;
    page.title = title_of(first);
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (const Record* data : {&axis, &still})
      for (const Vec3& p : data->points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    if (!low.allFinite() || !high.allFinite())
      throw Error(ErrorCode::input, fmt::format("'{}' has coordinates that are not finite", first.string()));
    builder.set_origin(low, high);
    if (!o->shape.file.empty()) {
      take_parameters(o->shape, axis_file.empty() ? still : axis, axis_file.empty() ? still_file : axis_file);
      o->shape.keep_mesh = true;
      o->shape.core_follows = false;
      LoadedShape loaded = load_shape(o->shape, session);
      builder.add_shape(loaded, o->shape);
      page.files.emplace_back("shape", o->shape.file);
      session.finished("page");
    }
    std::string lambda_state;
    if (!still_file.empty()) {
      drop_unusable_fields(still, still_file, &session.context);
      page.files.emplace_back(field_text(still, "stage") == "skeleton" ? "skeleton" : "still", still_file);
      if (page.unit.empty()) page.unit = field_text(still, "units").value_or("");
      if (page.side == 0) page.side = field_number(still, "longest_side").value_or((high - low).maxCoeff());
      builder.add_still(still);
      session.finished("page");
    }
    if (!axis_file.empty()) {
      page.files.emplace_back("core", axis_file);
      add_axis(*o, axis_file, std::move(axis), builder, report, lambda_state, session);
    }
    if (!(page.side > 0)) page.side = std::max((high - low).maxCoeff(), 1e-30);

    const bool skeleton = !axis_file.empty();
    if (!o->layer.empty() && !page.find(o->layer + "/points"))
      throw Error(ErrorCode::usage, fmt::format("there is no layer '{}' in this page", o->layer));
    const std::string layer = !o->layer.empty() ? o->layer : skeleton ? "skeleton" : "still";
    if (!o->color.empty() && o->color != "none" && !page.find(layer + "/point/" + o->color)) {
      std::string names;
      for (const PageArray& array : page.arrays)
        if (const std::string prefix = layer + "/point/"; array.name.starts_with(prefix))
          names += (names.empty() ? "" : ", ") + array.name.substr(prefix.size());
      throw Error(ErrorCode::usage, fmt::format("there is no array '{}' to colour the layer '{}' by; there are {}",
                                                o->color, layer, names));
    }
    const auto add = [&](const char* name, const std::string& value) {
      if (!value.empty()) page.state += fmt::format("{}{}={}", page.state.empty() ? "" : "&", name, in_address(value));
    };
    add("layer", o->layer);
    add("color", o->color);
    add("lambda", lambda_state);
    add("camera", o->camera);
    if (o->dark) add("dark", "1");

    if (folder) write_page(folder->path / "page.html", page, page_program());
    io::OutputGroup outputs;
    if (!o->output.empty()) {
      builder.write(o->output, report, outputs);
      session.finished("page");
    }
    if (!o->png.empty()) {
      session.finished("page");
      Picture picture = picture_of(*o);
      picture.state = page.state + (page.state.empty() ? "" : "&") + "ui=0";
      take_picture(chromium, folder->path / "page.html", o->png, picture, session);
      session.finished("picture");
    }
    write_report(outputs, report, session);
    for (const std::string& note : page.notes) session.say("note: " + note);
    for (const std::string& file : {o->output, o->png})
      if (!file.empty()) {
        std::error_code ignored;
        session.say(fmt::format("{}: {}, {}; {:.1f} s", file,
                                base::bytes_text(static_cast<std::int64_t>(fs::file_size(file, ignored))),
                                base::counted(builder.triangles(), "triangle"), session.total_seconds()));
      }
    return 0;
  };
}

}  // namespace quench::program
