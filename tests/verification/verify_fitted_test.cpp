// SPDX-License-Identifier: Apache-2.0
// Results whose points and radii are fitted to the surface that was voxelized.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "certificates.h"
#include "quench/burn.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "quench/skeleton.h"
#include "quench/verify.h"

namespace quench {
namespace verify_fitted_test {

using namespace testing_certificates;

struct Fitted {
  std::string name;
  pipeline::LoadedShape shape;
  Record core;

  VerifyOptions options() const {
    VerifyOptions options;
    options.longest_side = shape.longest_side;
    options.format_holds_all = true;
    options.surface = &shape.surface->mesh();
    options.surface_kind = "mesh";
    return options;
  }
  Certificate verified(const Record& data) const { return verify(shape.shape, data, options()); }
};

TriangleMesh sample(const std::string& name) { return make_sample(name, {.fineness = 0.1}).mesh; }

Fitted fitted(const std::string& name, std::int64_t resolution, const pipeline::AxisOptions& options = {}) {
  pipeline::ShapeOptions how;
  how.resolution = resolution;
  how.surface = SurfaceKind::mesh;
  pipeline::LoadedShape shape = pipeline::shape_of(sample(name), how);
  Record core = pipeline::core_file(pipeline::core_of(shape, options));
  return {fmt::format("{} {}", name, resolution), std::move(shape), std::move(core)};
}

std::vector<Fitted> all() {
  std::vector<Fitted> results;
  results.push_back(fitted("box", 20));
  results.push_back(fitted("torus", 32));
  results.push_back(fitted("ellipsoid", 30));
  results.push_back(fitted("fin-on-board", 30));
  results.push_back(fitted("hollow-sphere", 24));
  results.push_back(fitted("ellipsoid", 20, {.full = true}));
  results.push_back(fitted("torus", 24, {.pruning = {kLambda, pipeline::world_length(0.05)}}));
  return results;
}

Record burned(Record data) {
  const MedialAxis axis = medial_axis_of(data);
  BurnOptions options{.radius = RadiusRule::linear};
  options.rounded = true;
  const Burning burning = burn(axis, options);
  add_burning(data, burning, burn_sequence(axis, burning));
  return data;
}

std::vector<double>& numbers(std::vector<DataArray>& arrays, const std::string& name) {
  for (DataArray& array : arrays)
    if (array.name == name) return std::get<std::vector<double>>(array.values);
  throw std::logic_error("no array " + name);
}

TEST(VerifyFitted, PassesAndNamesTheSurface) {
  for (const Fitted& result : all()) {
    for (const Record& data : {result.core, burned(result.core)}) {
      const Certificate certificate = result.verified(data);
      EXPECT_TRUE(certificate.passed()) << result.name << "\n" << text(certificate);
      EXPECT_TRUE(certificate.absent.empty()) << result.name << "\n" << text(certificate);
      EXPECT_NE(text(certificate).find("their side of the surface (mesh, "), std::string::npos);
      for (const UncheckedArray& array : certificate.not_checked)
        for (const char* name : {"point radius", "point voxel_point", "point voxel_radius", "field surface"})
          EXPECT_NE(array.array, name) << result.name;
    }
  }
}

TEST(VerifyFitted, TellsTheTopologyOfTheSurface) {
  for (const auto& [name, resolution, told] :
       {std::tuple{"torus", 32, "euler 0, betti 1 1 0; the solid of the surface has the same"},
        {"hollow-sphere", 24, "euler 2, betti 1 0 1; the solid of the surface has the same"},
        {"torus", 4, "; the solid of the surface has euler 0, betti 1 1 0"}}) {
    const Fitted result = fitted(name, resolution);
    EXPECT_NE(text(result.verified(result.core)).find(told), std::string::npos) << text(result.verified(result.core));
  }
}

// The image is the distance to the surface, so that this is its isosurface.
TEST(VerifyFitted, GreyValuesAreInterpolated) {
  const Fitted result = fitted("torus", 32);
  Record core = result.core;
  for (DataArray& array : core.field_data)
    if (array.name == "surface") array.values = std::vector<std::string>{"grey"};
  for (const bool whole : {false, true}) {
    Volume volume;
    volume.grid = result.shape.shape.grid();
    std::vector<float> samples;
    std::vector<std::int16_t> whole_samples;
    for (std::int64_t z = 0; z < volume.grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < volume.grid.dims[1]; ++y)
        for (std::int64_t x = 0; x < volume.grid.dims[0]; ++x) {
          const Vec3 centre = volume.grid.world(
              Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) + Vec3::Constant(0.5));
          const Surface::Foot foot = result.shape.surface->nearest(centre);
          const double value = (foot.inside ? 1 : -1) * foot.distance;
          samples.push_back(static_cast<float>(value));
          whole_samples.push_back(static_cast<std::int16_t>(std::lround(1e4 * value + 99.5)));
        }
    if (whole)
      volume.samples = whole_samples;
    else
      volume.samples = samples;
    const ImageView image = view_of(volume);
    VerifyOptions options = result.options();
    options.surface_kind = "grey";
    EXPECT_NE(text(verify(result.shape.shape, core, options)).find("surface of the grey values: not checked"),
              std::string::npos);
    options.image = &image;
    options.threshold = whole ? 100 : 0;
    const Certificate certificate = verify(result.shape.shape, core, options);
    EXPECT_TRUE(certificate.passed()) << text(certificate);
    EXPECT_NE(text(certificate).find("of the value "), std::string::npos) << text(certificate);
    options.threshold += whole ? 600 : 0.06;  // a voxel is 0.085
    EXPECT_EQ(failed(verify(result.shape.shape, core, options)), Names{"surface of the grey values"});
  }
}

TEST(VerifyFitted, WithoutTheSurfaceItsArraysAreNamed) {
  const Fitted result = fitted("torus", 32);
  const Certificate certificate = verify(result.shape.shape, result.core);
  EXPECT_TRUE(certificate.passed()) << text(certificate);
  Names left;
  for (const UncheckedArray& array : certificate.not_checked)
    if (array.reason.find("surface") != std::string::npos) left.insert(array.array);
  EXPECT_EQ(left, (Names{"point radius", "field surface", "field detail"}));
}

TEST(VerifyFitted, AnotherSurfaceIsNoticed) {
  const Fitted result = fitted("torus", 32);
  VerifyOptions options = result.options();
  options.surface_kind = "grey";
  EXPECT_EQ(failed(verify(result.shape.shape, result.core, options)), Names{"surface of the shape"});
  options = result.options();
  TriangleMesh smaller = *options.surface;
  for (Vec3& p : smaller.points) p *= 0.9;
  options.surface = &smaller;
  EXPECT_EQ(failed(verify(result.shape.shape, result.core, options)),
            (Names{"surface of the shape", "balls of the surface"}));
}

TEST(VerifyFitted, DamageIsNoticed) {
  for (const Fitted& result : all()) {
    const std::size_t v = result.core.points.size() / 2;
    const double voxel = result.shape.shape.grid().spacing.maxCoeff(), side = result.shape.longest_side;
    const auto expect_noticed = [&](const std::function<void(Record&)>& change, const Names& by) {
      Record data = result.core;
      change(data);
      const Certificate certificate = result.verified(data);
      for (const std::string& name : by)
        EXPECT_TRUE(failed(certificate).contains(name)) << result.name << ": " << name << "\n" << text(certificate);
    };
    // A point that is somewhere else, with the same radius; a radius that is too large or too small by little.
    for (const double step : {1e-3, -1e-3})
      expect_noticed([&](Record& data) { data.points[v] += Vec3(0.3, 0.4, 0.5) * step * side; },
                     {"balls of the surface"});
    for (const double by : {1.0 + 1e-6, 1 - 1e-6, 0.0, -1.0, 2.0})
      expect_noticed([&](Record& data) { numbers(data.point_data, "radius")[v] *= by; }, {"balls of the surface"});
    // Farther than allowed, even with the right radius; outside.
    expect_noticed([&](Record& data) { data.points[v] += Vec3(1.01 * 3 * voxel, 0, 0); }, {"moved points"});
    expect_noticed(
        [&](Record& data) {
          for (const Vec3& p : result.shape.surface->mesh().points)
            if (p[0] < data.points[v][0]) data.points[v] = p;
          data.points[v][0] -= 0.5 * voxel;
        },
        {"balls of the surface", "moved points"});
    // What it was in the voxel core.
    expect_noticed([&](Record& data) { numbers(data.point_data, "voxel_radius")[v] *= 1.001; }, {"radii"});
    expect_noticed([&](Record& data) { numbers(data.point_data, "voxel_point")[3 * v] += 0.01 * voxel; },
                   {"Voronoi cells"});
    expect_noticed(
        [&](Record& data) {
          std::erase_if(data.point_data, [](const DataArray& a) { return a.name == "voxel_point"; });
        },
        {"arrays"});
    expect_noticed(
        [&](Record& data) { std::erase_if(data.field_data, [](const DataArray& a) { return a.name == "surface"; }); },
        {"radii"});
  }
}

// A point outside the surface has the radius 0.
TEST(VerifyFitted, PointsOutsideHaveNoBall) {
  for (const Fitted& result : all()) {
    Record data = result.core;
    const Surface& surface = *result.shape.surface;
    const double voxel = result.shape.shape.grid().spacing.maxCoeff();
    std::size_t outside = 0;
    for (std::size_t v = 0; v < data.points.size(); ++v) {
      const Vec3 p = data.points[v];
      const Surface::Foot foot = surface.nearest(p, voxel);
      if (foot.triangle == kNone || !foot.inside || foot.distance == 0) continue;
      const Vec3 beyond = foot.point + 0.1 * voxel / foot.distance * (foot.point - p);
      if (surface.nearest(beyond).inside || (beyond - p).norm() > voxel) continue;
      data.points[v] = beyond;
      numbers(data.point_data, "radius")[v] = 0;
      numbers(data.point_data, "voxel_point");
      if (++outside == 1) {
        Record wrong = data;
        numbers(wrong.point_data, "radius")[v] = 0.05 * voxel;
        EXPECT_TRUE(failed(result.verified(wrong)).contains("balls of the surface")) << result.name;
      }
    }
    EXPECT_FALSE(failed(result.verified(data)).contains("balls of the surface")) << result.name;
  }
}

TEST(VerifyFitted, SkeletonsAreInsideTheSurface) {
  for (const char* name : {"torus", "ellipsoid", "fin-on-board"}) {
    const Fitted result = fitted(name, 32);
    const Record core = burned(result.core);
    const MedialAxis axis = medial_axis_of(core);
    const Burning burning = burn(axis, {.radius = RadiusRule::linear});
    const pipeline::FamilyResult family = pipeline::family_of(
        quench_curves(axis.complex, axis.points, axis.radius, burning), topology(result.shape.shape));
    for (const double theta2 : {0.02, 1e9}) {
      const pipeline::SkeletonOptions options{pipeline::world_length(theta2), pipeline::world_length(0.02), false};
      Record skeleton = pipeline::skeleton_file(pipeline::skeleton_of(family, options, {}, 0), core);
      if (!find_array(skeleton.field_data, "surface"))
        skeleton.field_data.push_back({"surface", 1, std::vector<std::string>{"mesh"}});
      const Certificate certificate = result.verified(skeleton);
      EXPECT_TRUE(certificate.passed()) << name << "\n" << text(certificate);
      EXPECT_NE(text(certificate).find("ok   balls of the surface: "), std::string::npos) << text(certificate);
      std::vector<double>& radius = numbers(skeleton.point_data, "radius");
      radius[radius.size() / 2] += 0.5 * result.shape.longest_side;
      EXPECT_TRUE(failed(result.verified(skeleton)).contains("balls of the surface"));
    }
  }
}

}  // namespace verify_fitted_test
}  // namespace quench
