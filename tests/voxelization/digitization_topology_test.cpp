// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "full_run.h"
#include "quench/error.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/voxelize.h"
#include "random_meshes.h"
#include "samples/sample_shapes.h"
#include "voxelization/surface_cover.h"

namespace quench {
namespace digitization_topology_test {

using samples::Random;
using Betti = std::array<std::int64_t, 3>;

struct Scene {
  TriangleMesh mesh;
  Betti betti{};  ///< of its solid, when its parts neither meet nor lie within each other's solid
};

Vec3 random_direction(Random& random) {
  for (;;) {
    const Vec3 d(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    if (d.norm() > 0.1 && d.norm() < 1) return d.normalized();
  }
}

TriangleMesh capsule(const Vec3& centre, const Vec3& half, double radius) {
  return samples::sphere(4,
                         [&](const Vec3& d) { return Vec3(centre + (d.dot(half) > 0 ? half : -half) + radius * d); });
}

TriangleMesh ring(const Vec3& centre, const Eigen::Matrix3d& turn, double radius, double thickness) {
  constexpr std::uint32_t kAlong = 24, kAround = 8;
  TriangleMesh mesh;
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % kAlong * kAround + j % kAround; };
  for (std::uint32_t i = 0; i < kAlong; ++i)
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double a = 2 * samples::kPi * i / kAlong, b = 2 * samples::kPi * j / kAround;
      const double r = radius + thickness * std::cos(b);
      mesh.points.push_back(centre + turn * Vec3(r * std::cos(a), r * std::sin(a), thickness * std::sin(b)));
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

TriangleMesh ball(const Vec3& centre, double radius) {
  return samples::sphere(5, [&](const Vec3& d) { return Vec3(centre + radius * d); });
}

/// One to five capsules, rings, plates and shells, down to a two-hundredth of the box thick.
Scene random_scene(std::uint64_t seed) {
  Random random(seed * 7919 + 3);
  Scene scene;
  const std::size_t parts = 1 + random.below(5);
  for (std::size_t part = 0; part < parts; ++part) {
    const Vec3 centre(random.unit(), random.unit(), random.unit());
    const Vec3 axis = random_direction(random);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(random.between(0, 3), axis).toRotationMatrix();
    ++scene.betti[0];
    switch (random.below(4)) {
      case 0:
        samples::append(scene.mesh, capsule(centre, random.between(0.01, 0.5) * axis, random.between(0.01, 0.08)));
        break;
      case 1:
        samples::append(scene.mesh, ring(centre, turn, random.between(0.1, 0.4), random.between(0.01, 0.05)));
        ++scene.betti[1];
        break;
      case 2: {
        const Vec3 half(random.between(0.1, 0.4), random.between(0.1, 0.4), random.between(0.005, 0.05));
        samples::append(scene.mesh, samples::sphere(3, [&](const Vec3& d) {
                          return Vec3(centre + turn * (d / d.cwiseAbs().maxCoeff()).cwiseProduct(half));
                        }));
        break;
      }
      default: {
        const double radius = random.between(0.1, 0.35);
        samples::append(scene.mesh, ball(centre, radius));
        samples::append(scene.mesh, ball(centre, radius - random.between(0.005, 0.05)), true);
        ++scene.betti[2];
      }
    }
  }
  return scene;
}

VoxelizeOptions at_resolution(std::int64_t resolution, TopologyRule rule = TopologyRule::mesh) {
  VoxelizeOptions options;
  options.resolution = resolution;
  options.topology = rule;
  return options;
}

std::vector<LatticePoint> differences(const VoxelShape& a, const VoxelShape& b) {
  std::vector<LatticePoint> result;
  const auto& dims = a.grid().dims;
  EXPECT_EQ(dims, b.grid().dims);
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x)
        if (a.contains(x, y, z) != b.contains(x, y, z)) result.push_back({x, y, z});
  return result;
}

/// Voxels that differ are met by the surface, and as many as is said.
void expect_differences(const TriangleMesh& mesh, const Voxelization& gauss, const Voxelization& matched) {
  const Grid& grid = matched.shape.grid();
  std::int64_t added = 0, removed = 0;
  for (const LatticePoint& v : differences(gauss.shape, matched.shape)) {
    ++(matched.shape.contains(v[0], v[1], v[2]) ? added : removed);
    bool met = false;
    for (const auto& t : mesh.triangles) {
      std::array<voxelization::FixedPoint, 3> corners;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t a = 0; a < 3; ++a)
          corners[i][a] = std::llround(
              std::ldexp(grid.lattice(mesh.points[t[i]])[static_cast<int>(a)], voxelization::kFractionBits));
      met = met || voxelization::meets(corners, {v[0], v[1], v[2]});
    }
    EXPECT_TRUE(met);
  }
  EXPECT_EQ(added, matched.repair ? matched.repair->added : 0);
  EXPECT_EQ(removed, matched.repair ? matched.repair->removed : 0);
}

TEST(DigitizationTopology, RandomScenesHaveTheTopologyOfTheirSolids) {
  std::int64_t scenes = 0, gauss_right = 0, fine = 0, fine_right = 0, right = 0;
  const std::uint64_t seeds = repeats(2000, 700);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const Scene scene = random_scene(seed);
    const auto resolution = static_cast<std::int64_t>(12 + seed * 13 % 53);
    const Voxelization matched = voxelize(scene.mesh, at_resolution(resolution));
    if (!matched.solid_betti) continue;  // parts meet
    matched.shape.validate();
    ++scenes;
    if (*matched.solid_betti != scene.betti) {  // a part within the solid of another one
      EXPECT_LT(*matched.solid_betti, scene.betti) << seed;
      const Voxelization fine_gauss = voxelize(scene.mesh, at_resolution(500, TopologyRule::voxels));
      EXPECT_EQ(*matched.solid_betti, topology(fine_gauss.shape).betti) << seed;
      continue;
    }
    const Topology got = topology(matched.shape);
    EXPECT_TRUE(matched.topology_known) << seed;
    EXPECT_EQ(matched.topology_changed, got.betti != scene.betti) << seed;
    EXPECT_EQ(matched.topology_difference.empty(), got.betti == scene.betti) << seed;
    const Voxelization gauss = voxelize(scene.mesh, at_resolution(resolution, TopologyRule::voxels));
    const bool was_right = topology(gauss.shape).betti == scene.betti;
    EXPECT_EQ(matched.repair.has_value(), !was_right) << seed;
    if (was_right) {
      EXPECT_TRUE(std::ranges::equal(gauss.shape.runs(), matched.shape.runs())) << seed;
    }
    if (seed % 20 == 0) expect_differences(scene.mesh, gauss, matched);
    gauss_right += was_right;
    right += got.betti == scene.betti;
    if (resolution < 32) continue;
    ++fine;
    fine_right += got.betti == scene.betti;
  }
  std::cout << scenes << " scenes, right: " << gauss_right << " of Gauss digitizations, " << right << " matched; "
            << fine_right << " of " << fine << " from resolution 32 on\n";
  EXPECT_GT(scenes, static_cast<std::int64_t>(seeds / 2));
  EXPECT_GT(right, 0.94 * static_cast<double>(scenes));
  EXPECT_GT(fine_right, 0.98 * static_cast<double>(fine));
}

/// The wanted numbers are those of a digitization in which nothing is thinner than two voxels.
TEST(DigitizationTopology, TheSolidsTopologyIsThatOfAFineDigitization) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const Scene scene = random_scene(seed);
    const Voxelization coarse = voxelize(scene.mesh, at_resolution(24));
    if (!coarse.solid_betti) continue;
    const Voxelization fine = voxelize(scene.mesh, at_resolution(600, TopologyRule::voxels));
    compared += topology(fine.shape).betti == *coarse.solid_betti;
  }
  EXPECT_GT(compared, 10);
}

TEST(DigitizationTopology, NestedPartsCountByTheWindingNumberAroundThem) {
  using testing_meshes::add_box;
  const auto betti = [](const TriangleMesh& mesh, FillRule fill) {
    VoxelizeOptions options = at_resolution(30);
    options.fill = fill;
    const Voxelization v = voxelize(mesh, options);
    if (v.solid_betti) {
      EXPECT_EQ(topology(v.shape).betti, *v.solid_betti);
    }
    return v.solid_betti;
  };
  for (const bool inward : {false, true}) {
    TriangleMesh mesh;
    add_box(mesh, {0, 0, 0}, {60, 60, 60}, inward);
    add_box(mesh, {6, 6, 6}, {54, 54, 54}, !inward);    // a cavity
    add_box(mesh, {12, 12, 12}, {48, 48, 48}, inward);  // with a solid in it
    add_box(mesh, {18, 18, 18}, {42, 42, 42}, inward);  // that says so twice
    EXPECT_EQ(betti(mesh, FillRule::nonzero), (Betti{2, 0, 1}));
    EXPECT_EQ(betti(mesh, FillRule::evenodd), (Betti{2, 0, 2}));
    add_box(mesh, {17, 20, 20}, {43, 40, 40}, inward);  // meets it
    EXPECT_EQ(betti(mesh, FillRule::nonzero), std::nullopt);
  }
}

TEST(DigitizationTopology, OverlappingAndDefectiveMeshesAreLeftAlone) {
  const TriangleMesh root = make_sample("root", {.branches = 12, .fineness = 0.3}).mesh;
  TriangleMesh open = make_sample("torus", {.fineness = 0.2}).mesh;
  open.triangles.resize(open.triangles.size() - 40);
  for (const TriangleMesh& mesh : {root, open}) {
    const Voxelization gauss = voxelize(mesh, at_resolution(40, TopologyRule::voxels));
    const Voxelization matched = voxelize(mesh, at_resolution(40));
    EXPECT_FALSE(matched.solid_betti);
    EXPECT_FALSE(matched.repair);
    EXPECT_FALSE(matched.topology_known);
    EXPECT_TRUE(std::ranges::equal(gauss.shape.runs(), matched.shape.runs()));
  }
}

TEST(DigitizationTopology, AGapNarrowerThanAVoxelIsCutOpen) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {500, 995, 500});
  testing_meshes::add_box(mesh, {0, 998, 0}, {500, 2000, 500});
  const Voxelization gauss = voxelize(mesh, at_resolution(20, TopologyRule::voxels));
  EXPECT_EQ(topology(gauss.shape).betti, (Betti{1, 0, 0}));
  const Voxelization matched = voxelize(mesh, at_resolution(20));
  EXPECT_EQ(topology(matched.shape).betti, (Betti{2, 0, 0})) << matched.topology_difference;
  EXPECT_EQ(matched.repair->removed, 25);
  EXPECT_EQ(matched.repair->added, 0);
  EXPECT_NE(repair_text(*matched.repair).find("25 taken out"), std::string::npos) << repair_text(*matched.repair);
}

TEST(DigitizationTopology, BridgesThinnerThanAVoxelHold) {
  const TriangleMesh blobs = make_sample("four-blobs", {.fineness = 0.2}).mesh;
  for (const std::int64_t resolution : {16, 24, 33, 40}) {
    const Voxelization v = voxelize(blobs, at_resolution(resolution));
    EXPECT_EQ(topology(v.shape).betti, (Betti{1, 0, 0})) << resolution;
  }
}

TEST(DigitizationTopology, WhatCannotBeHadIsSaidWithPlacesAndAResolution) {
  const Vec3 centre = Vec3::Constant(0.5);
  TriangleMesh mesh = ball(centre, 0.5);  // around another one: the gap is a third of a voxel
  samples::append(mesh, ball(centre, 0.43), true);
  samples::append(mesh, ball(centre, 0.40));
  const Voxelization v = voxelize(mesh, at_resolution(12));
  ASSERT_TRUE(v.topology_changed);
  ASSERT_TRUE(v.repair);
  EXPECT_EQ(v.repair->after, topology(v.shape));
  EXPECT_GT(v.repair->working_resolution, 12);
  EXPECT_FALSE(voxelize(mesh, at_resolution(v.repair->working_resolution)).topology_changed);
  EXPECT_NE(v.topology_difference.find("resolution " + std::to_string(v.repair->working_resolution) + " has it"),
            std::string::npos)
      << v.topology_difference;
  ASSERT_FALSE(v.repair->places.empty());
  for (const Vec3& p : v.repair->places) EXPECT_NEAR((p - Vec3::Constant(0.5)).norm(), 0.45, 0.15);
}

TEST(DigitizationTopology, ThreadsMarginsAndTranslationsChangeNothing) {
  Context one, two;
  one.threads = 1;
  two.threads = 2;
  int repaired = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Scene scene = random_scene(seed);
    VoxelizeOptions options = at_resolution(16);
    const Voxelization a = voxelize(scene.mesh, options, &one), b = voxelize(scene.mesh, options, &two);
    EXPECT_TRUE(std::ranges::equal(a.shape.runs(), b.shape.runs())) << seed;
    EXPECT_EQ(a.topology_difference, b.topology_difference);
    repaired += a.repair.has_value();
    options.margin = 0;
    const Voxelization tight = voxelize(scene.mesh, options);
    ASSERT_EQ(tight.shape.runs().size(), a.shape.runs().size()) << seed;
    for (std::size_t i = 0; i < a.shape.runs().size(); ++i) {
      EXPECT_EQ(tight.shape.runs()[i].begin + 1, a.shape.runs()[i].begin);
      EXPECT_EQ(tight.shape.runs()[i].end + 1, a.shape.runs()[i].end);
    }
  }
  EXPECT_GT(repaired, 15);
}

TEST(DigitizationTopology, PermutedAndMirroredAxesGiveTheSameTopology) {
  std::int64_t compared = 0, changed[2]{};
  const std::uint64_t seeds = repeats(120, 60);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const Scene scene = random_scene(seed);
    TriangleMesh turned = scene.mesh;
    for (Vec3& p : turned.points) p = Vec3(p[2], -p[0], p[1]);  // a rotation: faces stay outward
    const Voxelization a = voxelize(scene.mesh, at_resolution(40)), b = voxelize(turned, at_resolution(40));
    ASSERT_EQ(a.solid_betti, b.solid_betti);
    if (!a.repair || !b.repair || a.topology_changed || b.topology_changed) continue;
    ++compared;
    EXPECT_EQ(topology(a.shape), topology(b.shape)) << seed;
    changed[0] += a.repair->added + a.repair->removed;
    changed[1] += b.repair->added + b.repair->removed;
  }
  EXPECT_GT(compared, static_cast<std::int64_t>(seeds / 6));
  EXPECT_NEAR(static_cast<double>(changed[0]) / static_cast<double>(changed[1]), 1, 0.02);
}

TEST(DigitizationTopology, AutomaticResolutionTakesTheCoarsestThatCanHaveIt) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {500, 999, 500});
  testing_meshes::add_box(mesh, {0, 1001, 0}, {500, 2000, 500});
  const Voxelization v = voxelize_auto(mesh);
  EXPECT_FALSE(v.topology_changed);
  EXPECT_DOUBLE_EQ(v.shape.grid().spacing[0], 2000.0 / 128);
  Context listening;
  double last = 0;
  listening.progress = [&](std::string_view, double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  };
  voxelize_auto(make_sample("four-blobs", {.fineness = 0.2}).mesh, {}, &listening);
  EXPECT_EQ(last, 1);
}

TEST(TopologyRule, NamesAreThoseOfTheProgram) {
  for (const TopologyRule rule : {TopologyRule::mesh, TopologyRule::voxels})
    EXPECT_EQ(topology_of(topology_name(rule)), rule);
  EXPECT_EQ(topology_name(TopologyRule::mesh), "mesh");
  EXPECT_FALSE(topology_of("gauss"));
}

}  // namespace digitization_topology_test
}  // namespace quench
