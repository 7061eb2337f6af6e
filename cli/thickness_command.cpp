// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/solid_stages.h"
#include "quench/tree.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {
namespace {

struct ThicknessProgram {
  ShapeOptions shape;
  std::string output, surface, csv, histogram, png, page, mask, axis;
  std::string balls = "all";
  std::optional<pipeline::Length> correction, tolerance, bin;
  std::size_t max_triangles = kPageTriangles;

  bool of_surface() const { return !(surface + png + page).empty(); }
  bool of_volume() const { return !of_surface() || !(output + csv + histogram).empty(); }
};

void check_thickness(const ThicknessProgram& o, Session& session) {
  std::vector<std::filesystem::path> inputs{o.shape.file};
  for (const std::string& file : {o.mask, o.axis})
    if (!file.empty()) {
      check_exists(file);
      inputs.emplace_back(file);
    }
  const std::pair<const char*, const std::string&> outputs[] = {{"-o", o.output}, {"--surface", o.surface},
                                                                {"--csv", o.csv}, {"--histogram", o.histogram},
                                                                {"--png", o.png}, {"--page", o.page}};
  for (const auto& [option, file] : outputs)
    if (!file.empty()) session.check_output(file, inputs, option);
  check_distinct({o.output, o.surface, o.csv, o.histogram, o.png, o.page});
  session.check_report(inputs);
  if (!o.output.empty()) io::check_value_format(o.output);
  if (!o.surface.empty()) {
    const std::string extension = extension_of(o.surface);
    if (extension != ".ply" && extension != ".vtp" && extension != ".obj" && extension != ".csv")
      throw Error(ErrorCode::usage, fmt::format("cannot write '{}': surfaces with thickness are written as .ply, .vtp, "
                                                ".csv or .obj (which has the surface alone)",
                                                o.surface));
  }
  for (const auto& [option, file, extension] :
       {std::tuple{"--csv", o.csv, ".csv"}, {"--histogram", o.histogram, ".csv"}, {"--png", o.png, ".png"}})
    if (!file.empty() && extension_of(file) != extension)
      throw Error(ErrorCode::usage, fmt::format("{} '{}' does not end in {}", option, file, extension));
  if (!o.page.empty()) pipeline::require_page_program();
  if (o.of_surface() && o.shape.how.foreground.invert)
    throw Error(ErrorCode::usage, "--surface, --png and --page show the thickness of the shape; without --invert");
}

/// The voxels of a mask that are not 0.
VoxelShape mask_of(const std::string& file, Context* context) {
  pipeline::ShapeOptions not_zero;
  not_zero.foreground.label = 0;
  not_zero.foreground.invert = true;
  not_zero.surface = SurfaceKind::voxels;
  not_zero.core_follows = false;
  return pipeline::load_shape(file, not_zero, context).shape;
}

Json distribution_section(const ThicknessDistribution& d) {
  Json section = {{"mean", d.mean()},
                  {"sd", d.deviation()},
                  {"min", d.least()},
                  {"max", d.largest()},
                  {"percentiles", Json::object()}};
  for (const int p : {1, 5, 10, 25, 50, 75, 90, 95, 99})
    section["percentiles"][std::to_string(p)] = d.percentile(p / 100.0);
  section["bin_width"] = d.bin_width();
  section["histogram"] = d.bins();
  return section;
}

std::string distribution_text(const ThicknessDistribution& d, const std::string& unit) {
  const std::string in = unit.empty() ? "" : " " + unit;
  return fmt::format("mean {:.5g}{} (sd {:.4g}), median {:.5g}, 5 to 95 %: {:.4g} to {:.4g}, max {:.5g}", d.mean(), in,
                     d.deviation(), d.percentile(0.5), d.percentile(0.05), d.percentile(0.95), d.largest());
}

/// The axis whose balls are taken, and what is added to its radii.
std::pair<MedialAxis, double> balls_of(const ThicknessProgram& o, const pipeline::LoadedShape& shape, Json& report,
                                       Session& session) {
  MedialAxis axis;
  double correction = 0;
  if (o.axis.empty()) {
    axis = pipeline::whole_core(shape, &session.context);
    correction = thickness_correction(axis);
  } else {
    pipeline::LoadedAxis loaded =
        pipeline::axis_of(pipeline::read_surface(o.axis, &session.context), o.axis, &session.context);
    correction = loaded.voxel_core ? thickness_correction(loaded.axis) : 0;
    axis = std::move(loaded.axis);
    report["input"]["axis"] = o.axis;
  }
  if (o.correction) correction = shape.scale().resolve(*o.correction, "correction");
  report["core"] = {{"vertices", axis.points.size()}, {"edges", axis.complex.edges.size()}};
  return {std::move(axis), correction};
}

void measure_volume(const ThicknessProgram& o, const pipeline::LoadedShape& shape, Json& report, Session& session) {
  Context* context = &session.context;
  const bool plane = shape.shape.grid().is_plane();
  std::optional<VoxelShape> mask;
  if (!o.mask.empty()) mask = mask_of(o.mask, context);
  const std::pair<MedialAxis, double> balls = balls_of(o, shape, report, session);
  const MedialAxis& axis = balls.first;
  const double correction = balls.second;
  ThicknessOptions options;
  options.between = o.balls == "all";
  options.correction = correction;
  options.mask = mask ? &*mask : nullptr;
  if (o.bin) options.bin_width = shape.scale().resolve(*o.bin, "bin");
  ThicknessReport found;
  if (o.output.empty()) {
    found = local_thickness(shape.shape, axis, options, nullptr, context);
  } else {
    const auto slices = [&](const auto& take) {
      found = local_thickness(
          shape.shape, axis, options, [&](std::int64_t, std::span<const float> slice) { take(slice); }, context);
    };
    io::write_values(o.output, shape.shape.grid(), slices, shape.coordinates, context);
  }
  if (!o.csv.empty()) io::write_table(o.csv, pipeline::summary_of(found.distribution, shape.coordinates));
  if (!o.histogram.empty()) io::write_table(o.histogram, pipeline::histogram_of(found.distribution, shape.coordinates));
  Json section = {{"voxels", found.voxels}, {"uncovered", found.uncovered}};
  section.update(distribution_section(found.distribution));
  report["thickness"] = section;
  report["parameters"]["balls"] = o.balls;
  report["parameters"]["correction"] = correction;
  const char* word = plane ? "pixel" : "voxel";
  session.say(fmt::format("{}: {}, {}", o.output.empty() ? "thickness" : o.output, base::counted(found.voxels, word),
                          distribution_text(found.distribution, shape.coordinates.units)));
  if (correction > 0)
    session.say(
        fmt::format("note: radii are those to the corners of voxels and {:.4g} more, half a voxel; --correction 0 "
                    "leaves them, as is right for boxes along the axes",
                    correction));
  if (found.uncovered > 0)
    session.say(fmt::format("note: {} in no ball of '{}' and 0",
                            base::counted(found.uncovered, std::string(word) + " is", std::string(word) + "s are"),
                            o.axis));
}

void measure_surface(const ThicknessProgram& o, pipeline::LoadedShape& shape, Json& report, io::OutputGroup& outputs,
                     Session& session) {
  Context* context = &session.context;
  std::optional<double> tolerance;
  if (o.tolerance) tolerance = shape.scale().resolve(*o.tolerance, "tolerance");
  const pipeline::MeasuredSurface surface = pipeline::measured_surface(shape, tolerance, context);
  const SurfaceThickness& t = surface.thickness;
  report["surface"] = {{"points", t.thickness.size()},
                       {"nearest_ball", t.near},
                       {"tolerance", surface.tolerance},
                       {"correction", surface.correction}};
  report["surface"].update(distribution_section(surface.distribution));
  if (!o.surface.empty()) {
    io::write_record(o.surface, pipeline::surface_file(surface), {"thickness"});
    session.say(fmt::format("{}: {}, {}", o.surface, base::counted(t.thickness.size(), "vertex", "vertices"),
                            distribution_text(surface.distribution, shape.coordinates.units)));
  }
  if ((o.page + o.png).empty()) return;
  pipeline::PageBuilder builder(o.max_triangles);
  Page& page = builder.page;
  page.command = session.options.command;
  page.limit_name = "--max-triangles";
  page.title = pipeline::title_of(o.shape.file);
  page.files = {{"shape", o.shape.file}};
  const auto box = shape.shape.foreground_box();
  const auto corner = [&](const auto& c) {
    return shape.shape.grid().world(
        Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])));
  };
  builder.set_origin(corner(box.begin).cwiseMin(corner(box.end)), corner(box.begin).cwiseMax(corner(box.end)));
  builder.add_shape(shape);
  const std::vector<Vec3> points = surface_points(page);
  add_surface_measure(
      page, "thickness",
      surface_thickness(points, nullptr, surface.axis, {surface.tolerance, surface.correction}, context).thickness);
  builder.add_core(surface.axis, {}, false);
  page.state = "surface=thickness";
  if (!o.page.empty()) write_page(builder, o.page, report, outputs);
  if (!o.png.empty()) write_picture(page, {}, o.png, report, session);
}

int thickness(ThicknessProgram o, Session& session) {
  check_thickness(o, session);
  const bool of_mesh = io::kind_of(o.shape.file) == io::Kind::surface;
  const bool invert_mesh = of_mesh && o.shape.how.foreground.invert;
  if (of_mesh) o.shape.how.foreground.invert = false;
  o.shape.how.keep_mesh = o.of_surface();
  if (!o.of_surface()) o.shape.how.surface = SurfaceKind::voxels;  // nobody looks at it
  pipeline::LoadedShape shape = load_shape(o.shape, session);
  if (invert_mesh) shape = pipeline::complement_of(shape);
  Json report = {{"input", input_section(o.shape, shape)},
                 {"parameters", shape.parameters.empty() ? Json::object() : Json::parse(shape.parameters)},
                 {"shape", shape_section(shape)}};
  io::OutputGroup outputs;
  if (o.of_volume()) measure_volume(o, shape, report, session);
  if (o.of_surface()) measure_surface(o, shape, report, outputs, session);
  session.finished("write");
  write_report(outputs, report, session);
  return 0;
}

}  // namespace

Action add_thickness(CLI::App& app) {
  auto o = std::make_shared<ThicknessProgram>();
  add_shape_options(app, o->shape);
  app.remove_option(app.get_option("--surface"));  // what the shape is a digitization of is known
  app.get_option("--invert")->description("The shape is all other voxels or pixels of the box: pores");
  app.add_option("-o,--output", o->output,
                 "The thickness at every voxel or pixel, 0 outside: .nrrd, .nii, .nii.gz, .tif or .npy")
      ->type_name("FILE");
  app.add_option("--surface", o->surface,
                 "The surface with the thickness at its vertices and the point across: .ply (coloured), .vtp, .csv")
      ->type_name("FILE");
  app.add_option("--csv", o->csv, "A table: number of voxels, mean, deviation, extremes, percentiles")
      ->type_name("FILE");
  app.add_option("--histogram", o->histogram, "A table: the voxels of each bin")->type_name("FILE");
  app.add_option("--png", o->png, "A picture of the surface, coloured by thickness")->type_name("FILE");
  app.add_option("--page", o->page, "An interactive page of the same (HTML)")->type_name("FILE");
  app.add_option("--mask", o->mask, "Write and count only voxels that are not 0 in this volume of the same size")
      ->type_name("FILE");
  const auto group = "Thickness";
  app.add_option("--axis", o->axis, "Take the balls of this medial axis, instead of those of the whole voxel core")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--balls", o->balls,
                 "'all' balls centred on the core: of its vertices and of the edges between; or those of 'vertices'")
      ->type_name("NAME")
      ->check(one_of({"all", "vertices"}))
      ->capture_default_str()
      ->group(group);
  add_length(app, "--correction", o->correction,
             "Added to every radius; auto: half a voxel, which corners of voxels lie inside of what they stand for")
      ->group(group);
  add_length(app, "--tolerance", o->tolerance,
             "Of the surface: how far a ball may be from a vertex that it touches; auto: half a voxel diagonal")
      ->group(group);
  add_length(app, "--bin", o->bin, "Width of the bins of the histogram")->group(group);
  add_page_options(app, o->max_triangles);
  return [o](Session& session) { return thickness(*o, session); };
}

}  // namespace quench::program
