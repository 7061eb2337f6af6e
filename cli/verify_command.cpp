// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/io.h"
#include "quench/measures.h"
#include "quench/verify.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {

namespace {

// The samples that the surface of a shape follows from; nothing where it does not, or where they are too many to hold.
std::optional<Volume> grey_values(const ShapeOptions& options, pipeline::LoadedShape& shape, Session& session) {
  constexpr std::int64_t kMost = std::int64_t{1} << 28;
  const auto& dims = shape.image.dims;
  if (!shape.surface || shape.surface->kind() != SurfaceKind::grey || dims[0] * dims[1] * dims[2] > kMost) return {};
  if (shape.values) return std::move(shape.values);
  Volume volume = io::read_volume(options.file, pipeline::read_options(options.how), &session.context);
  if (volume.grid.dims != dims) return {};
  volume.grid = shape.image;
  return volume;
}

/// Whether the shape that a result is of has the topology of the mesh.
Check mesh_topology_check(const pipeline::LoadedShape& shape) {
  Check check{"Betti numbers of the mesh", true, {}};
  const auto& wanted = shape.voxelization->solid_betti;
  const auto text = [](const std::array<std::int64_t, 3>& b) { return fmt::format("{}, {}, {}", b[0], b[1], b[2]); };
  if (shape.voxelization->topology == TopologyRule::voxels) {
    check.detail = "not checked: the shape is the Gauss digitization, whatever its topology";
  } else if (!wanted) {
    check.detail = "not checked: the surface does not tell the topology of its solid";
  } else if (shape.cleaned) {
    check.detail = "not checked: the shape was cleaned";
  } else if (shape.voxelization->topology_changed) {
    check.detail = fmt::format("not checked: the digitization does not reach it; the shape has {}, the solid {}",
                               text(shape.topology.betti), text(*wanted));
  } else {
    check.passed = shape.topology.betti == *wanted;
    check.detail = check.passed ? fmt::format("{}: those of its solid", text(*wanted))
                                : fmt::format("the shape has {}, the solid of the mesh {}; the resolution is too low",
                                              text(shape.topology.betti), text(*wanted));
  }
  return check;
}

/// The erosion thickness of the points of a file that is a whole core and has one, burned again; else nothing. What a
/// pruning has left tells nothing of the rest, which would take another core.
std::vector<double> erosion_of_core(const Record& data, Session& session) {
  if (pipeline::field_text(data, "stage") != "core") return {};
  const auto has = [&](std::string_view name) { return find_array(data.cell_data, name) != nullptr; };
  if (!has(kCoreErosionThickness) && !has(kRelativeErosionThickness)) return {};
  const bool whole = std::ranges::any_of(kMeasures, [&](const MeasureKind& measure) {
    return pipeline::field_number(data, std::string(measure.name).c_str()) == 0.0;
  });
  if (!whole || !find_array(data.point_data, "radius")) return {};
  const MedialAxis axis = medial_axis_of(data);
  BurnOptions options;  // as pipeline::add_measure() burns
  options.plane = axis.grid.is_plane();
  options.parents = false;
  options.rounded = true;
  pipeline::require_memory(predicted_burn_bytes(axis.complex, axis.points_of_voxels(), options),
                           "burning the core for its erosion thickness", {"a lower resolution"}, &session.context);
  return burn(axis.complex, axis.points_of_voxels(), axis.radius_of_voxels(), options, &session.context)
      .erosion_thickness;
}

}  // namespace

Action add_verify(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    std::vector<std::string> results;
    std::optional<pipeline::Length> lambda, detail;
    std::size_t samples = 20000;
    bool core = false;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  app.add_option("RESULT", o->results,
                 "What was computed of the shape (.vtp .ply). Options not given are taken from it")
      ->type_name("")
      ->required();
  CLI::Option* detail =
      add_parsed(
          app, "--detail", "The detail RESULT was pruned with, as in 'core' [default: what RESULT says]",
          [o](const std::string&, const std::string& text) { o->detail = pipeline::parse_length(text, kDetail); })
          ->type_name("LENGTH");
  add_parsed(app, "--lambda", "The radius RESULT was pruned with, as in 'core' [default: what RESULT says, else 0]",
             [o](const std::string&, const std::string& text) { o->lambda = pipeline::parse_length(text, kLambda); })
      ->type_name("LENGTH")
      ->excludes(detail);
  app.add_flag("--core", o->core,
               "Check RESULT as an exact core of voxels or pixels even if it does not say that it is one");
  add_number(app, "--samples", o->samples, "How many cells the sampled checks look at")
      ->type_name("N")
      ->capture_default_str();
  return [o](Session& session) {
    session.check_report({o->shape.file});
    for (const std::string& file : o->results) session.check_report({file});
    check_shape_options(o->shape);
    for (const std::string& file : o->results) check_exists(file);
    const bool only_json = session.options.report == "-";
    const auto answer = [&](const std::string& line) {
      if (!only_json) session.answer_line(line);
    };
    Json report;
    bool passed = true;
    std::string made_with;
    pipeline::LoadedShape loaded;
    std::optional<Volume> grey;
    std::optional<ImageView> samples;
    double threshold = 0;
    bool inverted = false;
    for (std::size_t r = 0; r < o->results.size(); ++r) {
      const std::string& file = o->results[r];
      Record data = pipeline::read_surface(file, &session.context);
      const bool says_stage = find_array(data.field_data, "stage") != nullptr;
      if (!says_stage) {  // other formats and programs do not say what they hold
        if (o->core)
          data.field_data.push_back({"stage", 1, std::vector<std::string>{"core"}});
        else if (o->lambda || o->detail)
          session.say(fmt::format("note: {} does not say that it is a core; --{} has no effect without --core", file,
                                  o->lambda ? kLambda : kDetail));
      }
      const std::string parameters = pipeline::parameters_of(data);
      if (r == 0 || parameters != made_with) {  // results of one run share their shape
        ShapeOptions shape = o->shape;
        take_recorded(shape, data, file);
        shape.how.keep_values = shape.how.preparation.any();
        loaded = load_shape(shape, session);
        made_with = parameters;
        grey = grey_values(shape, loaded, session);
        samples = grey ? std::optional(view_of(*grey)) : std::nullopt;
        inverted = shape.how.foreground.invert;
        if (const auto given = loaded.chosen ? std::optional(loaded.chosen->value) : shape.how.foreground.threshold)
          threshold = std::visit([](auto value) { return static_cast<double>(value); }, *given);
        const std::int64_t sites = count_boundary_vertices(loaded.shape);
        pipeline::require_memory(
            predicted_core_bytes(loaded.shape),  // verifying takes no more than computing
            fmt::format("verifying a shape with {}", base::counted(sites, "boundary vertex", "boundary vertices")),
            {"a result of a smaller or coarser shape"}, &session.context);
      }
      const bool plane = loaded.shape.grid().is_plane();
      if (!says_stage && o->core && plane) data.field_data.push_back({"dimension", 1, std::vector<std::int64_t>{2}});
      VerifyOptions options;
      options.samples = o->samples;
      options.longest_side = loaded.longest_side;
      if (plane) options.y_down = loaded.coordinates.y_down;
      if (loaded.surface) {
        options.surface = &loaded.surface->mesh();
        options.surface_kind = name_of(loaded.surface->kind());
        options.subdivided = loaded.subdivided();
        options.image = samples ? &*samples : nullptr;
        options.threshold = threshold;
        options.inverted = inverted;
      }
      options.format_holds_all = says_stage;  // only VTP holds it, and with it every other array
      if (o->lambda) options.lambda = loaded.scale().resolve(*o->lambda, kLambda);
      if (o->detail) options.detail = loaded.scale().resolve(*o->detail, kDetail);
      const std::vector<double> erosion = says_stage ? erosion_of_core(data, session) : std::vector<double>();
      if (!erosion.empty()) options.erosion_of_core = &erosion;
      Certificate certificate = verify(loaded.shape, data, options, &session.context);
      if (loaded.from_mesh) certificate.checks.insert(certificate.checks.begin(), mesh_topology_check(loaded));
      auto& section = report[file] = Json::object();
      for (const Check& check : certificate.checks) {
        answer(fmt::format("{}: {} {}: {}", file,
                           !check.passed                             ? "FAIL"
                           : check.detail.starts_with("not checked") ? "-   "
                                                                     : "ok  ",
                           check.name, check.detail));
        section[check.name] = {{"passed", check.passed}, {"detail", check.detail}};
        if (!check.arrays.empty()) section[check.name]["arrays"] = check.arrays;
      }
      auto& left = section["not_checked"] = Json::array();
      for (const UncheckedArray& array : certificate.not_checked)
        left.push_back({{"array", array.array}, {"reason", array.reason}});
      section["absent"] = certificate.absent;
      answer(fmt::format("{}: {}", file, certificate.passed() ? "verified" : "NOT verified"));
      passed = passed && certificate.passed();
    }
    if (!session.options.report.empty()) {
      report["verified"] = passed;
      write_report(session.options.report, report, session);
    }
    return passed ? 0 : static_cast<int>(ErrorCode::invariant);
  };
}

}  // namespace quench::program
