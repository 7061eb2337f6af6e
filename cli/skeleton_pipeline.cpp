// SPDX-License-Identifier: Apache-2.0
#include "skeleton_pipeline.h"

#include <fmt/format.h>

#include "base/text.h"
#include "core_pipeline.h"
#include "option_checks.h"
#include "quench/graph.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json("inf"); }

Json section(const CellComplex& complex, const Topology& topology) {
  return {{"vertices", complex.vertex_count},
          {"edges", complex.edges.size()},
          {"faces", complex.face_count()},
          {"euler", topology.euler},
          {"betti", topology.betti}};
}

std::optional<Vec3> root_of(const SkeletonPipelineOptions& options) {
  if (options.root.empty()) return {};
  const std::vector<double> numbers = numbers_in(options.root, ',');
  if (numbers.size() != 3)
    throw Error(ErrorCode::usage, fmt::format("--root '{}' is not a point; give three numbers: x,y,z", options.root));
  return Vec3(numbers[0], numbers[1], numbers[2]);
}

}  // namespace

void add_skeleton_options(CLI::App& app, SkeletonPipelineOptions& o) {
  const auto group = "Skeleton";
  app.add_option("--theta2", o.theta2,
                 "Drop sheets of a smaller erosion thickness where the topology allows: a fraction of the longest side "
                 "(0.03 or 3%), 8vox, 3.5abs, 0 (nothing), inf (curves only)")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  app.add_option("--theta1", o.theta1,
                 "Drop curves of a smaller erosion thickness from their free ends; inf: only what topology needs")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  add_number(app, "--smooth", o.smooth,
             "Passes of smoothing over the curves of the graph files, 0 to 10000; they stay inside the shape", 0, 10000)
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  app.add_option("--resample", o.resample, "Distance of points along curves in the graph files; 0: as they come")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  app.add_option("--tips", o.tips,
                 "Graph files: pruning takes about theta1 off every branch; 'full' grows those that stay back to their "
                 "tips, 'pruned' leaves them as in the skeleton")
      ->type_name("RULE")
      ->check(one_of({"full", "pruned"}))
      ->capture_default_str()
      ->group(group);
  app.add_option("--root", o.root,
                 "SWC: the root of its component is the node nearest to this point [default: the thickest]")
      ->type_name("X,Y,Z")
      ->group(group);
  app.add_option(
         "--swc-type", o.swc_type,
         "SWC: the type of every sample, a number or 'soma', 'axon', 'dendrite', 'apical-dendrite', 'custom' ...; "
         "programs for neurons refuse 0")
      ->type_name("TYPE")
      ->capture_default_str()
      ->group(group);
}

void check_skeleton_options(const SkeletonPipelineOptions& options) {
  parse_length(options.theta2, "--theta2");
  parse_length(options.theta1, "--theta1");
  if (std::isinf(parse_length(options.resample, "--resample").value))
    throw Error(ErrorCode::usage,
                "--resample 'inf' is not a distance between points; give a length, or 0 for the points as they come");
  root_of(options);
  io::swc_type_of(options.swc_type, "--swc-type");
}

CheckedSkeleton compute_skeleton(const MedialAxis& axis, Burning&& burning, const SkeletonPipelineOptions& options,
                                 double finest,
                                 const std::function<double(const std::string&, const std::string&)>& resolve,
                                 nlohmann::ordered_json& report, Session& session,
                                 const std::function<void(const SkeletonFamily&)>& use_family) {
  const double theta2 = resolve(options.theta2, "--theta2"), theta1 = resolve(options.theta1, "--theta1");
  const Topology wanted = topology(axis.complex);
  checkpoint(&session.context, "topology", 0.3);
  session.check_memory(predicted_skeleton_bytes(burning), "the curves of this axis",
                       {"a larger --omega", "a larger --lambda"});
  RefinedAxis refined = quench_curves(axis.complex, axis.points, axis.radius, burning, &session.context);
  burning = Burning();
  const SkeletonFamily family = skeletons(std::move(refined), &session.context);
  {
    const Skeleton curves = extract(family, std::numeric_limits<double>::infinity(), 0);
    checkpoint(&session.context, "curves", 1);
    const Topology found = topology(curves.complex);
    require_topology(found, wanted, "medial curves", "medial axis");
    report["curves"] = section(curves.complex, found);
    checkpoint(&session.context, "topology", 0.6);
  }
  CheckedSkeletonOptions wish{theta2, theta1, options.full};
  if (options.tips == "full") wish.tips = finest;
  CheckedSkeleton result = checked_skeleton(family, wanted, wish, &session.context);
  if (use_family) use_family(family);
  report["skeleton"] = {{"theta2", number(theta2)}, {"theta1", number(theta1)}};
  report["skeleton"].update(section(result.skeleton.complex, result.topology));
  return result;
}

void write_graph(const Skeleton& skeleton, const GraphFiles& files, const SkeletonPipelineOptions& options,
                 const VoxelShape* shape, const Vec3& voxel, const Coordinates& coordinates,
                 const std::function<double(const std::string&, const std::string&)>& resolve, Json& report,
                 Session& session) {
  const CurveGraph graph =
      measured_graph(skeleton, {options.smooth, resolve(options.resample, "--resample"), shape, voxel});
  Json& section = report["skeleton"];
  double length = 0;
  std::size_t ends = 0, junctions = 0;
  for (const auto& b : graph.branches) length += b.length;
  for (const auto& n : graph.nodes) {
    ends += n.kind == CurveGraph::NodeKind::end;
    junctions += n.kind == CurveGraph::NodeKind::junction;
  }
  section["branches"] = graph.branches.size();
  section["ends"] = ends;
  section["junctions"] = junctions;
  section["curve_length"] = length;
  section["sheets"] = graph.sheets;
  section["radius_offset"] = 0.5 * voxel.minCoeff();
  if (!files.swc.empty()) {
    const int type = io::swc_type_of(options.swc_type, "--swc-type");
    const io::SwcReport swc = io::write_swc(files.swc, graph, {root_of(options), type, coordinates});
    Json cuts = Json::array();
    for (const auto& cut : swc.cuts)
      cuts.push_back({{"branch", cut.branch},
                      {"from", {cut.from[0], cut.from[1], cut.from[2]}},
                      {"to", {cut.to[0], cut.to[1], cut.to[2]}}});
    section["swc"] = {{"type", type},
                      {"trees", swc.trees},
                      {"samples", swc.samples},
                      {"sheet_links", swc.sheet_links},
                      {"cuts", cuts}};
    if (!swc.cuts.empty())
      session.say(fmt::format("note: {} {} cut in {}, as SWC holds trees only; the header of the file lists where",
                              base::counted(swc.cuts.size(), "loop"), swc.cuts.size() == 1 ? "is" : "are",
                              files.swc.string()));
  }
  if (!graph.sheet_only.empty())
    session.say(
        fmt::format("note: components that are sheets without curves: {}; the graph files hold nothing of them (a "
                    "larger --theta2, or inf, turns sheets into curves)",
                    graph.sheet_only.size()));
  if (!files.graphml.empty()) io::write_graphml(files.graphml, graph, coordinates);
  if (!files.csv.empty()) io::write_branches(files.csv, graph);
}

}  // namespace quench::program
