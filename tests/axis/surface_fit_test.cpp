// SPDX-License-Identifier: Apache-2.0
// Medial axes fitted to surfaces (docs/algorithms/surface_fit.md).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "quench/axis.h"
#include "quench/error.h"
#include "quench/samples.h"
#include "quench/voxelize.h"

namespace quench {
namespace surface_fit_test {

struct Fitted {
  VoxelShape shape;
  Surface surface;
  MedialAxis axis;
};

Eigen::Quaterniond turn_of(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> any;
  return Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
}

TriangleMesh turned(TriangleMesh mesh, std::uint64_t seed) {
  const Eigen::Quaterniond turn = turn_of(seed);
  for (Vec3& p : mesh.points) p = turn * p;
  return mesh;
}

Fitted fitted(const TriangleMesh& mesh, std::int64_t resolution, std::optional<double> detail = {}) {
  VoxelizeOptions options;
  options.resolution = resolution;
  VoxelShape shape = voxelize(mesh, options).shape;
  Surface surface(mesh, SurfaceKind::mesh);
  MedialAxis axis = medial_axis(shape, surface, detail);
  return {std::move(shape), std::move(surface), std::move(axis)};
}

TriangleMesh sample(const char* name) { return make_sample(name, {}).mesh; }

TEST(FitToSurface, BallsLieInsideAndTouchAndPointsMoveALittle) {
  for (const char* name : {"ellipsoid", "torus", "box", "fin-on-board", "plate-with-holes", "four-blobs"}) {
    const Fitted f = fitted(turned(sample(name), 7), 48);
    const double most = kLargestMove * f.shape.grid().spacing.maxCoeff();
    const MedialAxis before = [&] {
      MedialAxis whole = voxel_core(f.shape);
      add_detail(whole, f.surface);
      prune_levels(whole, kDetail);
      return pruned(whole, auto_detail(f.shape.grid()), kDetail);
    }();
    EXPECT_EQ(f.axis.complex.edges, before.complex.edges) << name;
    EXPECT_EQ(f.axis.complex.face_vertices, before.complex.face_vertices) << name;
    EXPECT_EQ(f.axis.voxel_points, before.points) << name;
    EXPECT_EQ(f.axis.voxel_radius, before.radius) << name;
    EXPECT_EQ(topology(f.axis.complex), topology(f.shape)) << name;
    for (std::size_t v = 0; v < f.axis.points.size(); ++v) {
      ASSERT_LE((f.axis.points[v] - f.axis.voxel_points[v]).norm(), most * (1 + 1e-12)) << name;
      const Surface::Foot foot = f.surface.nearest(f.axis.points[v]);
      ASSERT_EQ(f.axis.radius[v], foot.inside ? foot.distance : 0) << name;
    }
    EXPECT_LE(coverage(f.shape, f.axis), 2 * auto_detail(f.shape.grid()) * (1 + 1e-9)) << name;
  }
}

// The axis of a torus is a circle, its radius known; unfitted, vertices are 0.6 voxel off and radii 0.6 short.
TEST(FitToSurface, TheCurveOfATorusIsItsCircle) {
  for (const std::uint64_t seed : {0, 1, 2}) {
    const Fitted f = fitted(turned(sample("torus"), seed), 96, 0.2);
    const double voxel = f.shape.grid().spacing[0];
    // The circle's plane, from the mesh that was turned with it.
    double off = 0, wrong = 0;
    for (std::size_t v = 0; v < f.axis.points.size(); ++v) {
      const Vec3 p = turn_of(seed).inverse() * f.axis.points[v];
      const double away = std::hypot(std::hypot(p[0], p[1]) - 1, p[2]);
      off += away;
      wrong += std::abs(f.axis.radius[v] - (0.35 - away));
    }
    const auto count = static_cast<double>(f.axis.points.size());
    EXPECT_LT(off / count, 0.15 * voxel) << seed;
    EXPECT_LT(wrong / count, 0.02 * voxel) << seed;
  }
}

// The sheet of an ellipsoid lies in the plane of its two longer axes, in any position.
TEST(FitToSurface, TheSheetOfAnEllipsoidIsFlat) {
  for (const std::uint64_t seed : {3, 4}) {
    const Fitted f = fitted(turned(sample("ellipsoid"), seed), 96);
    std::vector<double> height;
    for (const Vec3& p : f.axis.points)
      height.push_back(std::abs((turn_of(seed).inverse() * p)[2]) / f.shape.grid().spacing[0]);
    std::ranges::sort(height);
    EXPECT_LT(height[height.size() / 2], 0.03) << seed;
    EXPECT_LT(height[height.size() * 9 / 10], 0.25) << seed;
  }
}

// What noise leaves near the axis of a round limb reaches far out on the voxels, not on the surface.
TEST(FitToSurface, BladesThatTheSurfaceDoesNotBearOutGo) {
  const TriangleMesh mesh = sample("torus");
  const Fitted f = fitted(mesh, 128);
  const MedialAxis voxels = medial_axis(f.shape);
  const auto farthest = [&](const std::vector<Vec3>& points) {
    double most = 0;
    for (const Vec3& p : points) most = std::max(most, std::hypot(std::hypot(p[0], p[1]) - 1, p[2]));
    return most / f.shape.grid().spacing[0];
  };
  EXPECT_GT(farthest(voxels.points), 10);
  EXPECT_LT(farthest(f.axis.points), 5);
}

TEST(FitToSurface, PruningFurtherIsTheFitOfThatPruning) {
  const TriangleMesh mesh = sample("fin-on-board");
  const Fitted least = fitted(mesh, 64, 0);
  for (const double voxels : {0.5, 0.87, 1.5, 3.0}) {
    const double detail = voxels * least.shape.grid().spacing[0];
    const MedialAxis further = pruned(least.axis, detail, kDetail), at_once = fitted(mesh, 64, detail).axis;
    EXPECT_EQ(further.complex.edges, at_once.complex.edges) << voxels;
    if (detail < auto_detail(least.shape.grid())) continue;
    EXPECT_EQ(further.points, at_once.points) << voxels;
    EXPECT_EQ(further.radius, at_once.radius) << voxels;
    EXPECT_EQ(further.voxel_points, at_once.voxel_points) << voxels;
  }
}

TEST(FitToSurface, DoesNotDependOnThreads) {
  const TriangleMesh mesh = turned(sample("bumpy-sphere"), 5);
  VoxelizeOptions options;
  options.resolution = 64;
  const VoxelShape shape = voxelize(mesh, options).shape;
  Context one, three;
  one.threads = 1;
  three.threads = 3;
  const MedialAxis a = medial_axis(shape, Surface(mesh, SurfaceKind::mesh, &one), {}, &one);
  const MedialAxis b = medial_axis(shape, Surface(mesh, SurfaceKind::mesh, &three), {}, &three);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.complex.edges, b.complex.edges);
}

// A plate of 0.6 voxels, one layer of them, whose corners all lie outside it: the centre of every ball is brought
// inside.
TEST(FitToSurface, PlatesThinnerThanAVoxelHaveTheirOwnRadii) {
  TriangleMesh plate = sample("box");  // 2 x 1.4 x 1
  for (Vec3& p : plate.points) p = Vec3(p[0], p[1], 0.018 * p[2]);
  VoxelizeOptions options;
  options.resolution = 65;
  const VoxelShape shape = voxelize(plate, options).shape;
  const Surface surface(plate, SurfaceKind::mesh);
  const MedialAxis axis = medial_axis(shape, surface);
  const double voxel = shape.grid().spacing[0];
  ASSERT_LT(0.018, 0.6 * voxel);
  std::size_t right = 0;
  for (std::size_t v = 0; v < axis.points.size(); ++v)
    right += std::abs(axis.radius[v] - 0.009) < 0.01 * voxel && std::abs(axis.points[v][2]) < 0.01 * voxel;
  EXPECT_GT(static_cast<double>(right), 0.9 * static_cast<double>(axis.points.size()));
}

TEST(FitToSurface, NeedsSitesOfEachVertex) {
  Fitted f = fitted(sample("box"), 20);
  EXPECT_THROW(fit_to_surface(f.axis, {}, f.surface), Error);
  MedialAxis whole = voxel_core(f.shape);
  EXPECT_THROW(static_cast<void>(contact_sites(whole, 1, kDetail)), Error);
}

}  // namespace surface_fit_test
}  // namespace quench
