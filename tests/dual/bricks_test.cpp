// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

#include "dual/bricks/rounds.h"
#include "dual_of_triangulation.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"
#include "same_dual.h"

namespace quench::dual::bricks {
namespace {

using testing_duals::expect_same;

// Bricks far smaller than cells, halos that miss most balls, rounds that do not fit each other, everything left to the
// end. `at_once` = 0: even one site is divided.
const std::vector<BrickPlan> kPlans{
    {{{3, 2}, {6, 4}}, 0}, {{{4, 3}}, 0}, {{{2, 1}, {3, 1}, {4, 1}}, 0}, {{{5, 1}, {3, 6}, {4, 1}}, 0}, {{}, 0}};

void expect_same_in_bricks(const VoxelShape& shape, std::span<const BrickPlan> plans, int threads,
                           const std::string& where) {
  const auto sites = boundary_vertices(shape);
  const DualComplex whole = oracles::dual_of_triangulation(shape, sites);
  for (std::size_t p = 0; p < plans.size(); ++p) {
    const std::string what = where + ", plan " + std::to_string(p) + ", threads " + std::to_string(threads);
    try {
      tbb::task_arena arena(threads);
      const DualComplex parts =
          arena.execute([&] { return dual_complex(shape, sites, integer_spacing(shape.grid()), plans[p], nullptr); });
      expect_same(parts, whole, what);
    } catch (const std::exception& e) {
      FAIL() << what << ": " << e.what();
    }
  }
}

void expect_random_shapes_same(std::uint64_t first, std::uint64_t last, int largest, bool anisotropic, int threads) {
  testing_duals::for_random_shapes(first, last, largest, anisotropic, kPlans,
                                   [=](const VoxelShape& shape, auto ways, const std::string& where) {
                                     expect_same_in_bricks(shape, ways, threads, where);
                                   });
}

TEST(Bricks, RandomShapesAreTheSameInBricks) {
  expect_random_shapes_same(0, 800, 8, false, 1);
  expect_random_shapes_same(10000, 10040, 14, false, 1);
}

TEST(Bricks, AnisotropicShapesAreTheSameInBricks) {
  expect_random_shapes_same(0, 400, 8, true, 1);
  testing_duals::for_spacings({Vec3(0.782, 0.782, 5), Vec3(1, 1000, 1)}, kPlans,
                              [](const VoxelShape& shape, auto ways, const std::string& where) {
                                expect_same_in_bricks(shape, ways, 1, where);
                              });
}

TEST(Bricks, ThreadsDoNotMatter) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
  expect_random_shapes_same(20000, 20100, 9, false, 4);
}

// Cells larger than any region, and sites with nothing but such cells.
TEST(Bricks, HugeCells) {
  const std::vector<BrickPlan> plans{{{{3, 2}, {6, 4}}, 0}, {{{4, 3}, {10, 12}}, 0}};
  expect_same_in_bricks(testing_shapes::box_shape(1, 1, 1), plans, 1, "voxel");
  expect_same_in_bricks(testing_shapes::box_shape(1, 1, 1, 0), plans, 1, "voxel without margin");
  expect_same_in_bricks(testing_shapes::box_shape(20, 20, 20), plans, 1, "cube");
  expect_same_in_bricks(testing_shapes::box_shape(24, 17, 2), plans, 1, "flat box");
  expect_same_in_bricks(testing_shapes::box_shape(1, 2, 70), plans, 1, "bar");
  expect_same_in_bricks(testing_duals::shells(0, 12, 0), plans, 1, "ball");
  expect_same_in_bricks(testing_duals::shells(0, 7, 0), plans, 1, "96 sites on a sphere");
  expect_same_in_bricks(testing_duals::shells(9, 12, 0), plans, 1, "hollow ball");
  expect_same_in_bricks(testing_duals::shells(9, 12, 2.5), plans, 1, "hollow ball with an axle");
}

// Empty bricks between parts far apart.
TEST(Bricks, FarApart) {
  expect_same_in_bricks(testing_duals::far_apart(40000),
                        std::vector<BrickPlan>{{{{2, 2}, {100, 50}}, 0}, {{{64, 8}}, 0}}, 1, "far apart");
}

TEST(Bricks, TouchingWalls) {
  for (int rule = 0; rule < testing_duals::kWallRules; ++rule)
    expect_same_in_bricks(testing_duals::touching_walls(rule), kPlans, 1, "rule " + std::to_string(rule));
}

TEST(Bricks, MeshesAreTheSameInBricks) {
  for (const char* name : {"torus", "rippled-box", "plate-with-holes", "hollow-sphere"})
    expect_same_in_bricks(voxelize(make_sample(name).mesh, {.resolution = 64}).shape,
                          std::vector<BrickPlan>{{{{16, 4}, {32, 12}}, 0}}, 2, name);
  const auto file = std::filesystem::path(QUENCH_DATA) / "meshes/armadillo.off";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test data";
  const TriangleMesh mesh = to_triangle_mesh(io::read_record(file));
  expect_same_in_bricks(voxelize(mesh, {.resolution = 128}).shape,
                        std::vector<BrickPlan>{{{{16, 6}, {40, 20}}, 0}, {{{48, 8}}, 0}}, 2, "armadillo");
}

// The core of the library, with everything that follows from the complex.
TEST(Bricks, TheCoreIsTheSame) {
  const VoxelShape shape = voxelize(make_sample("torus").mesh, {.resolution = 160}).shape;
  const MedialAxis whole = voxel_core(shape), parts = voxel_core(shape, {.in_bricks = true});
  EXPECT_TRUE(whole.points == parts.points && whole.radius == parts.radius);
  EXPECT_TRUE(whole.measure().value == parts.measure().value && whole.face_sites == parts.face_sites);
  EXPECT_TRUE(whole.complex.face_edges == parts.complex.face_edges);
}

TEST(Bricks, StopsWhenAsked) {
  const VoxelShape shape = testing_shapes::box_shape(20, 20, 20);
  const auto sites = boundary_vertices(shape);
  Context context;
  context.progress = [&](std::string_view, double fraction) {
    if (fraction > 0) context.cancel();
  };
  EXPECT_THROW(dual_complex(shape, sites, {1, 1, 1}, {{{4, 2}}, 0}, &context), Error);
}

// A brick can take minutes: inside of it progress is told and cancel is seen.
TEST(Bricks, StopsInTheMiddleOfABrick) {
  const VoxelShape shape = testing_shapes::box_shape(20, 20, 20);
  const auto sites = boundary_vertices(shape);
  const auto fractions_until = [&](std::size_t last) {
    std::vector<double> fractions;
    Context context;
    context.progress = [&](std::string_view stage, double fraction) {
      if (stage != "delaunay") return;
      fractions.push_back(fraction);
      if (fractions.size() == last) context.cancel();
    };
    const BrickPlan eight{{{12, 2}}, 0};  // bricks in the first round
    const auto compute = [&] { dual_complex(shape, sites, {1, 1, 1}, eight, &context); };
    tbb::task_arena(1).execute([&] {
      if (last == 0)
        compute();
      else
        EXPECT_THROW(compute(), Error);
    });
    return fractions;
  };
  const std::vector<double> all = fractions_until(0);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_EQ(all.back(), 1);
  // Between the beginnings of two bricks, 0.7 / 8 apart.
  const auto inside = std::find_if(all.begin(), all.end(), [](double f) { return f > 0.01 && f < 0.7 / 8 - 0.01; });
  ASSERT_NE(inside, all.end());
  const auto calls = static_cast<std::size_t>(inside - all.begin()) + 1;
  EXPECT_EQ(fractions_until(calls).size(), calls);
}

}  // namespace
}  // namespace quench::dual::bricks
