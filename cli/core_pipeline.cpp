// SPDX-License-Identifier: Apache-2.0
#include "core_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "base/text.h"
#include "option_checks.h"
#include "quench/io.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

Json axis_section(std::size_t vertices, std::size_t edges, std::size_t faces, const Topology& topology,
                  double reconstructed) {
  return {{"vertices", vertices},    {"edges", edges},          {"faces", faces},
          {"euler", topology.euler}, {"betti", topology.betti}, {"reconstructed", reconstructed}};
}

// The share of the balls: "0.9970".
std::string share_text(double share) { return fmt::format("{:.4f}", share); }

}  // namespace

void add_core_options(CLI::App& app, CorePipelineOptions& o) {
  const auto group = "Medial axis";
  app.add_option("--lambda", o.lambda,
                 "Drop what is thinner than this radius where the topology allows: a fraction of the longest side "
                 "(0.02 or 2%), 2.5vox, 3.5abs, inf, "
                 "0 (nothing), or 'auto': the largest from 0.02 down whose balls still fill 98% of the shape")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  app.add_option("--lambda-rule", o.rule,
                 "The lambda of edges and vertices: 'coface', the largest of the faces around, or 'ball', the radius "
                 "of the smallest ball around "
                 "their nearest boundary points")
      ->type_name("RULE")
      ->check(one_of({"coface", "ball"}))
      ->capture_default_str()
      ->group(group);
  app.add_flag("--full", o.full, "Write the cells below lambda too (each with its lambda_level)")->group(group);
}

void check_core_options(const CorePipelineOptions& options) {
  if (options.lambda != "auto") parse_length(options.lambda, "--lambda");
}

CorePipelineResult compute_core(const LoadedShape& loaded, const CorePipelineOptions& options, Session& session) {
  const Grid& grid = loaded.shape.grid();
  const double smallest = grid.spacing.minCoeff();
  const bool automatic = options.lambda == "auto";

  const std::int64_t sites = count_boundary_vertices(loaded.shape);
  CheckedCoreOptions core_options;
  // --memory-limit is for all the program holds; what is free is beside what it holds.
  const std::int64_t held = base::held_memory(), before = session.options.memory_limit.empty() ? 0 : held;
  const std::int64_t at_once = predicted_core_bytes(loaded.shape),
                     in_bricks = predicted_core_bytes_in_bricks(loaded.shape);
  core_options.in_bricks = before + at_once > session.memory_limit() && in_bricks < at_once;
  const std::int64_t bytes = core_options.in_bricks ? in_bricks : at_once;
  std::string what =
      fmt::format("the medial axis of a shape with {}", base::counted(sites, "boundary vertex", "boundary vertices"));
  if (core_options.in_bricks) what += fmt::format(", in bricks ({} at once),", base::bytes_text(before + at_once));
  session.check_memory(before + bytes, what,
                       loaded.kind == "mesh" ? std::vector<std::string>{"a lower --resolution"}
                                             : std::vector<std::string>{"a smaller or coarser volume", "a part of it"});
  if (core_options.in_bricks)
    session.say(fmt::format("{} boundary vertices are worked on in bricks: about {} of memory instead of {}", sites,
                            base::bytes_text(held + bytes), base::bytes_text(held + at_once)));
  const std::int64_t predicted = std::max(held + bytes, Session::peak_bytes());
  session.detail(
      fmt::format("{} boundary vertices, about {} of memory at the peak", sites, base::bytes_text(predicted)));
  if (!automatic) core_options.lambda = parse_length(options.lambda, "--lambda").resolve(loaded.longest_side, smallest);
  core_options.rule = options.rule == "ball" ? LambdaRule::ball : LambdaRule::coface;
  core_options.full = options.full;
  CheckedCore core = checked_core(loaded.shape, loaded.topology, loaded.longest_side, core_options, &session.context);
  const double lambda = core.lambda;
  if (automatic)
    session.say(fmt::format("lambda {:.6g} ({:.3g} voxels, {:.3g} of the longest side; chosen by auto)", lambda,
                            lambda / smallest, lambda / loaded.longest_side));
  if (core.reconstructed < 0.9)
    session.say(fmt::format(
        "warning: the balls of the pruned core contain only {} of the shape; use a smaller --lambda or 'auto'",
        share_text(core.reconstructed)));

  CorePipelineResult result;
  Json& report = result.report;
  report["input"] = loaded.input;
  report["parameters"] = loaded.parameters;
  report["parameters"]["lambda"] = options.lambda;
  report["parameters"]["lambda_rule"] = options.rule;
  report["shape"] = {{"dims", grid.dims},
                     {"spacing", {grid.spacing[0], grid.spacing[1], grid.spacing[2]}},
                     {"voxels", loaded.shape.voxel_count()},
                     {"sites", sites},
                     {"euler", loaded.topology.euler},
                     {"betti", loaded.topology.betti},
                     {"voxelization_changed_topology", topology_changed_of(loaded)}};
  report["core"] = axis_section(core.vertices, core.edges, core.faces, core.topology, core.whole);
  report["core"]["in_bricks"] = core.options.in_bricks;
  report["core"]["predicted_bytes"] = predicted;
  report["pruned"] = {{"lambda", std::isfinite(lambda) ? Json(lambda) : Json("inf")}};
  report["pruned"].update(
      axis_section(core.kept_vertices, core.kept_edges, core.kept_faces, core.topology, core.reconstructed));
  result.core = std::move(core);
  return result;
}

void write_report(const std::string& file, Json report, Session& session) {
  const auto& spent = session.seconds();
  const auto of = [&](std::initializer_list<const char*> stages) {
    double sum = 0;
    for (const char* stage : stages)
      if (const auto found = spent.find(stage); found != spent.end()) sum += found->second;
    return std::round(sum * 1e4) / 1e4;
  };
  report["seconds"] = {{"voxelize", of({"read", "foreground", "components", "cavities", "voxelize"})},
                       {"delaunay", of({"peel", "delaunay"})},
                       {"core", of({"merge", "core"})},
                       {"prune", of({"prune", "reconstruct"})},
                       {"burn", of({"burn"})},
                       {"curves", of({"curves"})},
                       {"skeleton", of({"skeleton"})},
                       {"topology", of({"topology"})},
                       {"page", of({"page", "picture"})},
                       {"write", of({"write"})},
                       {"total", std::round(session.total_seconds() * 1e4) / 1e4}};
  report["peak_bytes"] = Session::peak_bytes();
  report["threads"] = session.options.threads;
  report["version"] = QUENCH_VERSION;
  const std::string text = json_text(report, 2) + "\n";
  if (file == "-")
    session.answer(text);
  else
    io::write_atomically(file, [&](std::ostream& out) { out << text; });
}

void write_report(io::OutputGroup& outputs, const Json& report, Session& session) {
  const std::string& file = session.options.report;
  if (!file.empty() && file != "-") write_report(file, report, session);
  outputs.commit();
  if (file == "-") write_report(file, report, session);
}

std::string cells_text(std::size_t vertices, std::size_t edges, std::size_t faces) {
  return fmt::format("{}, {}, {}", base::counted(vertices, "vertex", "vertices"), base::counted(edges, "edge"),
                     base::counted(faces, "face"));
}

std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

void say_written(Session& session, const std::string& axis, const std::string& report, const CheckedCore& core,
                 const LoadedShape& loaded) {
  std::string stages;
  for (const auto& [stage, seconds] : session.seconds())
    stages += fmt::format("{}{} {:.2f} s", stages.empty() ? "" : ", ", stage, seconds);
  session.detail(fmt::format("{}; {} of memory at the peak", stages, base::bytes_text(Session::peak_bytes())));
  const bool full = core.options.full;
  session.say(fmt::format("{}: {}; topology as that of the shape; lengths in {}; {:.1f} s{}", axis,
                          cells_text(full ? core.vertices : core.kept_vertices, full ? core.edges : core.kept_edges,
                                     full ? core.faces : core.kept_faces),
                          loaded.coordinates.units.empty() ? "the input's units" : loaded.coordinates.units,
                          session.total_seconds(), report.empty() ? "" : fmt::format("; report in {}", report)));
}

}  // namespace quench::program
