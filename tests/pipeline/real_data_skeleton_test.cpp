// SPDX-License-Identifier: Apache-2.0
// Burning, medial curves, skeletons and curve graphs of real data. QUENCH_TEST_FULL=1: every closed mesh at 512.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "burning/network.h"
#include "data.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/graph.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/voxelize.h"

namespace quench {
namespace real_data_skeleton_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

MedialAxis pruned_core(const VoxelShape& shape, double longest_side) {
  MedialAxis core = voxel_core(shape);
  prune_levels(core);
  const double lambda = auto_lambda(Reconstruction(shape, core), longest_side, shape.grid().spacing.minCoeff());
  return pruned(core, lambda);
}

// Between the ends of an edge, fire takes at most its length and the radius changes by at most its length, so on the
// manifold part of an axis erosion thickness is 2-Lipschitz (Yan 2018, sec. 3.3).
void expect_lipschitz(const MedialAxis& axis, const Burning& fire, double voxel, const std::string& where) {
  const burning::BurnNetwork& network = fire.sectors->network;
  for (std::uint32_t e = 0; e < axis.complex.edges.size(); ++e) {
    if (network.face_corners_at(e).size() > 2 || network.face_corners_at(e).empty()) continue;
    const auto [a, b] = axis.complex.edges[e];
    bool sheet = true;  // both ends have one sector: the burn time of a vertex is the latest of all
    for (const std::uint32_t v : {a, b}) sheet = sheet && network.vertex_base[v + 1] - network.vertex_base[v] == 1;
    if (!sheet || !std::isfinite(fire.burn_time[a]) || !std::isfinite(fire.burn_time[b])) continue;
    const double length = (axis.points[a] - axis.points[b]).norm();
    ASSERT_LE(std::abs(fire.erosion_thickness[a] - fire.erosion_thickness[b]), 2 * length + 1e-3 * voxel)
        << where << ": edge " << e;
  }
}

// Ends and junctions by component, and the components that have no curves: smoothing must keep them all.
std::map<std::pair<std::uint32_t, int>, std::size_t> kinds(const CurveGraph& graph) {
  std::map<std::pair<std::uint32_t, int>, std::size_t> count;
  for (const CurveGraph::Node& n : graph.nodes) ++count[{n.component, static_cast<int>(n.kind)}];
  return count;
}

void expect_skeletons(const VoxelShape& shape, double longest_side, const std::string& where) {
  const double voxel = shape.grid().spacing.minCoeff();
  const Topology wanted = topology(shape);
  const MedialAxis axis = pruned_core(shape, longest_side);
  const Burning burning = burn(axis.complex, axis.points, axis.radius);
  for (const double et : burning.erosion_thickness) ASSERT_GE(et, 0) << where;
  expect_lipschitz(axis, burning, voxel, where);

  const SkeletonFamily family = skeletons(quench_curves(axis.complex, axis.points, axis.radius, burning));
  EXPECT_EQ(topology(family.refined.complex), wanted) << where << ": the refined axis";
  for (const double thickness : family.curve_thickness) ASSERT_GE(thickness, 0) << where;
  struct Member {
    double theta2, theta1, tips;
  };
  for (const Member& m : {Member{0.03, 0.02, kInfinity}, Member{0.03, 0.02, voxel}, Member{kInfinity, 0.02, voxel},
                          Member{kInfinity, kInfinity, kInfinity}, Member{0.005, 0.005, kInfinity}}) {
    const Skeleton skeleton =
        extract(family, m.theta2 * longest_side, m.theta1 * longest_side, {.regrow_tips_above = m.tips});
    const std::string what = where + ", theta2 " + std::to_string(m.theta2) + ", theta1 " + std::to_string(m.theta1);
    ASSERT_NO_THROW(skeleton.complex.validate()) << what;
    EXPECT_EQ(topology(skeleton.complex), wanted) << what;
  }

  const Skeleton curves = extract(family, kInfinity, 0.02 * longest_side, {false, voxel});
  const CurveGraph graph = curve_graph(curves);
  SmoothOptions smoothing{10, 2 * voxel, boundary_gap(shape.grid().spacing), {}};
  smoothing.inside = [&](const Vec3& a, const Vec3& b) { return contains_segment(shape, a, b); };
  const CurveGraph smooth = smoothed(graph, smoothing);
  EXPECT_EQ(kinds(smooth), kinds(graph)) << where;
  ASSERT_EQ(smooth.branches.size(), graph.branches.size()) << where;
  for (std::size_t b = 0; b < graph.branches.size(); ++b) {
    const CurveGraph::Branch &before = graph.branches[b], &after = smooth.branches[b];
    EXPECT_EQ(after.points.front(), before.points.front()) << where;
    EXPECT_EQ(after.points.back(), before.points.back()) << where;
    for (std::size_t i = 1; i < after.points.size(); ++i)
      ASSERT_TRUE(contains_segment(shape, after.points[i - 1], after.points[i])) << where << ": branch " << b;
  }
}

class SkeletonsOfMeshes : public testing::TestWithParam<const char*> {};

TEST_P(SkeletonsOfMeshes, HaveTheTopologyOfTheShape) {
  const std::string name = std::string("meshes/") + GetParam();
  REQUIRE_DATA(name.c_str());
  const std::int64_t resolution = std::getenv("QUENCH_TEST_FULL") ? 512 : 64;
  const Voxelization v =
      voxelize(to_triangle_mesh(io::read_record(data_file(name.c_str()))), {.resolution = resolution});
  expect_skeletons(v.shape, v.longest_side, name);
}

INSTANTIATE_TEST_SUITE_P(Data, SkeletonsOfMeshes,
                         testing::Values("abc_00000802.obj", "armadillo.off", "block.off", "bunny_closed.off",
                                         "casting.off", "elk.off", "fandisk.off", "fertility.off", "kitten.obj",
                                         "lucy.ply", "neptune.off", "octopus.off", "vessel.off"),
                         [](const auto& test) { return std::filesystem::path(test.param).stem().string(); });

struct VolumeCase {
  const char* file;
  double threshold;
};
class SkeletonsOfVolumes : public testing::TestWithParam<VolumeCase> {};

TEST_P(SkeletonsOfVolumes, HaveTheTopologyOfTheShape) {
  const auto& [file, threshold] = GetParam();
  REQUIRE_DATA(file);
  const VoxelShape shape = foreground(io::read_volume(data_file(file)), {.threshold = threshold, .label = {}});
  expect_skeletons(shape, shape.longest_side(), file);
}

INSTANTIATE_TEST_SUITE_P(
    Data, SkeletonsOfVolumes,
    testing::Values(VolumeCase{"references/bunny7.nrrd", 1}, VolumeCase{"volumes/Al.100.vol", 1},
                    VolumeCase{"volumes/xyz-dragon-256.vol", 1}, VolumeCase{"volumes/emd_5625.map", 1.991},
                    VolumeCase{"volumes/lobster.vol", 80}, VolumeCase{"volumes/maize_root_ct.nrrd", 20}),
    [](const auto& test) {
      std::string name = std::filesystem::path(test.param.file).stem().string();
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
      return name;
    });

}  // namespace real_data_skeleton_test
}  // namespace quench
