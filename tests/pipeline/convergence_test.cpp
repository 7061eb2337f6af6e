// SPDX-License-Identifier: Apache-2.0
// Theorems 2.5.1 to 2.5.4 of Yan 2018 at low resolution, on solids with known reach and medial axis. The tables of
// notes/convergence.md go further (bench_convergence).
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "one_sided_distance.h"
#include "quench/axis.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "smooth_shapes.h"
#include "voxelization_distance.h"

namespace quench {
namespace convergence_test {

using smooth::Solid;

// --- the truth itself -------------------------------------------------------------------------------------------

TEST(SmoothShapes, NormalsMeetTheMedialAxisWithinTheRadius) {
  // Walking from a surface point along the inward normal, the surface point stays the nearest one up to the axis: the
  // distance to the surface grows like the way, until the medial axis is reached.
  for (const auto& solid : smooth::solids())
    for (const auto& s : smooth::surface_sample(*solid, 2000)) {
      EXPECT_NEAR(solid->signed_distance(s.point), 0, 1e-12);
      for (const double way : {-0.9, -0.3, 0.3, 0.9}) {
        const Vec3 x = s.point + way * solid->reach * s.normal;
        EXPECT_NEAR(solid->signed_distance(x), way * solid->reach, 1e-9) << solid->name;
        EXPECT_EQ(solid->inside(x), way < 0) << solid->name;
      }
      EXPECT_GE(solid->axis_distance(s.point, 0), solid->reach - 1e-9) << solid->name;
    }
}

TEST(SmoothShapes, LambdaOfTheEllipsoidIsHalfTheDistanceOfItsTwoNearestSurfacePoints) {
  const smooth::Ellipsoid solid;
  const auto sample = smooth::surface_sample(solid, 1500);
  for (const auto& s : sample) {
    const double lambda = std::abs(s.point[2]);
    if (lambda < 0.01 || lambda > 0.39) continue;
    const double radius = lambda / std::abs(s.normal[2]);
    const Vec3 medial = s.point - radius * s.normal;  // where the normal meets z = 0
    ASSERT_NEAR(medial[2], 0, 1e-12);
    for (const auto& other : sample) ASSERT_GT((other.point - medial).norm(), radius - 1e-12);  // an empty ball
    ASSERT_NEAR(solid.axis_distance(medial, lambda * (1 - 1e-9)), 0, 1e-6);  // on the rim of that lambda-axis
    ASSERT_GT(solid.axis_distance(medial, lambda + 1e-3), 1e-6);
  }
}

TEST(SmoothShapes, AxisAsTrianglesLiesOnTheAxis) {
  for (const auto& solid : smooth::solids()) {
    const double lambda = 0.065 * solid->longest_side;
    const smooth::Soup axis = solid->axis(lambda);
    for (const auto& t : axis.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 middle = 0.5 * (axis.points[t[i]] + axis.points[t[(i + 1) % 3]]);
        ASSERT_LT(solid->axis_distance(axis.points[t[i]], lambda), 1e-12) << solid->name;
        ASSERT_LT(solid->axis_distance(middle, lambda), 1e-5 * solid->longest_side) << solid->name;
      }
  }
}

TEST(SmoothShapes, DigitizationAgreesWithTheVoxelizedSample) {
  for (const auto& solid : smooth::solids()) {
    const Voxelization v = voxelize(make_sample(solid->name).mesh, {.resolution = 64});
    const VoxelShape exact = smooth::digitize(*solid, v.shape.grid());
    EXPECT_NEAR(static_cast<double>(exact.voxel_count()), static_cast<double>(v.shape.voxel_count()),
                5e-4 * static_cast<double>(exact.voxel_count()))
        << solid->name;
    const Grid own = smooth::grid_for(*solid, 64, 0);
    EXPECT_EQ(own.dims, v.shape.grid().dims) << solid->name;
    EXPECT_NEAR((own.origin - v.shape.grid().origin).norm(), 0, 1e-5) << solid->name;
  }
}

// --- Theorem 2.5.1 ----------------------------------------------------------------------------------------------

TEST(Convergence, VoxelsAreAsNearToTheSolidAsPromised) {
  for (const auto& solid : smooth::solids())
    for (const std::int64_t resolution : {32, 64, 96})
      for (const std::uint64_t tilt : {0u, 1u}) {
        const Grid grid = smooth::grid_for(*solid, resolution, tilt);
        ASSERT_LT(grid.spacing[0], 2 * std::sqrt(3.0) / 3 * solid->reach);
        const auto d = smooth::voxelization_distances(*solid, smooth::digitize(*solid, grid), 8000);
        EXPECT_LT(d.vertices_to_surface, (std::sqrt(2.0) + std::sqrt(3.0)) / 2) << solid->name << resolution;
        EXPECT_LT(d.surface_to_vertices, (std::sqrt(2.0) + std::sqrt(3.0)) / 2) << solid->name << resolution;
        EXPECT_LT(d.voxels_to_solid, std::sqrt(3.0) / 2) << solid->name << resolution;
        EXPECT_LT(d.solid_to_voxels, std::sqrt(3.0) / 2) << solid->name << resolution;
        // Not vacuous: voxels cannot follow a curved surface.
        EXPECT_GT(d.vertices_to_surface, 0.5);
        EXPECT_GT(d.surface_to_vertices, 0.5);
      }
}

// --- Theorems 2.5.2 and 2.5.3 -----------------------------------------------------------------------------------

TEST(Convergence, TopologyIsTheSolidsFromThePromisedResolutionOn) {
  for (const auto& solid : smooth::solids())
    for (std::int64_t resolution = 1; resolution <= 40; ++resolution)
      for (std::uint64_t tilt = 0; tilt < 3; ++tilt) {
        const Grid grid = smooth::grid_for(*solid, resolution, tilt);
        if (grid.spacing[0] >= solid->reach / std::sqrt(3.0)) continue;
        const VoxelShape shape = smooth::digitize(*solid, grid);
        ASSERT_EQ(topology(shape), solid->topology) << solid->name << " " << resolution << " tilt " << tilt;
        if (resolution % 4 != 0) continue;
        ASSERT_EQ(topology(voxel_core(shape).complex), solid->topology) << solid->name << " " << resolution;
      }
}

// --- Theorem 2.5.4 ----------------------------------------------------------------------------------------------

// The theorem speaks of the limit and of the larger of the two distances; from one resolution to the next a single
// one-sided distance may rise (the ellipsoid's from core to axis does, from 64 to 128).
TEST(Convergence, PrunedCoreApproachesTheLambdaMedialAxis) {
  for (const auto& solid : smooth::solids()) {
    const double lambda = 0.065 * solid->longest_side;
    double last = std::numeric_limits<double>::infinity();
    for (const std::int64_t resolution : {64, 128, 256}) {
      const Grid grid = smooth::grid_for(*solid, resolution, 1);
      MedialAxis core = voxel_core(smooth::digitize(*solid, grid));
      prune_levels(core);
      const auto d = smooth::axis_distances(pruned(core, lambda), *solid, lambda);
      const double hausdorff = std::max(d.core_to_axis, d.axis_to_core);
      const std::string where = solid->name + " at " + std::to_string(resolution);
      EXPECT_LT(hausdorff, 0.75 * last) << where;
      EXPECT_LT(hausdorff, (resolution > 64 ? 2.5 : 4) * grid.spacing[0]) << where;
      last = hausdorff;
    }
  }
}

// --- Fig. 2.11 --------------------------------------------------------------------------------------------------

TEST(Convergence, ThinBridgesHoldAtResolution256) {
  const Voxelization v = voxelize(make_sample("four-blobs").mesh, {.resolution = 256});
  const Topology ball{1, {1, 0, 0}};
  EXPECT_EQ(topology(v.shape), ball);
  EXPECT_FALSE(v.topology_changed);
  MedialAxis core = voxel_core(v.shape);
  prune_levels(core);
  EXPECT_EQ(topology(core.complex), ball);
  for (const double lambda : {0.005, 0.02, 0.1})
    EXPECT_EQ(topology(pruned(core, lambda * v.longest_side).complex), ball) << lambda;
  EXPECT_EQ(topology(pruned(core, std::numeric_limits<double>::infinity()).complex), ball);
}

}  // namespace convergence_test
}  // namespace quench
