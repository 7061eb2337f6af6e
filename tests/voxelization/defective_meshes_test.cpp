// SPDX-License-Identifier: Apache-2.0
// QUENCH_TEST_FULL=1 spoils every closed mesh of the data too. Clean meshes, spoiled in many ways, give about the
// voxels of the clean ones (notes/defective_meshes.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "damage.h"
#include "damage_limits.h"
#include "data.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/verify.h"
#include "quench/voxelize.h"
#include "random_meshes.h"
#include "voxel_difference.h"

namespace quench {
namespace defective_meshes_test {

using testing_damage::Damage;
using testing_damage::damages;
using testing_damage::pinned;

constexpr double detail = 0.12;  // of samples: some thousand faces

TriangleMesh sample(std::string_view name) {
  return make_sample(name, {.noise = 0, .seed = 1, .branches = 12, .fineness = detail}).mesh;
}

void expect_same(const VoxelShape& a, const VoxelShape& b, const std::string& where) {
  EXPECT_EQ(a.grid().dims, b.grid().dims) << where;
  EXPECT_EQ(a.voxel_count(), b.voxel_count()) << where;
  EXPECT_EQ(voxel_difference(a, b), 0) << where;
}

void expect_robust_is_the_same(const TriangleMesh& mesh, std::int64_t resolution, const std::string& where) {
  VoxelizeOptions options;
  options.resolution = resolution;
  const Voxelization plain = voxelize(mesh, options);
  ASSERT_TRUE(plain.sound) << where;
  EXPECT_EQ(plain.defects.defective_scanlines, 0) << where;
  for (const FillRule fill : {FillRule::winding, FillRule::automatic}) {
    options.fill = fill;
    const Voxelization robust = voxelize(mesh, options);
    expect_same(robust.shape, plain.shape, where);
    EXPECT_EQ(robust.defects.defective_scanlines, 0) << where;
    EXPECT_EQ(robust.fill_reason.empty(), fill == FillRule::winding);
  }
}

/// Every damage of a mesh within its limit.
void expect_limits(const TriangleMesh& clean, std::int64_t resolution, const std::string& name) {
  VoxelizeOptions options;
  options.resolution = resolution;
  options.topology = TopologyRule::voxels;  // that of a defective mesh is not known
  const VoxelShape wanted = voxelize(pinned(clean, clean), options).shape;
  for (const Damage& damage : damages()) {
    const std::string where = name + ": " + std::string(damage.name);
    const TriangleMesh damaged = damage.apply(clean, 7);
    const Voxelization v = voxelize(pinned(damaged, clean), options);
    v.shape.validate();
    const double difference = voxel_difference(v.shape, wanted);
    double limit = damage.limit;
    if (difference > limit && damage.otherwise == Damage::Otherwise::missing)
      limit = testing_damage::share_behind_missing_faces(wanted, clean, damaged);
    if (difference > limit && damage.otherwise == Damage::Otherwise::moved)
      limit = 0.1 * testing_damage::boundary_share(wanted);
    EXPECT_LE(difference, limit) << where;
    if (damage.exact) {
      EXPECT_EQ(v.defects.defective_scanlines, 0) << where;
    }
    EXPECT_EQ(v.sound, defects_text(v).empty()) << where;
    if (difference > 0) {
      EXPECT_FALSE(v.sound) << where;
      EXPECT_GT(v.defects.unbalanced_edges, 0) << where;
      if (damage.name != "a cap missing") {  // its edge may lie between scanlines
        EXPECT_GT(v.defects.defective_scanlines, 0) << where;
        EXPECT_GT(v.defects.winding_share, 0) << where;
      }
    }
  }
}

TEST(DefectiveMeshes, ClosedOnesAreTheSameWithTheRobustPath) {
  for (const SampleInfo& s : built_in_samples())
    expect_robust_is_the_same(sample(s.name), s.name == "bars" ? 160 : 40, std::string(s.name));
}

// Corners on the centres of voxels, parts in parts: under `winding` as well, unless a part faces inward by itself.
TEST(DefectiveMeshes, TiesOfClosedOnesAreTheSameWithTheRobustPath) {
  std::mt19937_64 random(17);
  int compared = 0;
  for (int i = 0; i < 300; ++i) {
    const TriangleMesh mesh = testing_meshes::random_mesh(random, 12);
    VoxelizeOptions options;
    options.resolution = 6;
    try {
      const VoxelShape plain = voxelize(mesh, options).shape;
      options.fill = FillRule::winding;
      const Voxelization robust = voxelize(mesh, options);
      if (robust.defects.flipped_components + robust.defects.duplicate_faces > 0) continue;
      expect_same(robust.shape, plain, std::to_string(i));
      ++compared;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::input);
    }
  }
  EXPECT_GT(compared, 50);
}

class DamagedSamples : public testing::TestWithParam<const char*> {};
TEST_P(DamagedSamples, StayWithinTheirLimits) { expect_limits(sample(GetParam()), 40, GetParam()); }
INSTANTIATE_TEST_SUITE_P(Samples, DamagedSamples, testing::Values("ellipsoid", "torus", "four-blobs", "hollow-sphere"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(DefectiveMeshes, EveryClosedMeshOfTheData) {
  REQUIRE_DATA("meshes");
  int compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data_file("meshes"))) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || io::kind_of(entry.path()) != io::Kind::surface) continue;
    const TriangleMesh mesh = to_triangle_mesh(io::read_record(entry.path()));
    if (mesh.triangles.size() < 2000 || mesh.triangles.size() > 500000) continue;
    try {
      if (!voxelize(mesh, {.resolution = 40}).sound) continue;
    } catch (const Error&) {
      continue;  // encloses nothing
    }
    expect_robust_is_the_same(mesh, 40, name);
    if (std::getenv("QUENCH_TEST_FULL")) expect_limits(mesh, 48, name);
    ++compared;
  }
  EXPECT_GT(compared, 0);
}

TEST(DefectiveMeshes, ResultsDoNotDependOnThreads) {
  const TriangleMesh clean = sample("torus");
  for (const Damage& damage : damages()) {
    const TriangleMesh mesh = damage.apply(clean, 2);
    std::optional<VoxelShape> first;
    for (const int threads : {1, 2, 5}) {
      Context context;
      context.threads = threads;
      const VoxelShape shape = voxelize(mesh, {.resolution = 20}, &context).shape;
      if (first) expect_same(shape, *first, std::string(damage.name));
      first = shape;
    }
  }
}

TEST(DefectiveMeshes, CoresOfDamagedShapesVerify) {
  const TriangleMesh clean = sample("four-blobs");
  for (const char* name :
       {"20 % of faces missing", "soup, points moved", "a cap missing", "half flipped, three holes"}) {
    const auto damage =
        std::find_if(damages().begin(), damages().end(), [&](const Damage& d) { return d.name == name; });
    ASSERT_NE(damage, damages().end());
    const Voxelization v = voxelize(damage->apply(clean, 4), {.resolution = 40});
    MedialAxis core = voxel_core(v.shape);
    ASSERT_EQ(topology(core.complex), topology(v.shape)) << name;
    prune_levels(core);
    const double lambda = 0.02 * v.longest_side;
    Record data = to_record(pruned(core, lambda));
    data.field_data.push_back({"stage", 1, std::vector<std::string>{"core"}});
    for (const Check& check : verify(v.shape, data, {.lambda = lambda, .samples = 2000}).checks)
      EXPECT_TRUE(check.passed) << name << ": " << check.name << ": " << check.detail;
  }
}

// Both ends of a tube are open: scanlines along it cross nothing at all.
TEST(DefectiveMeshes, ATubeAlongTheScanlinesIsFilled) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {40, 10, 10});
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return mesh.points[t[0]][0] == mesh.points[t[1]][0] && mesh.points[t[1]][0] == mesh.points[t[2]][0];
  });
  ASSERT_EQ(mesh.triangles.size(), 8u);
  const Voxelization v = voxelize(mesh, {.resolution = 40});
  EXPECT_FALSE(v.sound);
  EXPECT_EQ(v.surface.boundary_edges, 8);
  EXPECT_EQ(v.defects.defective_scanlines, 100);
  EXPECT_EQ(v.defects.winding_share, 1);
  EXPECT_TRUE(v.shape.contains(20, 5, 5));
  EXPECT_EQ(topology(v.shape), (Topology{1, {1, 0, 0}}));
  EXPECT_GT(v.shape.voxel_count(), 3500);
  EXPECT_NE(defects_text(v).find("8 open edges"), std::string::npos) << defects_text(v);
}

TEST(DefectiveMeshes, AutoSaysWhatItChoseAndWhy) {
  const auto chosen = [](const TriangleMesh& mesh) {
    VoxelizeOptions options;
    options.resolution = 24;
    options.fill = FillRule::automatic;
    return voxelize(mesh, options);
  };
  using testing_meshes::add_box;
  TriangleMesh box;
  add_box(box, {0, 0, 0}, {24, 24, 24});
  Voxelization v = chosen(box);
  EXPECT_EQ(v.fill, FillRule::nonzero);
  EXPECT_NE(v.fill_reason.find("closed and consistently oriented"), std::string::npos) << v.fill_reason;
  TriangleMesh open = box;
  open.triangles.pop_back();
  v = chosen(open);
  EXPECT_EQ(v.fill, FillRule::winding);
  EXPECT_NE(v.fill_reason.find("3 edges have"), std::string::npos) << v.fill_reason;
  TriangleMesh turned = box;
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  v = chosen(turned);
  EXPECT_EQ(v.fill, FillRule::winding);
  EXPECT_NE(v.fill_reason.find("not consistently oriented"), std::string::npos) << v.fill_reason;
  EXPECT_EQ(v.defects.flipped_faces, 1);
  EXPECT_EQ(v.shape.voxel_count(), 24 * 24 * 24);
  TriangleMesh two;  // overlapping, one of them inward: what both cover would be outside
  add_box(two, {0, 0, 0}, {16, 16, 16});
  add_box(two, {8, 8, 8}, {24, 24, 24}, true);
  EXPECT_EQ(voxelize(two, {.resolution = 24}).shape.voxel_count(), 2 * (4096 - 512));
  v = chosen(two);
  EXPECT_EQ(v.fill, FillRule::winding);
  EXPECT_EQ(v.shape.voxel_count(), 2 * 4096 - 512);
  EXPECT_EQ(v.defects.flipped_components, 1);
  EXPECT_NE(v.fill_reason.find("inward"), std::string::npos) << v.fill_reason;
  TriangleMesh cavity = box;
  add_box(cavity, {8, 8, 8}, {16, 16, 16}, true);
  v = chosen(cavity);
  EXPECT_EQ(v.fill, FillRule::nonzero);
  EXPECT_EQ(v.shape.voxel_count(), 24 * 24 * 24 - 512);
}

TEST(DefectiveMeshes, WhatEnclosesNothingIsRefusedInOneSentence) {
  const auto message = [](const TriangleMesh& mesh) -> std::string {
    try {
      voxelize(mesh, {.resolution = 32});
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::input);
      return e.what();
    }
    return "";
  };
  TriangleMesh sheet;  // tilted, so that its box is not flat
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(4, 4, 1.7), Vec3(0, 4, 1.7)}) sheet.points.push_back(p);
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_NE(message(sheet).find("encloses nothing"), std::string::npos) << message(sheet);
  EXPECT_NE(message(sheet).find("4 edges"), std::string::npos) << message(sheet);
  TriangleMesh frame;
  testing_meshes::add_frame(frame, 5);
  EXPECT_NE(message(frame).find("encloses nothing"), std::string::npos);
}

// A bent sheet encloses nothing, but has a layer with |w| > 1/2 on its hollow side: it says that this is a guess.
TEST(DefectiveMeshes, ABentSheetIsCalledAGuess) {
  TriangleMesh sheet;
  constexpr std::uint32_t n = 24;
  for (std::uint32_t i = 0; i <= n; ++i) {
    const double angle = std::numbers::pi * i / n;  // half of a tube
    for (const double y : {-3.0, 3.0}) sheet.points.emplace_back(std::cos(angle), y, std::sin(angle));
    if (i == n) break;
    sheet.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    sheet.triangles.push_back({2 * i + 2, 2 * i + 1, 2 * i + 3});
  }
  const Voxelization v = voxelize(sheet, {.resolution = 60});
  EXPECT_GT(v.defects.doubtful_share, 0.5);
  EXPECT_NE(defects_text(v).find("are a guess"), std::string::npos) << defects_text(v);
  TriangleMesh box;
  testing_meshes::add_box(box, {0, 0, 0}, {24, 24, 24});
  box.triangles.pop_back();
  const Voxelization open = voxelize(box, {.resolution = 24});
  EXPECT_LT(open.defects.doubtful_share, 0.3);
  EXPECT_EQ(defects_text(open).find("guess"), std::string::npos) << defects_text(open);
}

TEST(FillRule, NamesAreThoseOfTheProgram) {
  for (const char* name : {"nonzero", "evenodd", "winding", "auto"}) {
    ASSERT_TRUE(fill_of(name)) << name;
    EXPECT_EQ(fill_name(*fill_of(name)), name);
  }
  EXPECT_FALSE(fill_of("odd"));
}

}  // namespace defective_meshes_test
}  // namespace quench
