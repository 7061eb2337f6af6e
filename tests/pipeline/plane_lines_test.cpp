// SPDX-License-Identifier: Apache-2.0
// Main axes, extended and clipped branches, medial points, and radii between vertices, on runs of pixel shapes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "plane_shapes.h"
#include "quench/pipeline.h"
#include "quench/polygons.h"

namespace quench {
namespace plane_lines_test {

using testing_planes::plane_grid;
using testing_planes::plane_shape;
using testing_planes::random_plane_shape;

struct Done {
  pipeline::LoadedShape shape;
  pipeline::RunResult result;
  const CurveGraph& graph() const { return result.axis.graph; }
  double length() const {
    return std::transform_reduce(graph().branches.begin(), graph().branches.end(), 0.0, std::plus(),
                                 [](const auto& b) { return b.length; });
  }
};

Done run(const VoxelShape& shape, const pipeline::RunOptions& options = {}) {
  Done done{pipeline::shape_of(VoxelShape(shape), shape.grid(), {}), {}};
  done.result = pipeline::run(done.shape, options);
  return done;
}

VoxelShape bar(int width, int height) {
  return plane_shape(plane_grid(width + 4, height + 4),
                     [=](int x, int y) { return x >= 2 && x < width + 2 && y >= 2 && y < height + 2; });
}

// A trunk of 200 pixels with two arms of 60 and 40 at 60 and 120.
VoxelShape tree() {
  return plane_shape(plane_grid(210, 130), [](int x, int y) {
    const bool trunk = x >= 5 && x < 205 && y >= 60 && y < 70, first = x >= 60 && x < 70 && y >= 5 && y < 65,
               second = x >= 120 && x < 130 && y >= 65 && y < 110;
    return trunk || first || second;
  });
}

TEST(PlaneLines, TheMainAxisIsTheLongestWayFromEndToEnd) {
  pipeline::RunOptions options;
  const Done all = run(tree());
  EXPECT_EQ(all.graph().branches.size(), 5u);
  options.skeleton.main_axes = true;
  const Done main = run(tree(), options);
  ASSERT_EQ(main.graph().branches.size(), 1u);
  EXPECT_EQ(main.result.axis.skeleton.topology.betti, (std::array<std::int64_t, 3>{1, 0, 0}));
  EXPECT_NEAR(main.length(), 190, 2);  // from fork to fork of the blunt ends
  for (const Vec3& p : main.graph().branches[0].points) EXPECT_NEAR(p[1], 64.5, 3) << p[0];
}

// By all pairs of ends of the whole graph, on random shapes.
TEST(PlaneLines, MainAxesAreThoseOfBruteForce) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const VoxelShape shape = random_plane_shape(seed, 24);
    pipeline::RunOptions options;
    options.skeleton.theta1 = pipeline::world_length(0.5);
    options.skeleton.full_tips = false;
    options.graph.smooth = 0;
    const Done all = run(shape, options);
    options.skeleton.main_axes = true;
    const Done main = run(shape, options);
    const CurveGraph& graph = all.graph();
    const std::size_t n = graph.nodes.size();
    constexpr double kFar = 1e9;
    std::vector<std::vector<double>> way(n, std::vector<double>(n, kFar));
    for (std::size_t i = 0; i < n; ++i) way[i][i] = 0;
    for (const auto& b : graph.branches) {
      way[b.from][b.to] = std::min(way[b.from][b.to], b.from == b.to ? 0 : b.length);
      way[b.to][b.from] = way[b.from][b.to];
    }
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) way[i][j] = std::min(way[i][j], way[i][k] + way[k][j]);
    std::map<std::uint32_t, double> longest;
    std::map<std::uint32_t, int> ends;
    for (const auto& node : graph.nodes) ends[node.component] += node.kind == CurveGraph::NodeKind::end;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        const bool free = ends[graph.nodes[i].component] < 2 || (graph.nodes[i].kind == CurveGraph::NodeKind::end &&
                                                                 graph.nodes[j].kind == CurveGraph::NodeKind::end);
        if (free && way[i][j] < kFar)
          longest[graph.nodes[i].component] = std::max(longest[graph.nodes[i].component], way[i][j]);
      }
    for (const auto& b : graph.branches)
      if (b.from == b.to && ends[b.component] < 2) longest[b.component] = std::max(longest[b.component], b.length);
    double expected = 0;
    for (const auto& [component, length] : longest) expected += length;
    EXPECT_NEAR(main.length(), expected, 1e-9 * (1 + expected)) << "seed " << seed;
    EXPECT_EQ(main.result.axis.skeleton.topology.betti[0], all.result.axis.skeleton.topology.betti[0]) << seed;
  }
}

TEST(PlaneLines, ExtendedEndsLieOnTheOutline) {
  pipeline::RunOptions options;
  options.graph.extend = true;
  const Done done = run(bar(100, 20), options);
  ASSERT_EQ(done.graph().branches.size(), 1u);
  EXPECT_NEAR(done.length(), 100, 1e-9);
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Done some = run(random_plane_shape(seed, 40), options);
    for (const auto& node : some.graph().nodes) {
      if (node.kind != CurveGraph::NodeKind::end) continue;
      const Vec3 at = some.shape.shape.grid().lattice(node.point);
      const double off = std::min(std::abs(at[0] - std::round(at[0])), std::abs(at[1] - std::round(at[1])));
      EXPECT_LT(off, 1e-9) << "seed " << seed;
      EXPECT_EQ(node.radius, 0) << seed;
    }
    for (const auto& branch : some.graph().branches) {
      EXPECT_EQ(branch.points.size(), branch.radius.size());
      EXPECT_EQ(branch.points.size(), branch.erosion_thickness.size());
      EXPECT_EQ(branch.points.size(), branch.mgf.size());
    }
  }
}

TEST(PlaneLines, BranchesEndWhereTheShapeIsWide) {
  // A disk of radius 30 with a handle 10 wide and 100 long.
  const VoxelShape shape = plane_shape(plane_grid(180, 70), [](int x, int y) {
    const double dx = x - 34.5, dy = y - 34.5;
    return dx * dx + dy * dy < 900 || (x >= 35 && x < 165 && y >= 30 && y < 40);
  });
  pipeline::RunOptions options;
  options.narrower = pipeline::world_length(20);
  const Done done = run(shape, options);
  ASSERT_TRUE(done.result.wide);
  EXPECT_NEAR(static_cast<double>(done.result.wide->voxel_count()), M_PI * 900, 0.05 * M_PI * 900);
  ASSERT_EQ(done.graph().branches.size(), 1u);
  const auto& branch = done.graph().branches[0];
  EXPECT_LT(branch.max_radius, 10);
  std::vector<CurveGraph::NodeKind> kinds;
  for (const auto& node : done.graph().nodes) kinds.push_back(node.kind);
  EXPECT_EQ(std::ranges::count(kinds, CurveGraph::NodeKind::border), 1);
  for (std::size_t i = 1; i < branch.points.size(); ++i) {
    const Vec3 middle = done.shape.shape.grid().lattice(0.5 * (branch.points[i - 1] + branch.points[i]));
    EXPECT_FALSE(
        done.result.wide->contains(static_cast<std::int64_t>(middle[0]), static_cast<std::int64_t>(middle[1]), 0));
  }
  const std::vector<Polygons> parts = parts_of(boundary_rings(*done.result.wide));
  EXPECT_EQ(parts.size(), 1u);
}

TEST(PlaneLines, AMedialPointIsWhereFiresMeet) {
  // Of a bar fire comes to the middle from both ends at the same time.
  const Done done = run(bar(90, 20));
  ASSERT_EQ(done.result.axis.medial_points.size(), 1u);
  const MedialPoint& point = done.result.axis.medial_points[0];
  const Vec3 middle = done.shape.shape.grid().world(Vec3(2 + 45, 2 + 10, 0));
  EXPECT_LT((point.point - middle).norm(), 1);
  EXPECT_NEAR(point.radius, 10, 0.05);
  EXPECT_NEAR(point.burn_time, 45 - 10 + 10 * std::sqrt(2), 1);
  const Done ring = run(plane_shape(plane_grid(60, 60), [](int x, int y) {
    const double d = std::hypot(x - 29.5, y - 29.5);
    return d < 28 && d > 15;
  }));
  EXPECT_TRUE(ring.result.axis.medial_points.empty());
}

// Radii of branches that were drawn are distances to the nearest boundary vertex, by brute force.
TEST(PlaneLines, RadiiAreDistancesToTheOutline) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const std::array<double, 2> spacing = seed % 3 == 0 ? std::array{1.0, 2.0} : std::array{1.0, 1.0};
    const Done done = run(random_plane_shape(seed, 40, spacing));
    const std::vector<LatticePoint> sites = boundary_vertices(done.shape.shape);
    for (const auto& branch : done.graph().branches)
      for (std::size_t i = 0; i < branch.points.size(); ++i) {
        double nearest = 1e9;
        for (const LatticePoint& site : sites)
          nearest = std::min(nearest, (done.shape.shape.grid().world_of(site) - branch.points[i]).norm());
        EXPECT_NEAR(branch.radius[i], nearest, 1e-9) << "seed " << seed;
      }
  }
}

TEST(PlaneLines, SquaresArePointsAndBarsAreLines) {
  for (const int side : {63, 64, 65, 100}) {
    EXPECT_TRUE(run(bar(side, side)).graph().branches.empty()) << side;
    EXPECT_EQ(run(bar(2 * side, side)).graph().branches.size(), 1u) << side;
  }
}

TEST(PlaneLines, PutTogetherTheyAreBoth) {
  const Done a = run(tree()), b = run(bar(60, 12));
  Skeleton both;
  CurveGraph graph;
  for (const Done* done : {&a, &b}) {
    append(graph, done->graph(), both.complex.vertex_count);
    append(both, done->result.axis.skeleton.skeleton);
  }
  EXPECT_EQ(graph.branches.size(), a.graph().branches.size() + b.graph().branches.size());
  EXPECT_EQ(graph.components, 2u);
  EXPECT_EQ(topology(both.complex).betti[0], 2);
  EXPECT_EQ(static_cast<std::size_t>(*std::ranges::max_element(both.edge_branch)) + 1, graph.branches.size());
  both.complex.validate();
}

}  // namespace plane_lines_test
}  // namespace quench
