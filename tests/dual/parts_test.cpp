// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "dual_of_triangulation.h"
#include "parts_in_rounds.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"
#include "same_dual.h"

namespace quench::dual::bricks {
namespace {

using testing_duals::Boxes;
using testing_duals::expect_same;
using testing_duals::Rounds;

constexpr std::size_t kAllRounds = 100;

// Boxes far smaller than cells, halos that miss most balls, boxes that begin anywhere.
const std::vector<Boxes> kBoxes{{4, 2}, {4, 5, {-1, -2, -3}}, {5, 1}, {6, 4, {3, 3, 3}}, {9, 3}, {64, 8}};

void expect_same_in_boxes(const VoxelShape& shape, std::span<const Boxes> all, std::size_t rounds,
                          const std::string& where) {
  const DualComplex whole = oracles::dual_of_triangulation(shape, boundary_vertices(shape));
  for (const Boxes& boxes : all) {
    const std::string what = where + ", boxes of " + std::to_string(boxes.size) + ", halo " +
                             std::to_string(boxes.halo) + ", rounds " + std::to_string(rounds);
    try {
      Rounds parts(shape, boxes);
      const Part part = parts.run(rounds);
      EXPECT_TRUE(part.sites == parts.sites()) << what;
      const PartComplex complex = complex_of(part, parts.hulls(), nullptr);
      expect_same(complex.dual, whole, what);
      EXPECT_EQ(std::ranges::count(complex.vertex_incomplete, 1), 0) << what;
    } catch (const std::exception& e) {
      FAIL() << what << ": " << e.what();
    }
  }
}

void expect_random_shapes_same(std::uint64_t first, std::uint64_t last, int largest, bool anisotropic) {
  testing_duals::for_random_shapes(
      first, last, largest, anisotropic, kBoxes, [](const VoxelShape& shape, auto ways, const std::string& where) {
        expect_same_in_boxes(shape, ways, where.back() % 3 == 0 ? 2 : kAllRounds, where);
      });
}

TEST(Parts, RandomShapesAreTheSame) {
  expect_random_shapes_same(0, 800, 8, false);
  expect_random_shapes_same(10000, 10040, 14, false);
}

TEST(Parts, AnisotropicShapesAreTheSame) {
  expect_random_shapes_same(0, 400, 8, true);
  testing_duals::for_spacings({Vec3(0.782, 0.782, 5), Vec3(1, 1000, 1)}, kBoxes,
                              [](const VoxelShape& shape, auto ways, const std::string& where) {
                                expect_same_in_boxes(shape, ways, kAllRounds, where);
                              });
}

// Cells larger than any region, and sites with nothing but such cells.
TEST(Parts, HugeCells) {
  const auto expect_all = [](const VoxelShape& shape, const std::string& where) {
    expect_same_in_boxes(shape, kBoxes, kAllRounds, where);
    expect_same_in_boxes(shape, kBoxes, 1, where);
  };
  expect_all(testing_shapes::box_shape(1, 1, 1), "voxel");
  expect_all(testing_shapes::box_shape(1, 1, 1, 0), "voxel without margin");
  expect_all(testing_shapes::box_shape(20, 20, 20), "cube");
  expect_all(testing_shapes::box_shape(24, 17, 2), "flat box");
  expect_all(testing_shapes::box_shape(1, 2, 70), "bar");
  expect_all(testing_duals::shells(0, 12, 0), "ball");
  expect_all(testing_duals::shells(0, 7, 0), "96 sites on a sphere");
  expect_all(testing_duals::shells(9, 12, 0), "hollow ball");
  expect_all(testing_duals::shells(9, 12, 2.5), "hollow ball with an axle");
}

// Parts with nothing between them.
TEST(Parts, FarApart) {
  expect_same_in_boxes(testing_duals::far_apart(40000), std::vector<Boxes>{{2, 2}, {64, 8}}, kAllRounds, "far apart");
}

TEST(Parts, TouchingWalls) {
  for (int rule = 0; rule < testing_duals::kWallRules; ++rule)
    expect_same_in_boxes(testing_duals::touching_walls(rule), kBoxes, kAllRounds, "rule " + std::to_string(rule));
}

TEST(Parts, MeshesAreTheSame) {
  for (const char* name : {"torus", "rippled-box", "plate-with-holes", "hollow-sphere"})
    expect_same_in_boxes(voxelize(make_sample(name).mesh, {.resolution = 64}).shape,
                         std::vector<Boxes>{{16, 4}, {32, 12, {5, 6, 7}}}, kAllRounds, name);
}

}  // namespace
}  // namespace quench::dual::bricks
