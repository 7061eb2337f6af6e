// SPDX-License-Identifier: Apache-2.0
#include "skeleton_pipeline.h"

#include <fmt/format.h>

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

void require_topology(const Topology& got, const Topology& wanted, const char* what) {
  if (got == wanted) return;
  throw Error(
      ErrorCode::invariant,
      fmt::format("the topology of the {} (Betti numbers {}, {}, {}) is not that of the medial axis ({}, {}, "
                  "{}); this is a bug in Quench, please report it with the input",
                  what, got.betti[0], got.betti[1], got.betti[2], wanted.betti[0], wanted.betti[1], wanted.betti[2]));
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
}

void check_skeleton_options(const SkeletonPipelineOptions& options) {
  parse_length(options.theta2, "--theta2");
  parse_length(options.theta1, "--theta1");
}

SkeletonPipelineResult compute_skeleton(const MedialAxis& axis, Burning&& burning,
                                        const SkeletonPipelineOptions& options,
                                        const std::function<double(const std::string&, const std::string&)>& resolve,
                                        nlohmann::ordered_json& report, Session& session) {
  const double theta2 = resolve(options.theta2, "--theta2"), theta1 = resolve(options.theta1, "--theta1");
  const Topology wanted = topology(axis.complex);
  checkpoint(&session.context, "topology", 0.3);
  RefinedAxis refined = quench_curves(axis.complex, axis.points, axis.radius, burning, &session.context);
  burning = Burning();
  const SkeletonFamily family = skeletons(std::move(refined), &session.context);
  {
    const Skeleton curves = extract(family, std::numeric_limits<double>::infinity(), 0);
    checkpoint(&session.context, "curves", 1);
    const Topology found = topology(curves.complex);
    require_topology(found, wanted, "medial curves");
    report["curves"] = section(curves.complex, found);
    checkpoint(&session.context, "topology", 0.6);
  }
  SkeletonPipelineResult result{extract(family, theta2, theta1, options.full), {}};
  checkpoint(&session.context, "skeleton", 1);
  result.topology = topology(result.skeleton.complex);
  require_topology(result.topology, wanted, "skeleton");
  checkpoint(&session.context, "topology", 1);
  report["skeleton"] = {{"theta2", number(theta2)}, {"theta1", number(theta1)}};
  report["skeleton"].update(section(result.skeleton.complex, result.topology));
  return result;
}

}  // namespace quench::program
