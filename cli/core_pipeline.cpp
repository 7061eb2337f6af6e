// SPDX-License-Identifier: Apache-2.0
#include "core_pipeline.h"

#include <fmt/format.h>

#include <iostream>
#include <ostream>

#include "quench/io.h"
#include "quench/prune.h"
#include "quench/topology.h"
#include "quench/voxel_core.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

Json axis_section(const MedialAxis& axis, const Topology& topology, double reconstructed) {
  return {{"vertices", axis.complex.vertex_count},
          {"edges", axis.complex.edges.size()},
          {"faces", axis.complex.face_count()},
          {"euler", topology.euler},
          {"betti", topology.betti},
          {"reconstructed", reconstructed}};
}

void require_topology(const Topology& got, const Topology& wanted, const char* what) {
  if (got == wanted) return;
  throw Error(ErrorCode::invariant,
              fmt::format("the topology of the {} (Betti numbers {}, {}, {}) is not that of the shape ({}, {}, {}); this is a bug in Quench, please "
                          "report it with the input", what, got.betti[0], got.betti[1], got.betti[2], wanted.betti[0], wanted.betti[1], wanted.betti[2]));
}

// The share of the balls: "0.9970".
std::string share_text(double share) { return fmt::format("{:.4f}", share); }

void add_field(PolyData& data, const char* name, std::string text) {
  data.field_data.push_back({name, 1, std::vector<std::string>{std::move(text)}});
}
void add_field(PolyData& data, const char* name, double value) { data.field_data.push_back({name, 1, std::vector<double>{value}}); }

}  // namespace

void add_core_options(CLI::App& app, CorePipelineOptions& o) {
  const auto group = "Voxel core";
  app.add_option("--lambda", o.lambda,
                 "Pruning radius: a fraction of the longest side (0.02 or 2%), 2.5vox, 3.5abs, 0 (none), or 'auto': the largest from 0.02 down whose "
                 "balls still fill 98% of the shape")
      ->capture_default_str()->group(group);
  app.add_option("--lambda-rule", o.rule, "lambda of edges and vertices: 'coface' (largest of the cells around) or 'ball' (smallest ball enclosing the sites)")
      ->check(CLI::IsMember({"coface", "ball"}))->capture_default_str()->group(group);
  app.add_flag("--full", o.full, "Write the cells below lambda too (each with its lambda_level)")->group(group);
}

CorePipelineResult compute_core(const LoadedShape& loaded, const CorePipelineOptions& options, Session& session) {
  const Grid& grid = loaded.shape.grid();
  const double smallest = grid.spacing.minCoeff();
  const bool automatic = options.lambda == "auto";
  double lambda = automatic ? 0 : parse_length(options.lambda, "--lambda").resolve(loaded.longest_side, smallest);

  const std::int64_t sites = count_boundary_vertices(loaded.shape);
  session.check_memory(predicted_core_bytes(sites), fmt::format("the voxel core of {} boundary vertices", sites));
  CorePipelineResult result;
  MedialAxis core = voxel_core(loaded.shape, {.rule = options.rule == "ball" ? LambdaRule::ball : LambdaRule::coface}, &session.context);
  prune_levels(core, &session.context);
  const Reconstruction reconstruction(loaded.shape, core, 50000, &session.context);
  if (automatic) {
    lambda = auto_lambda(reconstruction, loaded.longest_side, smallest);
    session.say(fmt::format("lambda {} ({:.3g} voxels, {:.3g} of the side; auto)", lambda, lambda / smallest, lambda / loaded.longest_side));
  }
  const Topology core_topology = topology(core.complex);
  checkpoint(&session.context, "topology", 0.5);
  require_topology(core_topology, loaded.topology, "voxel core");
  const Json core_section = axis_section(core, core_topology, reconstruction.share(0));

  MedialAxis kept = pruned(core, lambda);
  const double reconstructed = reconstruction.share(lambda);
  const Topology kept_topology = topology(kept.complex);
  require_topology(kept_topology, loaded.topology, "pruned core");
  checkpoint(&session.context, "topology", 1);
  if (reconstructed < 0.9)
    session.say(fmt::format("warning: the balls of the pruned core contain only {} of the shape; use a smaller --lambda or 'auto'", share_text(reconstructed)));

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
                     {"voxelization_changed_topology", loaded.topology_changed.value_or(false)}};
  report["core"] = core_section;
  report["pruned"] = {{"lambda", std::isfinite(lambda) ? Json(lambda) : Json("inf")}};
  report["pruned"].update(axis_section(kept, kept_topology, reconstructed));

  result.axis = options.full ? std::move(core) : std::move(kept);
  result.data = to_poly_data(result.axis);
  const Topology& t = loaded.topology;
  add_field(result.data, "stage", std::string("core"));
  add_field(result.data, "lambda", options.full ? 0.0 : std::min(lambda, kInfiniteLevelInFiles));
  add_field(result.data, "lambda_rule", options.rule);
  add_field(result.data, "longest_side", loaded.longest_side);
  add_field(result.data, "reconstructed", options.full ? reconstruction.share(0) : reconstructed);
  result.data.field_data.push_back({"euler", 1, std::vector<std::int64_t>{t.euler}});
  result.data.field_data.push_back({"betti", 3, std::vector<std::int64_t>(t.betti.begin(), t.betti.end())});
  add_field(result.data, "units", loaded.units);
  add_field(result.data, "parameters", report["parameters"].dump());
  add_field(result.data, "version", std::string(QUENCH_VERSION));
  return result;
}

void write_report(const std::string& file, Json report, const Session& session) {
  const auto& spent = session.seconds();
  const auto of = [&](std::initializer_list<const char*> stages) {
    double sum = 0;
    for (const char* stage : stages)
      if (const auto found = spent.find(stage); found != spent.end()) sum += found->second;
    return std::round(sum * 1e4) / 1e4;
  };
  report["seconds"] = {{"voxelize", of({"read", "voxelize"})}, {"delaunay", of({"delaunay"})}, {"core", of({"merge", "core"})},
                       {"prune", of({"prune", "reconstruct"})}, {"topology", of({"topology"})}, {"write", of({"write"})},
                       {"total", std::round(session.total_seconds() * 1e4) / 1e4}};
  report["peak_bytes"] = Session::peak_bytes();
  report["threads"] = session.options.threads;
  report["version"] = QUENCH_VERSION;
  const std::string text = report.dump(2) + "\n";
  if (file == "-")
    std::cout << text;
  else
    io::write_atomically(file, [&](std::ostream& out) { out << text; });
}

void say_written(Session& session, const std::string& file, const CorePipelineResult& result, const LoadedShape& loaded) {
  const CellComplex& c = result.axis.complex;
  session.say(fmt::format("{}: {} vertices, {} edges, {} faces; topology of the shape proved; lengths in {}; {:.1f} s", file, c.vertex_count,
                          c.edges.size(), c.face_count(), loaded.units.empty() ? "the input's units" : loaded.units, session.total_seconds()));
}

}  // namespace quench::program
