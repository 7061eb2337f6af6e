// SPDX-License-Identifier: Apache-2.0
// Thinning of any complex with any values against the naive one; prune_test.cpp has that of voxel cores.
#include "complex/thinning.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "naive_thinning.h"
#include "quench/axis.h"
#include "random_complexes.h"
#include "random_shapes.h"

namespace quench {
namespace thinning_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Input {
  CellComplex complex;
  CellValues value;
};

Input core_of(const VoxelShape& shape, LambdaRule rule) {
  MedialAxis axis = voxel_core(shape, {.rule = rule});
  return {std::move(axis.complex), std::move(axis.measure().value)};
}

CellValues thinned(const Input& input) {
  return complex::thin(input.complex, input.value.vertex, input.value.edge, input.value.face, nullptr, "");
}

void expect_naive_levels(const Input& input) {
  const testing_complexes::NaiveThinning expected(input.complex, input.value);
  const CellValues level = thinned(input);
  ASSERT_EQ(level.vertex, expected.vertex);
  ASSERT_EQ(level.edge, expected.edge);
  ASSERT_EQ(level.face, expected.face);
}

// Other numbers for all cells.
Input shuffled(const Input& input, std::mt19937_64& random) {
  const CellComplex& from = input.complex;
  const auto order = [&random](std::size_t count) {
    std::vector<std::uint32_t> place(count);
    std::iota(place.begin(), place.end(), 0u);
    std::shuffle(place.begin(), place.end(), random);
    return place;
  };
  const auto moved = [](const std::vector<double>& values, const std::vector<std::uint32_t>& place) {
    std::vector<double> result(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) result[place[i]] = values[i];
    return result;
  };
  const auto vertex = order(from.vertex_count), edge = order(from.edges.size()), face = order(from.face_count());
  Input result;
  result.value = {moved(input.value.vertex, vertex), moved(input.value.edge, edge), moved(input.value.face, face)};
  CellComplex& to = result.complex;
  to.vertex_count = from.vertex_count;
  to.edges.resize(from.edges.size());
  for (std::size_t e = 0; e < edge.size(); ++e) {
    const std::uint32_t a = vertex[from.edges[e][0]], b = vertex[from.edges[e][1]];
    to.edges[edge[e]] = {std::min(a, b), std::max(a, b)};
  }
  std::vector<std::uint32_t> old(face.size());
  for (std::uint32_t f = 0; f < face.size(); ++f) old[face[f]] = f;
  for (const std::uint32_t f : old) {
    for (const std::uint32_t v : from.corners(f)) to.face_vertices.push_back(vertex[v]);
    for (const std::uint32_t e : from.sides(f)) to.face_edges.push_back(edge[e]);
    to.face_offsets.push_back(static_cast<std::uint32_t>(to.face_vertices.size()));
  }
  to.validate();
  return result;
}

TEST(Thinning, WhateverTheNumbersOfCells) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    expect_naive_levels(shuffled(core_of(testing_shapes::random_shape(seed, 6), LambdaRule::coface), random));
    if (HasFatalFailure()) return;
  }
}

// Values that have nothing to do with each other: few and many different ones, 0, and cells that are never removed.
TEST(Thinning, WhateverTheValues) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    Input input = core_of(testing_shapes::random_shape(seed, 6), LambdaRule::coface);
    const std::uint64_t different = seed % 3 == 0 ? 3 : seed % 3 == 1 ? 20 : 1'000'000'000;
    for (auto* values : {&input.value.vertex, &input.value.edge, &input.value.face})
      for (double& value : *values) value = random() % 64 == 0 ? kInfinity : static_cast<double>(random() % different);
    expect_naive_levels(input);
    if (HasFatalFailure()) return;
  }
}

TEST(Thinning, WhateverTheComplex) {
  std::size_t removed = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto below = [&random](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
    Input input;
    const CellComplex& complex = input.complex = testing_complexes::any_complex(random, seed % 2 == 1);
    const std::uint32_t different = seed % 3 ? 6 : 1000;
    const auto fill = [&](std::vector<double>& values, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i)
        values.push_back(below(16) == 0 ? kInfinity : static_cast<double>(below(different)));
    };
    fill(input.value.vertex, complex.vertex_count);
    fill(input.value.edge, complex.edges.size());
    fill(input.value.face, complex.face_count());
    expect_naive_levels(input);
    if (HasFatalFailure()) return;
    const CellValues level = thinned(input);
    removed += static_cast<std::size_t>(
        std::count_if(level.face.begin(), level.face.end(), [](double l) { return l < kInfinity; }));
  }
  EXPECT_GT(removed, 3000u);
}

TEST(Thinning, NothingAndLittle) {
  const std::vector<std::array<std::uint32_t, 2>> edge{{0, 1}};
  expect_naive_levels({});
  expect_naive_levels({make_complex(1, {}, {0}, {}), {{1}, {}, {}}});
  expect_naive_levels({make_complex(2, edge, {0}, {}), {{1, 1}, {1}, {}}});
  expect_naive_levels({make_complex(2, edge, {0}, {}), {{1, 1}, {kInfinity}, {}}});
}

VoxelShape two_balls(int side) {
  Grid grid;
  grid.dims = {side, side, 2 * side};
  return testing_shapes::from_predicate(grid, [side](int x, int y, int z) {
    const double half = 0.5 * side;
    const double dx = x + 0.5 - half, dy = y + 0.5 - half, dz = z % side + 0.5 - half, bump = 0.02 * ((x * y + z) % 9);
    return dx * dx + dy * dy + dz * dz < (0.46 - 0.1 * bump) * side * (0.46 - 0.1 * bump) * side ||
           (dx * dx + dy * dy < 9 && z > half && z < 3 * half);
  });
}

// Large enough for several chunks of edges.
TEST(Thinning, ManyThreadsGiveTheLevelsOfOne) {
  MedialAxis axis = voxel_core(two_balls(112));
  ASSERT_GT(axis.complex.edges.size(), std::size_t{1} << 18);
  tbb::task_arena(1).execute([&] { prune_levels(axis); });
  const MedialAxis one = axis;
  for (const int threads : {2, 4}) {
    tbb::task_arena(threads).execute([&] { prune_levels(axis); });
    EXPECT_TRUE(axis.measure().level == one.measure().level);
  }
}

TEST(Thinning, ProgressGrowsAndCancelStopsIt) {
  MedialAxis axis = voxel_core(two_balls(112));
  Context context;
  std::vector<double> told;
  context.progress = [&](std::string_view, double fraction) { told.push_back(fraction); };
  tbb::task_arena(3).execute([&] { prune_levels(axis, &context); });
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  const std::size_t steps = told.size();
  ASSERT_GE(steps, 3u);
  context.progress = [&](std::string_view, double) { context.cancel(); };
  try {
    tbb::task_arena(3).execute([&] { prune_levels(axis, &context); });
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

}  // namespace thinning_test
}  // namespace quench
