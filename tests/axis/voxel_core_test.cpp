// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "brute_force_core.h"
#include "full_run.h"
#include "quench/axis.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace voxel_core_test {

// Same cells, positions, radii, sites and lambda as the oracle, cell by cell.
void expect_equals_brute_force(const VoxelShape& shape, const std::string& where) {
  const brute_force::Core expected = brute_force::voxel_core(shape);
  const MedialAxis core = voxel_core(shape);
  const MedialAxis ball = voxel_core(shape, {.rule = LambdaRule::ball});
  ASSERT_NO_THROW(core.complex.validate()) << where;
  ASSERT_EQ(core.sites, expected.sites) << where;
  ASSERT_EQ(core.complex.vertex_count, expected.cells.size()) << where;
  ASSERT_EQ(core.complex.edges.size(), expected.edges.size()) << where;
  ASSERT_EQ(core.complex.face_count(), expected.faces.size()) << where;
  for (std::size_t v = 0; v < expected.cells.size(); ++v) {
    const auto& cell = expected.cells[v];
    ASSERT_NEAR((core.points[v] - cell.position).norm(), 0, 1e-9 * (1 + cell.radius)) << where;
    ASSERT_NEAR(core.radius[v], cell.radius, 1e-12 * cell.radius) << where;
    ASSERT_NEAR(core.measure().value.vertex[v], cell.lambda, 1e-9) << where << " vertex " << v;
    ASSERT_NEAR(ball.measure().value.vertex[v], cell.lambda_ball, 1e-9) << where << " vertex " << v;
  }
  // The oracle sorts edges by their sites, the core by their ends.
  std::vector<std::pair<std::array<std::uint32_t, 2>, std::array<double, 2>>> edges;
  for (const auto& e : expected.edges) edges.push_back({e.cells, {e.lambda, e.lambda_ball}});
  std::sort(edges.begin(), edges.end());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    ASSERT_EQ(core.complex.edges[e], edges[e].first) << where;
    ASSERT_NEAR(core.measure().value.edge[e], edges[e].second[0], 1e-9) << where << " edge " << e;
    ASSERT_NEAR(ball.measure().value.edge[e], edges[e].second[1], 1e-9) << where << " edge " << e;
  }
  for (std::size_t f = 0; f < expected.faces.size(); ++f) {
    const auto& face = expected.faces[f];
    ASSERT_EQ(core.face_sites[f], face.sites) << where;
    ASSERT_DOUBLE_EQ(core.measure().value.face[f], face.lambda) << where;
    std::vector<std::uint32_t> cycle(face.cells.begin(), face.cells.end());
    std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
    std::vector<std::uint32_t> reversed(cycle.rbegin(), cycle.rend());
    std::rotate(reversed.begin(), std::min_element(reversed.begin(), reversed.end()), reversed.end());
    const auto corners = core.complex.corners(f);
    const std::vector<std::uint32_t> mine(corners.begin(), corners.end());
    ASSERT_TRUE(mine == cycle || mine == reversed) << where << " face " << f;
  }
}

TEST(VoxelCore, EqualsBruteForceOnRandomShapes) {
  const std::uint64_t seeds = repeats(1200, 600);
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    expect_equals_brute_force(testing_shapes::random_shape(seed, 7), "seed " + std::to_string(seed));
}

TEST(VoxelCore, EqualsBruteForceOnLargerRandomShapes) {
  for (std::uint64_t seed = 5000; seed < 5020; ++seed)
    expect_equals_brute_force(testing_shapes::random_shape(seed, 14), "seed " + std::to_string(seed));
}

TEST(VoxelCore, EqualsBruteForceOnAnisotropicShapes) {
  for (std::uint64_t seed = 0; seed < 500; ++seed)
    expect_equals_brute_force(testing_shapes::random_shape(seed, 7, true), "anisotropic seed " + std::to_string(seed));
}

TEST(VoxelCore, EqualsBruteForceWithCtSpacing) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VoxelShape unit = testing_shapes::random_shape(seed, 8);
    Grid grid = unit.grid();
    grid.spacing = {0.782, 0.782, 5};
    expect_equals_brute_force(
        testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return unit.contains(x, y, z); }),
        "CT spacing, seed " + std::to_string(seed));
  }
}

// Points of the medial axis are at most half a voxel diagonal from the core (docs/algorithms/voxel_core.md). The axis stands
// as the core of voxels split into 5: within beta / 5 of it. Points of the core only: that can but add to distances.
TEST(VoxelCore, EveryPointOfTheMedialAxisIsNear) {
  constexpr int kParts = 5;
  for (const bool anisotropic : {false, true})
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const VoxelShape shape = testing_shapes::random_shape(seed, 5, anisotropic);
      const MedialAxis core = voxel_core(shape), axis = voxel_core(subdivide(shape, kParts));
      std::vector<Vec3> points = core.points;
      for (const auto& [a, b] : core.complex.edges)
        for (const double t : {0.25, 0.5, 0.75}) points.emplace_back((1 - t) * core.points[a] + t * core.points[b]);
      for (std::size_t f = 0; f < core.complex.face_count(); ++f) {
        Vec3 centre = Vec3::Zero();
        for (const std::uint32_t v : core.complex.corners(f)) centre += core.points[v];
        points.emplace_back(centre / static_cast<double>(core.complex.corners(f).size()));
      }
      Vec3 h = shape.grid().spacing;
      std::sort(h.begin(), h.end());
      const double beta = (h[1] * h[1] + h[2] * h[2]) / (8 * h[0]);
      for (const Vec3& x : axis.points) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& y : points) nearest = std::min(nearest, (x - y).norm());
        ASSERT_LE(nearest, 0.5 * shape.grid().diagonal() + beta / kParts) << "seed " << seed;
      }
    }
}

// Cells of unbounded size: more sites on one sphere than any fixed-size array would hold.
TEST(VoxelCore, HugeCosphericalSets) {
  for (int r : {3, 5, 7}) {
    Grid grid;
    grid.dims = {2 * r + 2, 2 * r + 2, 2 * r + 2};
    expect_equals_brute_force(testing_shapes::from_predicate(grid,
                                                             [r](int x, int y, int z) {  // centred on a lattice point
                                                               const double a = x - r - 0.5, b = y - r - 0.5,
                                                                            c = z - r - 0.5;
                                                               return a * a + b * b + c * c < r * r;
                                                             }),
                              "ball");
    grid.dims = {2 * r + 2, 2 * r + 2, 9};
    expect_equals_brute_force(testing_shapes::from_predicate(grid,
                                                             [r](int x, int y, int z) {
                                                               const double a = x - r - 0.5, b = y - r - 0.5;
                                                               return z > 0 && z < 8 && a * a + b * b < r * r;
                                                             }),
                              "cylinder");
  }
  expect_equals_brute_force(testing_shapes::box_shape(9, 8, 2), "flat box");
  expect_equals_brute_force(testing_shapes::box_shape(2, 2, 11), "2x2x11 bar");
  expect_equals_brute_force(testing_shapes::box_shape(6, 6, 6), "cube");
}

TEST(VoxelCore, OneVoxelIsAPointAndAThinBarIsALine) {
  const MedialAxis point = voxel_core(testing_shapes::box_shape(1, 1, 1));
  EXPECT_EQ(point.complex.vertex_count, 1u);
  EXPECT_TRUE(point.complex.edges.empty());
  EXPECT_NEAR(point.radius[0], std::sqrt(0.75), 1e-15);
  EXPECT_NEAR(point.measure().value.vertex[0], std::sqrt(0.75), 1e-14);

  const MedialAxis line = voxel_core(testing_shapes::box_shape(1, 1, 7));
  EXPECT_EQ(line.complex.vertex_count, 7u);
  EXPECT_EQ(line.complex.edges.size(), 6u);
  EXPECT_EQ(line.complex.face_count(), 0u);
  for (double lambda : line.measure().value.edge)
    EXPECT_NEAR(lambda, std::sqrt(0.5), 1e-14);  // the ball of a voxel face
}

TEST(VoxelCore, LambdaOfCosphericalEdgesUnderBothRules) {
  // The 2x2xn bar has 0.71 under the default rule and 1 under the dissertation's.
  const VoxelShape bar = testing_shapes::box_shape(2, 2, 9);
  const auto middle = [&](const MedialAxis& axis) {
    double value = 0;
    for (std::size_t e = 0; e < axis.complex.edges.size(); ++e) {
      const auto& [u, v] = axis.complex.edges[e];
      const Vec3 c = 0.5 * (axis.points[u] + axis.points[v]);
      if ((c - Vec3(1.5, 1.5, 4.5)).norm() < 1) value = std::max(value, axis.measure().value.edge[e]);
    }
    return value;
  };
  EXPECT_NEAR(middle(voxel_core(bar)), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(middle(voxel_core(bar, {.rule = LambdaRule::ball})), 1, 1e-12);
}

}  // namespace voxel_core_test
}  // namespace quench
