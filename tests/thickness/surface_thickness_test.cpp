// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "quench/error.h"
#include "quench/samples.h"
#include "quench/thickness.h"
#include "quench/solid_stages.h"

namespace quench {
namespace surface_thickness_test {

TEST(SurfaceThickness, IsThatOfTheLargestBallThatTouches) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto anywhere = [&](double reach) -> Vec3 { return reach * Vec3(unit(random), unit(random), unit(random)); };
  for (int round = 0; round < 60; ++round) {
    MedialAxis axis;
    const int count = 1 + static_cast<int>(random() % 300);
    for (int v = 0; v < count; ++v) {
      axis.points.push_back(anywhere(5));
      axis.radius.push_back(std::abs(unit(random)) * (1 + unit(random)));
    }
    std::vector<Vec3> points;
    for (int p = 0; p < 200; ++p) points.push_back(anywhere(6));
    const double tolerance = round % 3 * 0.3;
    const SurfaceThickness found = surface_thickness(points, nullptr, axis, {tolerance, 0.25});
    EXPECT_TRUE(found.across.empty());
    std::size_t near = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      double largest = -1, least_outside = std::numeric_limits<double>::infinity(), of_nearest = 0;
      for (std::size_t v = 0; v < axis.points.size(); ++v) {
        const double outside = (points[p] - axis.points[v]).norm() - axis.radius[v];
        if (outside <= tolerance) largest = std::max(largest, axis.radius[v]);
        if (outside < least_outside) of_nearest = axis.radius[v];
        least_outside = std::min(least_outside, outside);
      }
      near += largest < 0;
      EXPECT_DOUBLE_EQ(found.thickness[p], 2 * (largest < 0 ? of_nearest : largest) + 0.5);
    }
    EXPECT_EQ(found.near, near);
  }
}

TEST(SurfaceThickness, PointsThatAreNone) {
  MedialAxis axis;
  const std::vector<Vec3> points{Vec3(0, 0, std::nan(""))};
  EXPECT_THROW(surface_thickness(points, nullptr, axis, {}), Error);
  axis.points = {Vec3::Zero()};
  axis.radius = {1};
  const SurfaceThickness found = surface_thickness(points, nullptr, axis, {});
  EXPECT_EQ(found.ball[0], kNone);
  EXPECT_EQ(found.thickness[0], 0);
}

TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.points.push_back(Vec3(i & 1, i >> 1 & 1, i >> 2).cwiseProduct(size));
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<std::uint32_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

// Each triangle in four, so that vertices lie in the middle of walls.
TriangleMesh finer(const TriangleMesh& mesh) {
  TriangleMesh result = mesh;
  result.triangles.clear();
  for (const auto& t : mesh.triangles) {
    const auto n = static_cast<std::uint32_t>(result.points.size());
    for (std::size_t i = 0; i < 3; ++i) result.points.push_back((mesh.points[t[i]] + mesh.points[t[(i + 1) % 3]]) / 2);
    result.triangles.insert(result.triangles.end(),
                            {{t[0], n, n + 2}, {t[1], n + 1, n}, {t[2], n + 2, n + 1}, {n, n + 1, n + 2}});
  }
  return result;
}

TEST(MeasuredSurface, OfAPlate) {
  TriangleMesh mesh = box_mesh({10, 8, 1});
  for (int i = 0; i < 4; ++i) mesh = finer(mesh);
  pipeline::ShapeOptions options;
  options.resolution = 100;
  options.keep_mesh = true;
  const std::vector<Vec3> points = mesh.points;
  const pipeline::LoadedShape shape = pipeline::shape_of(std::move(mesh), options);
  const pipeline::MeasuredSurface surface = pipeline::measured_surface(shape);
  ASSERT_EQ(surface.mesh.points.size(), points.size());
  EXPECT_EQ(surface.correction, 0);
  std::size_t inside = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    EXPECT_EQ(surface.mesh.points[p], points[p]);
    const Vec3& q = points[p];
    if (q[0] < 1 || q[0] > 9 || q[1] < 1 || q[1] > 7) continue;  // near edges balls are smaller
    ++inside;
    EXPECT_NEAR(surface.thickness.thickness[p], 1, 0.01);
    const Vec3 across(q[0], q[1], 1 - q[2]);
    EXPECT_LT((surface.thickness.across[p] - across).norm(), 0.2);
    EXPECT_NEAR(surface.thickness.across[p][2], across[2], 1e-6);
  }
  EXPECT_GT(inside, 200u);
  const Record file = pipeline::surface_file(surface);
  file.validate();
  for (const char* name : {"thickness", "across_x", "across_y", "across_z"})
    EXPECT_TRUE(find_array(file.point_data, name)) << name;
}

TEST(MeasuredSurface, OfABall) {
  Sample sample = make_sample("ellipsoid");
  for (Vec3& p : sample.mesh.points) p.normalize();  // a ball of radius 1
  pipeline::ShapeOptions options;
  options.resolution = 64;
  options.keep_mesh = true;
  const pipeline::LoadedShape shape = pipeline::shape_of(std::move(sample.mesh), options);
  const pipeline::MeasuredSurface surface = pipeline::measured_surface(shape);
  for (std::size_t p = 0; p < surface.mesh.points.size(); ++p) {
    EXPECT_NEAR(surface.thickness.thickness[p], 2, 0.05);
    EXPECT_LT((surface.thickness.across[p] + surface.mesh.points[p]).norm(), 0.2);
  }
  EXPECT_NEAR(surface.distribution.weight(), 12.5, 0.2);  // the area
  EXPECT_NEAR(surface.distribution.mean(), 2, 0.03);
}

TEST(WholeCore, IsTheVoxelCore) {
  Sample sample = make_sample("torus", {.fineness = 0.3});
  pipeline::ShapeOptions options;
  options.resolution = 40;
  const pipeline::LoadedShape shape = pipeline::shape_of(std::move(sample.mesh), options);
  const MedialAxis whole = pipeline::whole_core(shape), core = voxel_core(shape.shape);
  EXPECT_EQ(whole.complex.edges, core.complex.edges);
  EXPECT_EQ(whole.radius, core.radius);
  EXPECT_DOUBLE_EQ(thickness_correction(whole), shape.shape.grid().spacing.minCoeff() / 2);
}

TEST(Complement, IsWhatIsNotThere) {
  Sample sample = make_sample("torus", {.fineness = 0.3});
  pipeline::ShapeOptions options;
  options.resolution = 40;
  const pipeline::LoadedShape shape = pipeline::shape_of(std::move(sample.mesh), options);
  const pipeline::LoadedShape rest = pipeline::complement_of(shape);
  const auto& dims = shape.shape.grid().dims;
  EXPECT_EQ(rest.shape.voxel_count() + shape.shape.voxel_count(), dims[0] * dims[1] * dims[2]);
  rest.shape.validate();
  EXPECT_EQ(rest.topology.betti[1], 1);
}

}  // namespace surface_thickness_test
}  // namespace quench
