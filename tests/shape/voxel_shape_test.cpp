// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "quench/error.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace voxel_shape_test {

// Straight from the definition of boundary vertices.
std::vector<LatticePoint> sites_by_definition(const VoxelShape& shape) {
  std::vector<LatticePoint> sites;
  const auto& d = shape.grid().dims;
  for (int z = 0; z <= d[2]; ++z)
    for (int y = 0; y <= d[1]; ++y)
      for (int x = 0; x <= d[0]; ++x) {
        int inside = 0;
        for (int c = 0; c < 8; ++c) inside += shape.contains(x - (c & 1), y - (c >> 1 & 1), z - (c >> 2));
        if (inside != 0 && inside != 8) sites.push_back({x, y, z});
      }
  return sites;
}

TEST(BoundaryVertices, EqualTheDefinitionOnRandomShapes) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed);
    shape.validate();
    EXPECT_EQ(boundary_vertices(shape), sites_by_definition(shape)) << "seed " << seed;
  }
}

TEST(VoxelShape, MergesTouchingRunsAndDropsEmptyOnes) {
  Grid grid;
  grid.dims = {10, 1, 1};
  VoxelShape shape(grid);
  const std::vector<quench::Run> runs{{0, 2}, {2, 3}, {4, 4}, {5, 9}};
  shape.append_row(runs);
  shape.validate();
  ASSERT_EQ(shape.row(0, 0).size(), 2u);
  EXPECT_EQ(shape.row(0, 0)[0], (quench::Run{0, 3}));
  EXPECT_EQ(shape.row(0, 0)[1], (quench::Run{5, 9}));
  EXPECT_EQ(shape.voxel_count(), 7);
  EXPECT_FALSE(shape.contains(3, 0, 0));
  EXPECT_TRUE(shape.contains(8, 0, 0));
  EXPECT_FALSE(shape.contains(0, -1, 0));
}

TEST(VoxelShape, SubdivideKeepsTheWorld) {
  Grid grid;
  grid.dims = {3, 2, 2};
  grid.spacing = {1, 2, 5};
  grid.origin = {10, 20, 30};
  VoxelShape shape(grid);
  const std::vector<quench::Run> one{{1, 2}};
  for (int r = 0; r < 4; ++r)
    shape.append_row(r == 3 ? std::span<const quench::Run>(one) : std::span<const quench::Run>());
  const VoxelShape fine = subdivide(shape, 3);
  fine.validate();
  EXPECT_EQ(fine.voxel_count(), 27);
  EXPECT_TRUE(fine.grid().world({3, 3, 3}).isApprox(shape.grid().world({1, 1, 1}), 1e-14));
  EXPECT_NEAR(fine.longest_side(), shape.longest_side(), 1e-12);
}

// Spacings as scanners write them: single precision, and lengths of columns of a matrix.
TEST(IntegerSpacing, NoiseOfScannersIsRounded) {
  const std::vector<std::pair<Vec3, std::array<std::int64_t, 3>>> scans{
      {{0.520832896232605, 0.5208337306976318, 0.6500001549720764}, {384, 384, 136}},
      {{0.9375000596046448, 0.9375, 1.5000009536743164}, {256, 256, 124}},
      {{0.48828125, 0.4882808327674866, 0.5000000596046448}, {512, 512, 301}},
      {{0.7031249403953552, 0.7031250596046448, 3.000001907348633}, {512, 512, 60}},
      {{0.8203125, 0.8203125, 1.2500006}, {512, 512, 220}},
      {{1.0000003576278687, 0.9999998211860657, 0.9999999403953552}, {240, 256, 176}}};
  for (const auto& [spacing, dims] : scans) {
    Grid grid;
    grid.dims = dims;
    grid.spacing = spacing;
    double moved = 0;
    grid.spacing = nearest_integer_spacing(grid, &moved);
    EXPECT_NO_THROW(integer_spacing(grid));
    EXPECT_LE(moved, 1e-2);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(grid.spacing[a] / spacing[a], 1, 1e-5);
    // The same again changes nothing more.
    EXPECT_EQ(nearest_integer_spacing(grid, &moved), grid.spacing);
    EXPECT_EQ(moved, 0);
  }
  // Rounded by hand: the nearest proportion that fits.
  for (const Vec3& spacing : {Vec3(0.52083, 0.52084, 0.65), Vec3(1, 1, 1.0001), Vec3(1, 1.00002, 1)}) {
    Grid rounded;
    rounded.dims = {384, 384, 136};
    rounded.spacing = spacing;
    double moved = 0;
    rounded.spacing = nearest_integer_spacing(rounded, &moved);
    EXPECT_NO_THROW(integer_spacing(rounded));
    EXPECT_GT(moved, 0);
    EXPECT_LT(moved, 0.05);
  }
  Grid odd;
  odd.dims = {4096, 4096, 4096};
  odd.spacing = {1, 1.0013333, 1.77777};
  EXPECT_EQ(nearest_integer_spacing(odd), odd.spacing);
  EXPECT_THROW(integer_spacing(odd), Error);
}

TEST(IntegerSpacing, FindsTheSmallestTriple) {
  Grid grid;
  grid.dims = {384, 320, 89};
  grid.spacing = {0.782, 0.782, 5};
  EXPECT_EQ(integer_spacing(grid), (std::array<std::int64_t, 3>{391, 391, 2500}));
  grid.spacing = {0.5, 0.5, 0.5};
  EXPECT_EQ(integer_spacing(grid), (std::array<std::int64_t, 3>{1, 1, 1}));
  grid.spacing = {1, 1.4142135623730951, 3.14159265358979};
  EXPECT_THROW(integer_spacing(grid), Error);
}

TEST(IntegerSpacing, IsOfLengthsThatCanBeComputedWith) {
  Grid grid;
  grid.dims = {3, 3, 3};
  const auto expect_refusal = [&](const std::string& part) {
    try {
      integer_spacing(grid);
      ADD_FAILURE() << grid.spacing.transpose() << "; " << grid.origin.transpose();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::input);
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  for (const double length : {1e-29, 1e29}) {
    grid.spacing.setConstant(length);
    EXPECT_EQ(integer_spacing(grid), (std::array<std::int64_t, 3>{1, 1, 1})) << length;
  }
  for (const double length : {1e-31, 1e-300, 1e31, 1e300}) {
    grid.spacing.setConstant(length);
    expect_refusal("beyond what can be computed with");
  }
  grid.spacing = {1e-3, 1e-3, 2e-3};
  for (const double far : {5e6, -9e8}) {
    grid.origin = {0, far, 0};
    EXPECT_EQ(integer_spacing(grid), (std::array<std::int64_t, 3>{1, 1, 2})) << far;
  }
  for (const double far : {-2e9, 1e300, HUGE_VAL, std::nan("")}) {
    grid.origin = {0, far, 0};
    expect_refusal("move it nearer");
  }
}

}  // namespace voxel_shape_test
}  // namespace quench
