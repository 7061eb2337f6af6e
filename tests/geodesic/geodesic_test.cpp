// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "brute_force_geodesic.h"
#include "full_run.h"
#include "geodesic/pair_distances.h"
#include "geodesic/voxel_surface.h"
#include "geodesic/window_search.h"
#include "quench/context.h"
#include "quench/error.h"
#include "random_shapes.h"

namespace quench::geodesic {
namespace geodesic_test {

using brute_force::GeodesicOracle;
using testing_shapes::box_shape;
using testing_shapes::from_predicate;
using testing_shapes::random_shape;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::int64_t kLandmarkBytes = 100 << 20;

std::vector<double> distances_from(const VoxelSurface& surface, std::uint32_t from) {
  WindowSearch search(surface);
  search.search(from, {}, kInfinite, std::numeric_limits<std::int64_t>::max(), [](std::uint32_t) { return 0.0; });
  std::vector<double> distance(surface.points());
  for (std::uint32_t p = 0; p < surface.points(); ++p) distance[p] = search.distance(p);
  return distance;
}

// Points of the oracle that are at a place: several, where O touches itself. Of a voxel of its part the corner opposite
// to the vertex shows which point of the surface it is.
std::uint32_t point_of(const VoxelSurface& surface, const GeodesicOracle::Point& point) {
  LatticePoint from, to;
  for (std::size_t i = 0; i < 3; ++i) {
    from[i] = point.first[i];
    to[i] = 2 * point.second[i] + 1 - point.first[i];
  }
  return surface.point_towards(from, to);
}

void expect_as_oracle(const VoxelShape& shape, const std::string& what) {
  const VoxelSurface surface(shape);
  const GeodesicOracle oracle(shape);
  const auto points = oracle.points();
  ASSERT_EQ(points.size(), surface.points()) << what;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  std::vector<double> expected;
  for (const auto& from : points) {
    const std::uint32_t source = point_of(surface, from);
    ASSERT_NE(source, kNone) << what;
    const std::vector<double> found = distances_from(surface, source);
    const auto distances = oracle.distances(from);
    for (const auto& to : points) {
      const auto known = distances.find(to);
      const double d = known == distances.end() ? kInfinite : known->second / surface.unit();
      const std::uint32_t target = point_of(surface, to);
      if (d == kInfinite)
        ASSERT_EQ(found[target], kInfinite) << what;
      else
        ASSERT_NEAR(found[target], d, 1e-9 * (1 + d)) << what;
      pairs.push_back({source, target});
      expected.push_back(d);
    }
  }
  const std::vector<double> of_pairs = pair_distances(surface, pairs, kLandmarkBytes, nullptr);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (expected[i] == kInfinite)
      ASSERT_EQ(of_pairs[i], kInfinite) << what;
    else
      ASSERT_NEAR(of_pairs[i], expected[i], 1e-9 * (1 + expected[i])) << what;
}

// Noise in grids of 1 to 4 voxels along each side.
VoxelShape tiny_shape(std::uint64_t seed, bool equal_steps) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return static_cast<int>(random() % n); };
  Grid grid;
  for (auto& d : grid.dims) d = 1 + below(seed % 8 == 0 ? 4 : 3);
  if (!equal_steps)
    for (int a = 0; a < 3; ++a) grid.spacing[a] = 1 + below(5);
  const int density = 1 + below(9);
  const VoxelShape shape = from_predicate(grid, [&](int, int, int) { return below(10) < density; });
  return shape.empty() ? box_shape(1, 2, 3) : shape;
}

TEST(Geodesic, TinyShapesAreThoseOfTheOracle) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFatalFailure(); seed += repeats(1, 3))
    expect_as_oracle(tiny_shape(seed, seed % 4 != 0), "seed " + std::to_string(seed));
}

TEST(Geodesic, SmallShapesAreThoseOfTheOracle) {
  for (std::uint64_t seed = 0; seed < 40 && !testing::Test::HasFatalFailure(); seed += repeats(1, 2))
    expect_as_oracle(random_shape(seed, 5, seed % 3 == 0), "seed " + std::to_string(seed));
  for (std::uint64_t seed = 1; seed < 16 && !testing::Test::HasFatalFailure(); seed += repeats(2, 4))
    expect_as_oracle(random_shape(seed, 8), "larger, seed " + std::to_string(seed));
}

std::uint32_t at(const VoxelSurface& surface, LatticePoint point, LatticePoint towards) {
  return surface.point_towards(point, towards);
}

double distance(const VoxelShape& shape, LatticePoint a, LatticePoint b) {
  const VoxelSurface surface(shape);
  return distances_from(surface, at(surface, a, b))[at(surface, b, a)];
}

// Opposite corners of a box: the shortest of three unfoldings.
TEST(Geodesic, BoxesHaveClosedForms) {
  for (const auto& [a, b, c] : {std::array{1, 1, 1}, {3, 4, 5}, {2, 2, 9}, {12, 7, 1}, {30, 12, 12}}) {
    const double expected =
        std::sqrt(std::min({(a + b) * (a + b) + c * c, (a + c) * (a + c) + b * b, (b + c) * (b + c) + a * a}));
    EXPECT_DOUBLE_EQ(distance(box_shape(a, b, c, 1), {1, 1, 1}, {a + 1, b + 1, c + 1}), expected)
        << a << ' ' << b << ' ' << c;
  }
}

// A bar of 70: with a bound of 64 the search says that it is not exact, with one of 128 the length is right.
TEST(Geodesic, WaysThatAreTooLongForExactDecisionsAreRefused) {
  const VoxelSurface surface(box_shape(2, 2, 70, 0));
  const auto search = [&](double exact) {
    WindowSearch windows(surface, exact);
    windows.search(at(surface, {1, 0, 0}, {1, 1, 1}), {}, kInfinite, std::numeric_limits<std::int64_t>::max(),
                   [](std::uint32_t) { return 0.0; });
    return windows.distance(at(surface, {1, 0, 70}, {1, 1, 0}));
  };
  try {
    search(64);
    ADD_FAILURE() << "was found";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::failed);
    EXPECT_NE(std::string(e.what()).find("too long for exact distances"), std::string::npos) << e.what();
  }
  EXPECT_EQ(search(128), 70);
  EXPECT_EQ(search(WindowSearch::kExact), 70);
}

// Dudeney's spider and fly: a room of 30 x 12 x 12, one foot below the ceiling and one above the floor on opposite
// walls: 40 over five walls.
TEST(Geodesic, SpiderAndFly) {
  EXPECT_DOUBLE_EQ(distance(box_shape(30, 12, 12, 0), {0, 6, 11}, {30, 6, 1}), 40);
  EXPECT_DOUBLE_EQ(distance(box_shape(60, 24, 24, 0), {0, 12, 22}, {60, 12, 2}), 80);
  // The point of the box 1 x 1 x 2 that is farthest from a corner is not the opposite corner (Kotani).
  const VoxelSurface surface(box_shape(8, 8, 16, 0));
  const std::vector<double> d = distances_from(surface, at(surface, {0, 0, 0}, {1, 1, 1}));
  EXPECT_DOUBLE_EQ(d[at(surface, {8, 8, 16}, {0, 0, 0})], std::sqrt(2.0) * 16);
  EXPECT_DOUBLE_EQ(d[at(surface, {6, 6, 16}, {6, 6, 0})], std::sqrt(130.0) / 8 * 16);
}

// Around the reflex edge of an L the way is straight on the flat sides, bent at the vertex on the top.
TEST(Geodesic, WaysBendAtReflexCorners) {
  Grid grid;
  grid.dims = {20, 20, 3};
  const VoxelShape shape = from_predicate(grid, [](int x, int y, int) { return x < 8 || y < 8; });
  EXPECT_DOUBLE_EQ(distance(shape, {8, 20, 3}, {8, 8, 3}), 12);
  const VoxelSurface surface(shape);
  const std::vector<double> d = distances_from(surface, at(surface, {5, 20, 3}, {5, 20, 0}));
  EXPECT_DOUBLE_EQ(d[at(surface, {20, 5, 3}, {20, 5, 0})], 2 * std::hypot(3, 12));
}

// Around a square hole both ways, and the shorter one is taken.
TEST(Geodesic, WaysGoAroundHoles) {
  Grid grid;
  grid.dims = {31, 31, 1};
  const VoxelShape ring =
      from_predicate(grid, [](int x, int y, int) { return !(x >= 10 && x < 21 && y >= 10 && y < 21); });
  const VoxelSurface surface(ring);
  EXPECT_EQ(surface.component(at(surface, {0, 0, 0}, {1, 1, 1})),
            surface.component(at(surface, {10, 10, 0}, {9, 9, 1})));
  // Over the wall of the hole and its floor is no way: the hole has none.
  const std::vector<double> d = distances_from(surface, at(surface, {0, 14, 0}, {5, 14, 1}));
  const double up = std::hypot(10, 4) + 11 + std::hypot(10, 4), down = std::hypot(10, 7) + 11 + std::hypot(10, 7);
  EXPECT_DOUBLE_EQ(d[at(surface, {31, 14, 0}, {20, 14, 1})], std::min(up, down));
}

// A shell has two sides, and no way between them; a tunnel of one voxel joins them.
TEST(Geodesic, ShellsHaveTwoSides) {
  const auto shell = [](bool tunnel) {
    return [=](int x, int y, int z) {
      const bool inner = x > 1 && x < 7 && y > 1 && y < 7 && z > 1 && z < 7;
      return !inner && !(tunnel && y == 4 && z == 4 && x < 4);
    };
  };
  Grid grid;
  grid.dims = {9, 9, 9};
  EXPECT_EQ(distance(from_predicate(grid, shell(false)), {4, 0, 4}, {4, 2, 4}), kInfinite);
  EXPECT_LT(distance(from_predicate(grid, shell(true)), {4, 0, 4}, {4, 2, 4}), 20);
  const VoxelShape shape = from_predicate(grid, shell(false));
  const VoxelSurface surface(shape);
  const std::array<std::uint32_t, 2> pair{at(surface, {4, 0, 4}, {4, 2, 4}), at(surface, {4, 2, 4}, {4, 0, 4})};
  EXPECT_EQ(pair_distances(surface, {&pair, 1}, kLandmarkBytes, nullptr), std::vector<double>{kInfinite});
}

// Two boxes that touch in an edge or a vertex are apart; two pits that touch are joined.
TEST(Geodesic, TouchingIsThatOfTheVoxelShape) {
  Grid grid;
  grid.dims = {4, 4, 4};
  for (const bool edge : {true, false}) {
    const auto two = [=](int x, int y, int z) {
      return x < 2 && y < 2 && z < 2 ? true : x >= 2 && y >= 2 && (edge ? z < 2 : z >= 2);
    };
    const VoxelSurface apart(from_predicate(grid, two));
    const std::uint32_t a = at(apart, {2, 2, 2}, {1, 1, 1}),
                        b = at(apart, {2, 2, 2}, edge ? LatticePoint{3, 3, 1} : LatticePoint{3, 3, 3});
    EXPECT_NE(a, b);
    EXPECT_NE(apart.component(a), apart.component(b));
    const VoxelSurface joined(from_predicate(grid, [&](int x, int y, int z) { return !two(x, y, z); }));
    const std::uint32_t c = at(joined, {1, 1, 2}, {1, 1, 3}),
                        d = at(joined, {3, 3, 2}, edge ? LatticePoint{3, 3, 3} : LatticePoint{3, 3, 1});
    EXPECT_EQ(joined.component(c), joined.component(d));
    EXPECT_DOUBLE_EQ(distances_from(joined, c)[d], 2 * std::sqrt(2.0));
  }
}

// The 48 symmetries of the grid, and a shift.
TEST(Geodesic, SymmetriesAndShiftsChangeNothing) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const VoxelShape shape = random_shape(seed, 12);
    const VoxelSurface surface(shape);
    const auto& dims = shape.grid().dims;
    for (int symmetry = 0; symmetry < 48; ++symmetry) {
      std::array<std::size_t, 3> axis{0, 1, 2};
      for (int i = 0; i < symmetry / 8; ++i) std::next_permutation(axis.begin(), axis.end());
      Grid grid;
      const int shift = 1 + symmetry % 3;
      for (std::size_t i = 0; i < 3; ++i) grid.dims[i] = dims[axis[i]] + shift;
      const auto mirrored = [&](std::size_t i) { return (symmetry >> i & 1) != 0; };
      const VoxelShape other = from_predicate(grid, [&](int x, int y, int z) {
        std::array<std::int64_t, 3> v{};
        const std::array<int, 3> place{x - shift, y - shift, z - shift};
        for (std::size_t i = 0; i < 3; ++i) v[axis[i]] = mirrored(i) ? dims[axis[i]] - 1 - place[i] : place[i];
        return shape.contains(v[0], v[1], v[2]);
      });
      const auto moved = [&](const LatticePoint& p) {
        LatticePoint q{};
        for (std::size_t i = 0; i < 3; ++i)
          q[i] = shift + (mirrored(i) ? static_cast<std::int32_t>(dims[axis[i]]) - p[axis[i]] : p[axis[i]]);
        return q;
      };
      const VoxelSurface other_surface(other);
      ASSERT_EQ(surface.points(), other_surface.points());
      std::vector<double> expected, found;
      for (std::uint32_t p = 0; p < surface.points(); p += 7) {
        const LatticePoint from = surface.place(p);
        for (const int x : {-1, 1})
          for (const int y : {-1, 1})
            for (const int z : {-1, 1}) {
              const LatticePoint to{from[0] + x, from[1] + y, from[2] + z};
              const std::uint32_t a = at(surface, from, to), b = at(other_surface, moved(from), moved(to));
              ASSERT_EQ(a == kNone, b == kNone);
              if (a == kNone) continue;
              if (expected.empty()) {
                expected = distances_from(surface, a);
                found = distances_from(other_surface, b);
              }
              if (expected[a] == kInfinite)
                ASSERT_EQ(found[b], kInfinite);
              else
                ASSERT_NEAR(expected[a], found[b], 1e-10);
            }
      }
    }
  }
}

// More pairs than a chunk, far ones too: any number of threads, one result, bit for bit, and that of a plain search.
TEST(Geodesic, ThreadsAndLandmarksChangeNothing) {
  Grid grid;
  grid.dims = {70, 50, 24};
  const VoxelShape shape = from_predicate(grid, [](int x, int y, int z) {
    return z < 18 + (x * 7 / 5 + y) % 5 && !(x > 20 && x < 30 && y > 20 && y < 30) &&
           !(z > 8 && z < 14 && y < 30 && x > 40);
  });
  const VoxelSurface surface(shape);
  std::mt19937_64 random(5);
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (int i = 0; i < 1200; ++i)
    pairs.push_back({static_cast<std::uint32_t>(random() % 40 * (surface.points() / 40)),
                     static_cast<std::uint32_t>(random() % surface.points())});
  Context one, three;
  one.threads = 1;
  three.threads = 3;
  PairCounts counts;
  const std::vector<double> found = pair_distances(surface, pairs, kLandmarkBytes, &one, &counts);
  EXPECT_GT(counts.far, 400u);
  EXPECT_GT(counts.landmarks, 10u);
  EXPECT_EQ(found, pair_distances(surface, pairs, kLandmarkBytes, &three));
  const std::vector<double> few = pair_distances(surface, pairs, 1, &one, &counts);
  EXPECT_EQ(counts.landmarks, 1u);
  std::map<std::uint32_t, std::vector<double>> expected;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    auto& from = expected[pairs[i][0]];
    if (from.empty()) from = distances_from(surface, pairs[i][0]);
    ASSERT_NEAR(found[i], from[pairs[i][1]], 1e-9);
    ASSERT_NEAR(few[i], from[pairs[i][1]], 1e-9);
  }
}

}  // namespace geodesic_test
}  // namespace quench::geodesic
