// SPDX-License-Identifier: Apache-2.0
// Results far from the origin of their coordinates, where positions are rounded to parts of a voxel: `verify` passes
// ours, and still finds what is wrong by more than that.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "quench/burn.h"
#include "quench/pipeline.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace verify_far_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

VoxelShape at(const VoxelShape& shape, const Vec3& origin, const Vec3& spacing) {
  Grid grid = shape.grid();
  grid.origin = origin;
  grid.spacing = spacing;
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return shape.contains(x, y, z); });
}

struct Computed {
  Record core;
  std::vector<Record> cores_by_detail;
  std::vector<Record> skeletons;
};

Computed compute(const VoxelShape& shape) {
  const double voxel = shape.grid().spacing.minCoeff();
  Computed computed;
  computed.core = pipeline::core_file(pipeline::core_of(pipeline::shape_of(VoxelShape(shape), shape.grid(), {}),
                                                        {.pruning = {kLambda, pipeline::world_length(0.8 * voxel)}}));
  for (const bool full : {false, true})
    computed.cores_by_detail.push_back(pipeline::core_file(
        pipeline::core_of(pipeline::shape_of(VoxelShape(shape), shape.grid(), {}), {.full = full})));
  const MedialAxis axis = medial_axis_of(computed.core);
  const Burning burning = burn(axis.complex, axis.points, axis.radius, {});
  add_burning(computed.core, burning);
  const pipeline::FamilyResult family =
      pipeline::family_of(quench_curves(axis.complex, axis.points, axis.radius, burning), topology(shape));
  for (const double theta2 : {0.0, 0.3 * voxel, 1.5 * voxel, kInfinity})
    for (const bool parts : {false, true}) {
      const pipeline::SkeletonOptions options{pipeline::world_length(theta2), pipeline::world_length(0.2 * voxel),
                                              parts};
      computed.skeletons.push_back(
          pipeline::skeleton_file(pipeline::skeleton_of(family, options, {}, 0), computed.core));
    }
  return computed;
}

std::string failures(const VoxelShape& shape, const Record& data) {
  std::string all;
  for (const Check& check : verify(shape, data).checks)
    if (!check.passed) all += check.name + ": " + check.detail + "\n";
  return all;
}

class AtDistance : public ::testing::TestWithParam<int> {};

TEST_P(AtDistance, OurResultsPass) {
  const double far = 0.9 * std::pow(10.0, GetParam());  // the program takes up to 1e12
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    for (const Vec3& spacing : {Vec3(1, 1, 1), Vec3(0.5, 0.5, 2)}) {
      const VoxelShape near = testing_shapes::random_shape(seed, 12);
      const double smallest = spacing.minCoeff();  // distances in voxels
      for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.6, 0.25, -0.75)}) {
        const VoxelShape shape = at(near, far * smallest * direction, spacing);
        const std::string where = fmt::format("seed {}, spacing {}, direction {}", seed, spacing[2], direction[1]);
        const Computed computed = compute(shape);
        EXPECT_EQ(failures(shape, computed.core), "") << where << " core";
        for (const Record& core : computed.cores_by_detail)
          EXPECT_EQ(failures(shape, core), "") << where << " core by detail";
        for (std::size_t s = 0; s < computed.skeletons.size(); ++s)
          EXPECT_EQ(failures(shape, computed.skeletons[s]), "") << where << " skeleton " << s;
      }
    }
}

// What is off by more than rounding is found at any distance.
TEST_P(AtDistance, AMovedVertexIsFound) {
  const double far = 0.9 * std::pow(10.0, GetParam());
  const VoxelShape shape = at(testing_shapes::box_shape(9, 7, 5), {0.6 * far, -0.7 * far, 0.3 * far}, {1, 1, 1});
  const Computed computed = compute(shape);
  const double step = 1e-3 + 4e-14 * far;
  for (const Record* data : {&computed.core, &computed.skeletons[0]}) {
    Record moved = *data;
    moved.points[moved.points.size() / 3] += Vec3(step, 0.7 * step, 0.3 * step);
    EXPECT_NE(failures(shape, moved), "");
  }
}

// A polygon without area is found where positions are good enough to tell.
TEST(FarFromTheOrigin, APolygonWithoutAreaIsFoundWhereItCanBe) {
  for (const double far : {0.0, 1e3, 1e5}) {
    const VoxelShape shape = at(testing_shapes::box_shape(9, 7, 5), {far, far, far}, {1, 1, 1});
    Record flat = compute(shape).skeletons[0];
    const auto middle = static_cast<std::uint32_t>(flat.points.size());
    const std::uint32_t a = flat.poly_corners[0], b = flat.poly_corners[1];
    flat.points.push_back(0.5 * (flat.points[a] + flat.points[b]));
    for (DataArray& array : flat.point_data) std::visit([](auto& v) { v.push_back(v.front()); }, array.values);
    flat.poly_corners.insert(flat.poly_corners.end(), {a, b, middle});
    flat.poly_offsets.push_back(static_cast<std::uint32_t>(flat.poly_corners.size()));
    for (DataArray& array : flat.cell_data) std::visit([](auto& v) { v.push_back(v.back()); }, array.values);
    EXPECT_NE(failures(shape, flat).find("has no area"), std::string::npos) << far;
  }
}

INSTANTIATE_TEST_SUITE_P(Voxels, AtDistance, ::testing::Range(3, 13),
                         [](const auto& power) { return fmt::format("PowerOfTen{}", power.param); });

}  // namespace verify_far_test
}  // namespace quench
