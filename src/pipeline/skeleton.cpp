// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "base/rounded_down.h"
#include "graph/branch_measures.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {

RefinedAxis curves_of(const MedialAxis& axis, Burning burning, Context* context) {
  require_memory(predicted_skeleton_bytes(burning), "the curves of this medial axis",
                 {"a larger omega", "a larger lambda"}, context);
  RefinedAxis refined = quench_curves(axis.complex, axis.points, axis.radius, std::move(burning), context);
  const Measure* mgf = axis.find_measure(kMgf);
  if (refined.plane && mgf && mgf->value.vertex.size() == refined.points.size()) refined.mgf = mgf->value.vertex;
  return refined;
}

FamilyResult family_of(RefinedAxis&& refined, const Topology& wanted, const FamilyFloor& floor, Context* context) {
  FamilyResult result{
      with_floor(skeletons(std::move(refined), context), floor.theta2, floor.theta1, context), wanted, {}};
  const Skeleton curves = extract(result.family, std::numeric_limits<double>::infinity(), result.family.theta1_floor);
  checkpoint(context, "curves", 1);
  require_topology(topology(curves.complex), wanted, "medial curves", "medial axis");
  result.curves = counts_of(curves.complex);
  checkpoint(context, "topology", 0.6);
  return result;
}

// What the steps of voxels leave near the axis of a limb is seldom thicker than three times the automatic detail.
double theta2_of(const SkeletonOptions& options, const Scale& scale) {
  return options.theta2 ? scale.resolve(*options.theta2, "theta2")
                        : std::max(0.03 * scale.longest_side, 3 * scale.detail);
}

// Half a radius: fingers and toes stick out of hands and feet by nine tenths and more, folds of skin by less than a
// third. The noise of thin parts, of which half a radius is less than a voxel, is thinner than four voxels.
double theta1_radii_of(const SkeletonOptions& options) {
  if (!options.theta1) return 0.5;
  return options.theta1->unit == Length::Unit::radii ? options.theta1->value : 0;
}

double theta1_of(const SkeletonOptions& options, const Scale& scale) {
  if (options.theta1 && options.theta1->unit != Length::Unit::radii) return scale.resolve(*options.theta1, "theta1");
  return scale.detail > 0 ? 4.5 * scale.detail : 0.01 * scale.longest_side;
}

namespace {

// Ends at the centre of the last ball are as thin as nothing; the noise of voxels is as thick as one, what is left of
// it on a surface a fifth.
double thinnest_tip(const Scale& scale, double omega) {
  if (!(scale.voxel > 0)) return omega;
  return scale.fitted ? 0.2 * scale.voxel : scale.voxel;
}

double thickness_of_tips(const SkeletonOptions& options, const Scale& scale, double omega) {
  return options.full_tips ? thinnest_tip(scale, omega) : std::numeric_limits<double>::infinity();
}

// The rims of a sheet are the ends of its polygons, half a voxel from where the shape lets it end.
double thinnest_rim(const Scale& scale, double omega) {
  return std::max(thinnest_tip(scale, omega), 0.5 * scale.voxel);
}

double thickness_of_rims(const SkeletonOptions& options, const Scale& scale, double omega) {
  return options.full_tips ? thinnest_rim(scale, omega) : std::numeric_limits<double>::infinity();
}

// What is no branch by itself: the fires beside it die out.
double minor_curve(const Scale& scale) { return 4 * scale.detail; }

// Radii as distances to a surface, where the point is inside; of the plane, to the boundary vertices.
template <class Measure>
void measure_radii(CurveGraph& graph, const Measure& measure) {
  for (auto& node : graph.nodes) measure(node.point, node.radius);
  for (auto& branch : graph.branches) {
    for (std::size_t i = 0; i < branch.points.size(); ++i) measure(branch.points[i], branch.radius[i]);
    graph::measure(branch);
  }
}

}  // namespace

FamilyFloor floor_of(const SkeletonOptions& options, const Scale& scale, double omega) {
  const double least = thinnest_tip(scale, omega);
  return {base::rounded_down(std::min(least, theta2_of(options, scale))),
          base::rounded_down(std::min(least, theta1_of(options, scale)))};
}

SkeletonResult skeleton_of(const FamilyResult& family, const SkeletonOptions& options, const Scale& scale, double omega,
                           Context* context) {
  SkeletonResult result;
  result.skeleton = extract(family.family, theta2_of(options, scale), theta1_of(options, scale),
                            {.parts = options.parts,
                             .regrow_tips_above = thickness_of_tips(options, scale, omega),
                             .regrow_rims_above = thickness_of_rims(options, scale, omega),
                             .minor_curve = minor_curve(scale),
                             .theta1_radii = theta1_radii_of(options),
                             .balls_above = thinnest_tip(scale, omega)});
  result.topology = topology(result.skeleton.complex);
  checkpoint(context, "skeleton", 1);
  require_topology(result.topology, family.topology, "skeleton", "medial axis");
  if (options.main_axes) {
    result.skeleton = main_axes(result.skeleton);
    result.topology = topology(result.skeleton.complex);
  }
  checkpoint(context, "topology", 1);
  return result;
}

Record skeleton_file(const SkeletonResult& result, const Record& from) {
  const Skeleton& skeleton = result.skeleton;
  Record data = to_record(skeleton);
  const auto copy = [&](std::string_view name) {
    if (const DataArray* array = find_array(from.field_data, name)) data.field_data.push_back(*array);
  };
  for (const char* name : {"dims", "spacing", "origin", "direction", "dimension", "y_axis", "longest_side"}) copy(name);
  for (const MeasureKind& measure : kMeasures) {
    copy(measure.name);
    copy(std::string(measure.name) + "_chosen");
  }
  for (const char* name : {"omega", "propagation", "radius_rule", "surface", "units", "SPACE", "parameters"}) copy(name);
  const auto put = [&](const char* name, DataArray::Values values, int components = 1) {
    data.field_data.push_back({name, components, std::move(values)});
  };
  put("stage", std::vector<std::string>{"skeleton"});
  if (!skeleton.plane) put("theta2", std::vector<double>{std::min(skeleton.theta2, kInfiniteLevelInFiles)});
  put("theta1", std::vector<double>{std::min(skeleton.theta1, kInfiniteLevelInFiles)});
  put("theta1_radii", std::vector<double>{skeleton.theta1_radii});
  if (!skeleton.plane) put("rims_above", std::vector<double>{std::min(skeleton.rims_above, kInfiniteLevelInFiles)});
  put("smooth", std::vector<std::int64_t>{skeleton.smooth});
  put("tips", std::vector<std::string>{skeleton.full_tips ? "full" : "pruned"});
  if (skeleton.main_axes) put("main_axes", std::vector<std::int64_t>{1});
  if (result.reconstructed) put("reconstructed", std::vector<double>{*result.reconstructed});
  put("euler", std::vector<std::int64_t>{result.topology.euler});
  put("betti", std::vector<std::int64_t>(result.topology.betti.begin(), result.topology.betti.end()), 3);
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

namespace {

// Of a plane radii are those of disks in the pixels as they are.
CurveGraph with_half_a_voxel(CurveGraph graph, const GraphOptions& options, bool plane) {
  if (plane) return graph;
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

void check_smooth(const GraphOptions& options) {
  if (options.smooth < 0 || options.smooth > 10000)
    throw Error(ErrorCode::usage, fmt::format("smooth '{}' is not from 0 to 10000", options.smooth), "smooth");
}

}  // namespace

CurveGraph smoothed_graph(const Skeleton& skeleton, const GraphOptions& options, const Scale& scale) {
  check_smooth(options);
  SmoothOptions smoothing{
      options.smooth, scale.resolve(options.resample, "resample"), boundary_gap(options.voxel), {}, scale.fitted};
  if (const VoxelShape* shape = options.shape)
    smoothing.inside = [shape](const Vec3& a, const Vec3& b) { return contains_segment(*shape, a, b); };
  CurveGraph graph = smoothed(curve_graph(skeleton), smoothing);
  if (options.surface)
    measure_radii(graph, [&](const Vec3& point, double& radius) {
      if (const Surface::Foot foot = options.surface->nearest(point); foot.inside) radius = foot.distance;
    });
  if (options.sites)
    measure_radii(graph, [&](const Vec3& point, double& radius) { radius = options.sites->distance(point); });
  return graph;
}

CurveGraph measured_graph(const Skeleton& skeleton, const GraphOptions& options, const Scale& scale) {
  return with_half_a_voxel(smoothed_graph(skeleton, options, scale), options, skeleton.plane);
}

// By no more than half a voxel diagonal.
void smooth_sheets_of(Skeleton& skeleton, const GraphOptions& options, const Scale& scale, Context* context) {
  check_smooth(options);
  if (options.smooth == 0 || skeleton.complex.face_count() == 0) return;
  const std::vector<Vec3> before = skeleton.points;
  smooth_sheets(skeleton, {2 * std::sqrt(options.smooth) * scale.voxel, options.smooth, scale.detail}, context);
  if (!options.surface) return;
  base::for_indices(before.size(), [&](std::size_t v) {
    const double way = (skeleton.points[v] - before[v]).norm();
    if (way == 0) return;
    // It cannot be farther; radii between vertices of the axis are right to a part of a voxel.
    const double within = skeleton.radius[v] + 2 * way + scale.detail;
    if (const Surface::Foot foot = options.surface->nearest(skeleton.points[v], within); foot.inside)
      skeleton.radius[v] = foot.distance;
  });
}

CurveGraph draw_branches(SkeletonResult& result, const GraphOptions& options, const Scale& scale, Context* context) {
  CurveGraph graph = base::in_arena(context, [&] {
    smooth_sheets_of(result.skeleton, options, scale, context);
    return smoothed_graph(result.skeleton, options, scale);
  });
  result.skeleton = with_branches(result.skeleton, graph);
  require_topology(topology(result.skeleton.complex), result.topology, "skeleton with smooth branches", "skeleton");
  if (result.skeleton.plane) add_measures(graph, result.skeleton);
  if (options.extend) {
    if (!options.shape)
      throw Error(ErrorCode::usage,
                  "branches can only be drawn out to the boundary of a shape whose voxels or pixels "
                  "the axis is that of; leave it out, or take the surface 'voxels'",
                  "extend");
    graph = extended(graph, *options.shape);
  }
  return with_half_a_voxel(std::move(graph), options, result.skeleton.plane);
}

}  // namespace quench::pipeline
