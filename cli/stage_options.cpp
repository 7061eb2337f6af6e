// SPDX-License-Identifier: Apache-2.0
#include "stage_options.h"

#include <fmt/format.h>

#include "option_checks.h"
#include "quench/error.h"
#include "quench/measures.h"

namespace quench::program {
namespace {

/// The name of a parameter of the library: "theta2" of "--theta2".
std::string field_of(const std::string& option) { return option.substr(2); }

/// An option that is one of two names, or "auto" where the value may be missing.
template <class Enum, class Value>
CLI::Option* add_named(CLI::App& app, const std::string& name, Value& value, Enum first, Enum second,
                       const std::string& help) {
  constexpr bool may_be_auto = std::is_same_v<Value, std::optional<Enum>>;
  std::vector<std::string> names{std::string(pipeline::name_of(first)), std::string(pipeline::name_of(second))};
  if (may_be_auto) names.insert(names.begin(), "auto");
  return add_parsed(
             app, name, help,
             [&value, first, second](const std::string&, const std::string& text) {
               if (text == "auto")
                 value = {};
               else
                 value = text == pipeline::name_of(second) ? second : first;
             },
             [&value] {
               if constexpr (may_be_auto)
                 return value ? std::string(pipeline::name_of(*value)) : std::string("auto");
               else
                 return std::string(pipeline::name_of(value));
             })
      ->type_name("RULE")
      ->check(one_of(names))
      ->capture_default_str();
}

/// A threshold of a measure by which cores are pruned; giving it chooses the measure.
CLI::Option* add_pruning(CLI::App& app, const std::string& name, std::string_view measure, pipeline::Pruning& pruning,
                         const std::string& help) {
  return add_parsed(
             app, name, help,
             [&pruning, measure](const std::string& option, const std::string& text) {
               pruning = {measure, pipeline::parse_length_or_auto(text, field_of(option))};
             },
             [&pruning, measure] {
               return pruning.measure == measure ? pipeline::text_of(pruning.threshold) : std::string();
             })
      ->type_name("LENGTH")
      ->capture_default_str();
}

pipeline::Pruning named_pruning(const std::string& field, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw Error(ErrorCode::usage, fmt::format("'{}' is not a measure and its threshold; give e.g. mgf=10vox", text),
                field);
  return pipeline::pruning_of(text.substr(0, equals), text.substr(equals + 1), field);
}

/// "mgf, ...; ... (degrees), ... (a number)", each with what it is.
std::string menu() {
  std::string text;
  for (const MeasureKind& measure : kMeasures) {
    const char* unit = measure.unit == MeasureUnit::degrees ? ", in degrees"
                       : measure.unit == MeasureUnit::ratio ? ", a number"
                                                            : "";
    text += fmt::format("{}{} ({}{})", text.empty() ? "" : ", ", measure.name, measure.words, unit);
  }
  return text;
}

}  // namespace

CLI::Option* add_length(CLI::App& app, const std::string& name, pipeline::Length& length, const std::string& help) {
  return add_parsed(
             app, name, help,
             [&length](const std::string& option, const std::string& text) {
               length = pipeline::parse_length(text, field_of(option));
             },
             [&length] { return pipeline::text_of(length); })
      ->type_name("LENGTH")
      ->capture_default_str();
}

CLI::Option* add_length(CLI::App& app, const std::string& name, std::optional<pipeline::Length>& length,
                        const std::string& help) {
  return add_parsed(
             app, name, help,
             [&length](const std::string& option, const std::string& text) {
               length = pipeline::parse_length_or_auto(text, field_of(option));
             },
             [&length] { return pipeline::text_of(length); })
      ->type_name("LENGTH")
      ->capture_default_str();
}

void add_core_options(CLI::App& app, pipeline::AxisOptions& o) {
  const auto group = "Medial axis";
  CLI::Option* detail = add_pruning(
      app, "--detail", kDetail, o.pruning,
      "What sticks out less than this length is noise, and is dropped where the topology allows; every corner of the "
      "voxel surface stays within twice as much (at least a voxel diagonal) of the balls that are kept: a fraction of "
      "the "
      "longest side (0.02 or 2%), 2.5vox, 3.5abs, inf, 0 (nothing is dropped), or 'auto': half the voxel diagonal, "
      "above which nothing comes from the voxels' steps");
  CLI::Option* lambda = add_pruning(
      app, "--lambda", kLambda, o.pruning,
      "Instead: drop what is thinner than this radius, whatever sticks out. A length, or 'auto': the largest from 0.02 "
      "down whose balls still fill 98% of the shape (which keeps much of the voxels' steps)");
  lambda->excludes(detail)->group(group);
  add_parsed(
      app, "--prune-by",
      "Instead, by a measure: drop what is below this threshold of it where the topology allows. NAME is one of " + menu() +
          ". Thresholds are lengths where nothing else is said",
      [&o](const std::string& option, const std::string& text) { o.pruning = named_pruning(field_of(option), text); },
      [] { return std::string(); })
      ->type_name("NAME=THRESHOLD")
      ->excludes(lambda)
      ->excludes(detail)
      ->group(group);
  add_parsed(
      app, "--measures",
      "Also write these measures of what is kept: names as those of --prune-by, or 'all'; object_angle and cap_height are "
      "always there",
      [&o](const std::string&, const std::string& text) { o.measures = pipeline::parse_measures(text); },
      [] { return std::string(); })
      ->type_name("NAME[,NAME...]")
      ->group(group);
  detail->group(group);
  add_named(app, "--lambda-rule", o.rule, LambdaRule::coface, LambdaRule::ball,
            "The lambda of edges and vertices: 'coface', the largest of the faces around, or 'ball', the radius "
            "of the smallest ball around "
            "their nearest boundary points")
      ->group(group);
  app.add_flag("--full", o.full,
               "Write the cells below the threshold too (each with its level: detail_level or, pruned by NAME, NAME_level)")
      ->group(group);
}

void add_burn_options(CLI::App& app, pipeline::BurningOptions& o, bool takes_burned) {
  const auto group = "Burning";
  // Commands that go on from a file take what it was burned with.
  const std::string automatic = takes_burned ? "'auto': as the file was burned, else " : "'auto': ";
  add_parsed(
      app, "--omega",
      fmt::format(
          "Distance of nodes along edges: a fraction of the longest side (0.005), 0.5vox, 2abs, or {}0.65 of the "
          "mean edge (0.35 for triangles), for an erosion thickness right to about 0.1% on voxel cores, 0.3% "
          "on cores fitted to a mesh",
          automatic),
      [&o](const std::string&, const std::string& text) { o.omega = pipeline::parse_omega(text); },
      [&o] { return pipeline::text_of(o.omega); })
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  add_named(
      app, "--radius", o.radius, RadiusRule::exact, RadiusRule::linear,
      fmt::format("The radius between vertices: 'exact' where neighbours share a nearest boundary point, 'linear', "
                  "or {}exact for voxel cores of Quench, linear for others",
                  automatic))
      ->group(group);
  add_named(
      app, "--propagation", o.propagation, Propagation::segments, Propagation::windows,
      fmt::format("How fire crosses polygons: 'segments', from nodes on edges (see --omega), 'windows', exact up to "
                  "rounding to a 4096th of omega, in two to five times the time, or {}segments",
                  automatic))
      ->group(group);
}

CLI::Option* add_theta1(CLI::App& app, pipeline::SkeletonOptions& o, const std::string& help) {
  return add_parsed(
             app, "--theta1", help,
             [&o](const std::string&, const std::string& text) { o.theta1 = pipeline::parse_theta1(text); },
             [&o] { return pipeline::text_of(o.theta1); })
      ->type_name("LENGTH|Xr")
      ->capture_default_str();
}

void add_curve_options(CLI::App& app, pipeline::SkeletonOptions& o, GraphFileOptions& files,
                       const std::string& theta1_help) {
  const auto group = "Skeleton";
  add_theta1(app, o, theta1_help)->group(group);
  add_number(app, "--smooth", files.graph.smooth,
             "Passes of smoothing over curves, sheets and their rims, 0 to 10000; they stay inside the shape", 0, 10000)
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  add_parsed(
      app, "--resample", "Distance of points along curves; 0: as they come",
      [&files](const std::string&, const std::string& text) { files.graph.resample = pipeline::parse_resample(text); },
      [&files] { return pipeline::text_of(files.graph.resample); })
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  add_parsed(
      app, "--tips",
      "Pruning takes about theta1 off every branch and theta2 off every rim of a sheet; 'full' grows those that stay "
      "back to their tips and rims, 'pruned' leaves them",
      [&o](const std::string&, const std::string& text) { o.full_tips = text == "full"; },
      [&o] { return std::string(o.full_tips ? "full" : "pruned"); })
      ->type_name("RULE")
      ->check(one_of({"full", "pruned"}))
      ->capture_default_str()
      ->group(group);
}

Vec3 point_of(const std::string& option, const std::string& text) {
  const std::vector<double> numbers = numbers_in(text, ',');
  if (numbers.size() != 3)
    throw Error(ErrorCode::usage, fmt::format("{} '{}' is not a point; give three numbers: x,y,z", option, text));
  return {numbers[0], numbers[1], numbers[2]};
}

CLI::Option* add_swc_type(CLI::App& app, std::string& type) {
  return add_parsed(
             app, "--swc-type",
             "SWC: the type of every sample, a number or 'soma', 'axon', 'dendrite', 'apical-dendrite', 'custom' ...; "
             "programs for neurons refuse 0",
             [&type](const std::string& option, const std::string& text) {
               io::swc_type_of(text, option);
               type = text;
             },
             [&type] { return type; })
      ->type_name("TYPE")
      ->check(also(
          {"undefined", "soma", "axon", "dendrite", "basal-dendrite", "apical-dendrite", "custom", "neurite", "glia"}))
      ->capture_default_str();
}

void add_skeleton_options(CLI::App& app, pipeline::SkeletonOptions& o, GraphFileOptions& files) {
  const auto group = "Skeleton";
  add_length(
      app, "--theta2", o.theta2,
      "Drop sheets of a smaller erosion thickness where the topology allows: a fraction of the longest side "
      "(0.03 or 3%), 8vox, 3.5abs, 0 (nothing), inf (curves only), or 'auto': 0.03, but no less than three times the "
      "automatic detail, 2.6 voxels")
      ->group(group);
  add_curve_options(
      app, o, files,
      "Drop branches of curves that stick out of what they leave by less than this many of its radii (0.5r), or "
      "curves of a smaller erosion thickness (0.02 or 2% of the longest side, 8vox, 3.5abs) from their free ends; "
      "inf: only what topology needs; 'auto': 0.5r. With radii also what is thinner than 4.5 times the automatic "
      "detail, 3.9 voxels or 3.2 pixels");
  app.add_flag("--longest", o.main_axes,
               "Only the main axis of every part of the shape: the longest of the shortest ways between two ends; for "
               "skeletons of curves, as those of images or with --theta2 inf")
      ->group(group);
  add_parsed(app, "--root", "SWC: the root of its component is the node nearest to this point [default: the thickest]",
             [&files](const std::string& option, const std::string& text) { files.root = point_of(option, text); })
      ->type_name("X,Y,Z")
      ->group(group);
  add_swc_type(app, files.swc_type)->group(group);
}

void add_page_options(CLI::App& app, std::size_t& max_triangles) {
  add_number<std::size_t>(
      app, "--max-triangles", max_triangles,
      "The page: about so many triangles, 1000 to 50000000; the skeleton asked for is always whole, its sliders, the "
      "core and the surface share the rest",
      1000, 50'000'000)
      ->type_name("N")
      ->capture_default_str()
      ->group("Page");
}

}  // namespace quench::program
