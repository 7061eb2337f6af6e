// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "quench/axis.h"
#include "quench/pipeline.h"

namespace quench {

CheckedSkeleton checked_skeleton(const SkeletonFamily& family, const Topology& wanted,
                                 const CheckedSkeletonOptions& options, Context* context) {
  constexpr double kNoTips = std::numeric_limits<double>::infinity();
  CheckedSkeleton result{extract(family, options.theta2, options.theta1, {options.parts, kNoTips}), {}, {}};
  result.measured = extract(family, options.theta2, options.theta1, {false, options.tips});
  checkpoint(context, "skeleton", 1);
  result.topology = topology(result.skeleton.complex);
  require_topology(result.topology, wanted, "skeleton", "medial axis");
  require_topology(topology(result.measured.complex), wanted, "curve graph", "medial axis");
  checkpoint(context, "topology", 1);
  return result;
}

Record skeleton_file(const Skeleton& skeleton, const Topology& topology, const Record& from) {
  Record data = to_record(skeleton);
  for (const char* name : {"dims", "spacing", "origin", "direction", "longest_side", "lambda", "lambda_chosen", "omega",
                           "propagation", "radius_rule", "units", "SPACE", "parameters"})
    if (const DataArray* array = find_array(from.field_data, name)) data.field_data.push_back(*array);
  const auto put = [&](const char* name, DataArray::Values values, int components = 1) {
    data.field_data.push_back({name, components, std::move(values)});
  };
  put("stage", std::vector<std::string>{"skeleton"});
  put("theta2", std::vector<double>{std::min(skeleton.theta2, kInfiniteLevelInFiles)});
  put("theta1", std::vector<double>{std::min(skeleton.theta1, kInfiniteLevelInFiles)});
  put("euler", std::vector<std::int64_t>{topology.euler});
  put("betti", std::vector<std::int64_t>(topology.betti.begin(), topology.betti.end()), 3);
  put("version", std::vector<std::string>{QUENCH_VERSION});
  put("format_version", std::vector<std::int64_t>{kFormatVersion});
  return data;
}

double reconstructed_share(const VoxelShape& shape, const Skeleton& skeleton, Context* context) {
  MedialAxis balls;
  balls.complex.vertex_count = skeleton.complex.vertex_count;
  balls.points = skeleton.points;
  balls.radius = skeleton.radius;
  const std::vector<double> always(skeleton.points.size(), std::numeric_limits<double>::infinity());
  balls.measures = {{std::string(kLambda), {}, {always, {}, {}}}};
  return Reconstruction(shape, balls, Reconstruction::kSamples, context).share(0);
}

CurveGraph measured_graph(const Skeleton& skeleton, const GraphOptions& options) {
  SmoothOptions smoothing{options.smooth, options.resample, boundary_gap(options.voxel), {}};
  if (const VoxelShape* shape = options.shape)
    smoothing.inside = [shape](const Vec3& a, const Vec3& b) { return contains_segment(*shape, a, b); };
  CurveGraph graph = smoothed(curve_graph(skeleton), smoothing);
  const double more = 0.5 * options.voxel.minCoeff();
  for (auto& node : graph.nodes) node.radius += more;
  for (auto& branch : graph.branches) {
    for (double& r : branch.radius) r += more;
    branch.mean_radius += more;
    branch.min_radius += more;
    branch.max_radius += more;
  }
  return graph;
}

std::int64_t predicted_skeleton_bytes(const BurnNetwork& network) {
  return 900 * std::int64_t{network.node_count()};  // 0.77 KB per node on the armadillo at 1024
}

}  // namespace quench
