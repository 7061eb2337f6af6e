// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "closed_surfaces.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "quench/voxelize.h"

namespace quench {
namespace volume_surface_test {

using namespace testing_surfaces;
using pipeline::LoadedShape;

// Two balls of different radii, one with a cavity, whose values fall with the distance to their surfaces.
Volume balls() {
  Volume volume;
  volume.grid.dims = {40, 22, 22};
  volume.grid.spacing = {0.5, 0.5, 1};
  volume.grid.origin = {3, -2, 7};
  volume.grid.direction = Vec3(-1, 1, 1).asDiagonal();
  std::vector<std::uint8_t> samples;
  for (int z = 0; z < 22; ++z)
    for (int y = 0; y < 22; ++y)
      for (int x = 0; x < 40; ++x) {
        const Vec3 p(x, y, z);
        const double first = (p - Vec3(11, 11, 11)).norm(), second = 4 - (p - Vec3(30, 11, 11)).norm();
        const double inside = std::max(std::min(8 - first, first - 3), second);
        samples.push_back(static_cast<std::uint8_t>(std::lround(100 + 30 * std::clamp(inside, -3.0, 3.0))));
      }
  volume.samples = std::move(samples);
  return volume;
}

pipeline::ShapeOptions at_least_100() {
  pipeline::ShapeOptions options;
  options.foreground.threshold = 100.0;
  return options;
}

LoadedShape loaded(const Volume& volume, const pipeline::ShapeOptions& options) {
  return pipeline::shape_of(view_of(volume), {}, options);
}

TEST(VolumeSurface, IsThatOfGreyValuesAndHasTheTopologyOfTheShape) {
  pipeline::ShapeOptions options = at_least_100();
  const LoadedShape both = loaded(balls(), options);
  ASSERT_TRUE(both.surface);
  EXPECT_EQ(both.surface->kind(), SurfaceKind::grey);
  EXPECT_NE(both.parameters.find(R"("surface":"grey")"), std::string::npos);
  EXPECT_EQ(components_of(both.surface->mesh()), 3);

  options.foreground.largest_component = true;
  const LoadedShape one = loaded(balls(), options);
  EXPECT_EQ(components_of(one.surface->mesh()), 2);
  options.foreground.fill_cavities = true;
  const LoadedShape filled = loaded(balls(), options);
  EXPECT_EQ(components_of(filled.surface->mesh()), 1);
  EXPECT_EQ(euler_of(filled.surface->mesh()), 2);
  const double ball = 4 * M_PI / 3 * std::pow(8, 3) * 0.25;  // voxels of a quarter
  EXPECT_NEAR(volume_of(filled.surface->mesh()), ball, 0.02 * ball);

  options.subdivide = 2;
  const LoadedShape fine = loaded(balls(), options);
  EXPECT_EQ(fine.surface->mesh().points, filled.surface->mesh().points);
}

TEST(VolumeSurface, IsSaidAndReadAgain) {
  pipeline::ShapeOptions options = at_least_100();
  options.surface = SurfaceKind::voxels;
  const LoadedShape voxels = loaded(balls(), options);
  EXPECT_FALSE(voxels.surface);
  EXPECT_EQ(voxels.parameters.find("surface"), std::string::npos);
  for (const auto& [parameters, kind] : {std::pair(voxels.parameters, SurfaceKind::voxels),
                                         std::pair(loaded(balls(), at_least_100()).parameters, SurfaceKind::grey)}) {
    Record result;
    result.field_data.push_back({"parameters", 1, std::vector<std::string>{parameters}});
    pipeline::ShapeOptions again;
    pipeline::take_recorded(again, result, "core.vtp");
    EXPECT_EQ(again.surface, kind);
  }
}

TEST(VolumeSurface, OfLabelsIsThatOfTheVoxelsOrSmoothed) {
  pipeline::ShapeOptions options;
  options.foreground.label = 190;
  EXPECT_FALSE(loaded(balls(), options).surface);
  options.surface = SurfaceKind::smooth;
  const LoadedShape smooth = loaded(balls(), options);
  ASSERT_TRUE(smooth.surface);
  EXPECT_EQ(smooth.surface->kind(), SurfaceKind::smooth);
  const Grid& grid = smooth.shape.grid();
  for (int z = 0; z < grid.dims[2]; ++z)
    for (int y = 0; y < grid.dims[1]; ++y)
      for (int x = 0; x < grid.dims[0]; ++x)
        ASSERT_EQ(smooth.surface->nearest(grid.world(Vec3(x + 0.5, y + 0.5, z + 0.5))).inside,
                  smooth.shape.contains(x, y, z))
            << x << ' ' << y << ' ' << z;
}

// Faces that point either way are turned before winding numbers are looked at, so the mesh as it is bounds nothing.
TEST(SurfaceOfMesh, IsRefusedWhereItDoesNotBoundTheShape) {
  const auto with = [](const pipeline::ShapeOptions& options) {
    return pipeline::shape_of(make_sample("hollow-sphere", {}).mesh, options, nullptr);
  };
  pipeline::ShapeOptions options;
  options.resolution = 20;
  EXPECT_TRUE(with(options).surface);
  pipeline::ShapeOptions winding = options, filled = options;
  winding.fill = FillRule::winding;
  filled.foreground.fill_cavities = true;
  for (pipeline::ShapeOptions& refused : {std::ref(winding), std::ref(filled)}) {
    EXPECT_FALSE(with(refused).surface);
    refused.surface = SurfaceKind::mesh;
    try {
      with(refused);
      ADD_FAILURE() << "taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      EXPECT_EQ(error.field(), "surface");
    }
  }
}

TEST(VolumeSurface, IsRefusedWhereThereIsNone) {
  const auto refusal = [](const auto& load) -> std::string {
    try {
      load();
    } catch (const Error& error) {
      EXPECT_EQ(error.field(), "surface");
      return error.what();
    }
    return "";
  };
  pipeline::ShapeOptions options = at_least_100();
  options.surface = SurfaceKind::mesh;
  EXPECT_NE(refusal([&] { loaded(balls(), options); }).find("not a mesh"), std::string::npos);
  options.surface = SurfaceKind::grey;
  Volume mask = balls();
  for (auto& sample : std::get<std::vector<std::uint8_t>>(mask.samples)) sample = sample >= 100 ? 255 : 0;
  EXPECT_NE(refusal([&] { loaded(mask, options); }).find("at most two values"), std::string::npos);
  options.foreground.threshold.reset();
  options.foreground.label = 190;
  EXPECT_NE(refusal([&] { loaded(balls(), options); }).find("only a threshold"), std::string::npos);
  TriangleMesh mesh = midpoint_surface(loaded(balls(), at_least_100()).shape);
  EXPECT_NE(refusal([&] { pipeline::shape_of(std::move(mesh), options); }).find("no grey values"), std::string::npos);
}

}  // namespace volume_surface_test
}  // namespace quench
