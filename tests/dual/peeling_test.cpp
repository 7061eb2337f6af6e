// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstdlib>
#include <filesystem>

#include "dual/peel/peel.h"
#include "dual/peel/remainder.h"
#include "dual_of_triangulation.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"
#include "same_dual.h"

namespace quench::dual::peel {
namespace peeling_test {

Options always(double reach, std::int32_t layers) { return {reach, layers, 0, 0, std::size_t{1} << 40}; }

// Unit cubes only, balls of every size, slabs thinner than the balls, everything peeled away.
const std::vector<Options> kOptions{always(3, 0), always(0, 0), always(1, 1),  always(1.5, 3),
                                    always(2, 2), always(4, 1), always(30, 0), always(30, 2)};

void expect_same_peeled(const VoxelShape& shape, std::span<const Options> options, int threads,
                        const std::string& where) {
  const auto sites = boundary_vertices(shape);
  const auto expected = oracles::dual_of_triangulation(shape, sites);
  for (const Options& o : options) {
    const std::string what = where + ", reach " + std::to_string(o.reach) + ", layers " + std::to_string(o.layers);
    try {
      tbb::task_arena arena(threads);
      const auto peeled =
          arena.execute([&] { return dual_complex(shape, sites, integer_spacing(shape.grid()), o, nullptr); });
      testing_duals::expect_same(peeled, expected, what);
    } catch (const std::exception& e) {
      FAIL() << what << ": " << e.what();
    }
    if (testing::Test::HasFatalFailure()) return;
  }
}

void expect_random_shapes_same(std::uint64_t first, std::uint64_t last, int largest, bool anisotropic, int threads) {
  testing_duals::for_random_shapes(first, last, largest, anisotropic, kOptions,
                                   [=](const VoxelShape& shape, auto ways, const std::string& where) {
                                     expect_same_peeled(shape, ways, threads, where);
                                   });
}

TEST(Peeling, RandomShapesAreTheSame) {
  expect_random_shapes_same(0, 1000, 8, false, 1);
  expect_random_shapes_same(10000, 10100, 14, false, 1);
}

TEST(Peeling, AnisotropicShapesAreTheSame) {
  expect_random_shapes_same(0, 500, 8, true, 1);
  testing_duals::for_spacings(
      {Vec3(0.782, 0.782, 5), Vec3(0.782, 1.1, 0.9), Vec3(1, 1000, 1)}, kOptions,
      [](const VoxelShape& shape, auto ways, const std::string& where) { expect_same_peeled(shape, ways, 1, where); });
}

TEST(Peeling, ThreadsDoNotMatter) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
  expect_random_shapes_same(20000, 20200, 9, false, 4);
  // High enough for a slab for each thread, with more sites at its foot.
  Grid grid;
  grid.dims = {20, 20, 300};
  const VoxelShape tower = testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const unsigned noise = (static_cast<unsigned>(x + 20 * (y + 20 * z)) * 2654435761u) >> 24;
    const int half = z < 50 ? 9 : 4;
    return std::abs(x - 10) < half && std::abs(y - 10) < half && noise % 7 != 0;
  });
  expect_same_peeled(tower, std::vector<Options>{always(3, 0), always(1.5, 0)}, 4, "tower");
}

TEST(Peeling, HugeCells) {
  using testing_shapes::box_shape;
  expect_same_peeled(box_shape(1, 1, 1), kOptions, 1, "voxel");
  expect_same_peeled(box_shape(1, 1, 1, 0), kOptions, 1, "voxel without margin");
  expect_same_peeled(box_shape(20, 20, 20), std::span(kOptions).first(7), 1, "cube");
  expect_same_peeled(box_shape(24, 17, 2), kOptions, 1, "flat box");
  expect_same_peeled(box_shape(1, 2, 70), kOptions, 1, "bar");
  expect_same_peeled(box_shape(70, 1, 1), kOptions, 1, "bar along x");
  expect_same_peeled(testing_duals::shells(0, 12, 0), kOptions, 1, "ball");
  expect_same_peeled(testing_duals::shells(0, 7, 0), kOptions, 1, "96 sites on a sphere");
  expect_same_peeled(testing_duals::shells(9, 12, 0), kOptions, 1, "hollow ball");
  expect_same_peeled(testing_duals::shells(9, 12, 2.5), kOptions, 1, "hollow ball with an axle");
}

TEST(Peeling, FarApartAndTouching) {
  expect_same_peeled(testing_duals::far_apart(40000), std::span(kOptions).first(3), 1, "far apart");
  const std::vector<Options> no_room{{3, 0, 0, 0, 0}};  // a grid too large for its sites
  expect_same_peeled(testing_duals::far_apart(40000), no_room, 1, "far apart in a huge grid");
  for (int rule = 0; rule < testing_duals::kWallRules; ++rule)
    expect_same_peeled(testing_duals::touching_walls(rule), kOptions, 1, "rule " + std::to_string(rule));
}

TEST(Peeling, MeshesAreTheSame) {
  const std::vector<Options> options{{}, always(2, 20)};
  for (const char* name : {"torus", "rippled-box", "plate-with-holes", "hollow-sphere"})
    expect_same_peeled(voxelize(make_sample(name).mesh, {.resolution = 96}).shape, options, 2, name);
  const auto file = std::filesystem::path(QUENCH_DATA) / "meshes/armadillo.off";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test data";
  const TriangleMesh mesh = to_triangle_mesh(io::read_record(file));
  expect_same_peeled(voxelize(mesh, {.resolution = 128}).shape, options, 2, "armadillo");
}

// Flat boundaries, where little is peeled, by the choices of the program.
TEST(Peeling, FlatShapesAreTheSame) {
  const std::vector<Options> options{{}, {3, 0, 0.125, 0}, {3, 8, 0.02, 0.02}, {3, 0, 0, 0, 0}};
  for (const char* name : {"box", "rippled-box", "fin-on-board"})
    expect_same_peeled(voxelize(make_sample(name).mesh, {.resolution = 64}).shape, options, 2, name);
}

TEST(Peeling, StopsWhenAsked) {
  const VoxelShape shape = testing_shapes::box_shape(20, 20, 20);
  const auto sites = boundary_vertices(shape);
  Context context;
  context.progress = [&](std::string_view, double fraction) {
    if (fraction > 0) context.cancel();
  };
  EXPECT_THROW(dual_complex(shape, sites, {1, 1, 1}, {}, &context), Error);
}

// Two voxels side by side, none of whose polytopes have been peeled: every boundary square is unmatched.
TEST(Peeling, EveryUnmatchedFacetIsClosedByOnePolytope) {
  std::vector<LatticePoint> sites;
  for (std::int32_t z = 0; z < 2; ++z)
    for (std::int32_t y = 0; y < 2; ++y)
      for (std::int32_t x = 0; x < 3; ++x) sites.push_back({x, y, z});
  const auto add = [](CellsPart& part, const Square& square) {
    Square sorted = square;
    std::sort(sorted.begin(), sorted.end());
    part.unmatched.push_back(
        {{sorted[0], sorted[1], sorted[2]}, kNone, static_cast<std::uint32_t>(part.squares.size())});
    part.squares.push_back(square);
  };
  const auto close = [&](CellsPart part) {
    Hulls hulls;
    add_remainder(sites, {1, 1, 1}, hulls, part, nullptr);
    EXPECT_TRUE(part.unmatched.empty());
    return part.cells.count();
  };
  CellsPart squares;  // counter-clockwise seen from inside
  for (const std::uint32_t x : {0u, 1u}) {
    add(squares, {6 + x, 9 + x, 10 + x, 7 + x});  // above
    add(squares, {x, x + 6, x + 7, x + 1});       // in front
    add(squares, {3 + x, 4 + x, 10 + x, 9 + x});  // behind
    add(squares, {x, 1 + x, 4 + x, 3 + x});       // below
  }
  add(squares, {0, 3, 9, 6});
  add(squares, {2, 8, 11, 5});
  EXPECT_EQ(close(squares), 2u);
  CellsPart idle = squares;
  add(idle, {0, 5, 8, 3});  // not a facet of any polytope
  EXPECT_THROW(close(idle), Error);
  CellsPart twice = squares;  // two polytopes would have to close one
  add(twice, squares.squares.back());
  EXPECT_THROW(close(twice), Error);
  CellsPart holed = squares;
  holed.unmatched.pop_back();
  EXPECT_THROW(close(holed), Error);
}

}  // namespace peeling_test
}  // namespace quench::dual::peel
