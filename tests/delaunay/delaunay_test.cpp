// SPDX-License-Identifier: Apache-2.0
#include "delaunay/delaunay.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "delaunay/polytopes.h"
#include "delaunay/site_order.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"
#include "same_dual.h"

namespace quench::delaunay {
namespace delaunay_test {

// Six times the volume, in lattice units, of the tetrahedra inside O: they must tile O exactly.
void expect_tiles(const VoxelShape& shape, const std::string& where) {
  const auto spacing = integer_spacing(shape.grid());
  const auto sites = boundary_vertices(shape);
  auto delaunay = std::make_unique<Delaunay>(sites, spacing, nullptr);
  ASSERT_NO_THROW(delaunay->validate()) << where;
  const Polytopes polytopes = polytopes_inside(shape, std::move(delaunay), sites, nullptr);
  Int128 volume = 0;
  for (const Tetrahedron& t : polytopes.tetrahedra) {
    std::array<Point, 4> p;
    for (int i = 0; i < 4; ++i) {
      const LatticePoint& s = sites[t.corner[i]];
      p[i] = {s[0], s[1], s[2], 0};
    }
    const auto six = orientation_determinant<std::int64_t>(p[0], p[1], p[2], p[3]);
    ASSERT_GT(six, 0) << where;
    volume += six;
  }
  ASSERT_TRUE(volume == static_cast<Int128>(6) * shape.voxel_count()) << where;
}

TEST(Delaunay, IsDelaunayAndItsInsideTilesRandomShapes) {
  for (std::uint64_t seed = 0; seed < 600; ++seed)
    expect_tiles(testing_shapes::random_shape(seed, 12, seed % 3 == 0), "seed " + std::to_string(seed));
}

TEST(Delaunay, IsDelaunayAndItsInsideTilesLargerShapes) {
  for (const char* name : {"ellipsoid", "rippled-box", "plate-with-holes", "hollow-sphere"})
    expect_tiles(voxelize(make_sample(name).mesh, {.resolution = 96}).shape, name);
  expect_tiles(testing_shapes::box_shape(40, 40, 3), "flat box");  // huge cospherical sets
  expect_tiles(testing_shapes::box_shape(30, 30, 30), "cube");
  expect_tiles(testing_shapes::box_shape(1, 1, 3000), "long bar");  // beyond doubles and 64 bits
  expect_tiles(testing_shapes::box_shape(3, 3, 900), "thick bar");
}

TEST(Delaunay, WideCoordinatesAndSkewSpacingAreExact) {
  // Small parts at opposite ends of a grid as long as the limits allow.
  expect_tiles(testing_duals::far_apart(500000), "far apart");
  Grid skew;
  skew.dims = {9, 8, 7};
  skew.spacing = {1, 1000, 1};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 8);
    skew.dims = shape.grid().dims;
    expect_tiles(testing_shapes::from_predicate(skew, [&](int x, int y, int z) { return shape.contains(x, y, z); }),
                 "skew spacing");
  }
}

// Sites near a sphere and a few in its middle, which see most of the others: cavities of hundreds of corners.
TEST(Delaunay, LargeCavities) {
  std::vector<LatticePoint> sites;
  for (int z = -30; z <= 30; ++z)
    for (int y = -30; y <= 30; ++y)
      for (int x = -30; x <= 30; ++x) {
        const int squared = x * x + y * y + z * z;
        const bool middle = std::abs(x) <= 1 && std::abs(y) <= 1 && std::abs(z) <= 1;
        if (middle || (squared > 29 * 29 && squared <= 30 * 30)) sites.push_back({x, y, z});
      }
  for (const int threads : {1, 4}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    EXPECT_NO_THROW(Delaunay(sites, {1, 1, 1}, nullptr).validate()) << threads;
  }
}

// Lattice points of the longest grid go up to 2^20 and need 21 bits: the last one must not move others' rounds.
TEST(InsertionOrder, EveryRoundHasSitesFromBothEndsOfTheLongestGrid) {
  std::vector<LatticePoint> sites;
  for (std::int32_t z = 0; z < 128; ++z)
    for (std::int32_t y = 0; y < 128; ++y)
      for (const std::int32_t x : {0, 1 << 20}) sites.push_back({x, y, z});
  const std::vector<std::uint32_t> order = insertion_order(sites);
  std::vector<std::uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  for (std::size_t begin = 0, end = 1024; end <= order.size(); begin = end, end *= 2) {
    const auto far = std::count_if(order.begin() + static_cast<std::ptrdiff_t>(begin),
                                   order.begin() + static_cast<std::ptrdiff_t>(end),
                                   [&](std::uint32_t i) { return sites[i][0] > 0; });
    EXPECT_NEAR(static_cast<double>(far) / static_cast<double>(end - begin), 0.5, 0.2) << begin;
  }
}

// Ranges of few sites: most polytopes have tetrahedra in several.
TEST(Polytopes, DoNotDependOnRanges) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const VoxelShape shape =
        seed == 0 ? testing_shapes::box_shape(9, 9, 9) : testing_shapes::random_shape(seed, 10, seed % 3 == 0);
    const auto sites = boundary_vertices(shape);
    const auto polytopes = [&](std::size_t range) {
      auto delaunay = std::make_unique<Delaunay>(sites, integer_spacing(shape.grid()), nullptr);
      return polytopes_inside(shape, std::move(delaunay), sites, nullptr, range);
    };
    const Polytopes whole = polytopes(sites.size());
    for (const std::size_t range : {std::size_t{1}, std::size_t{3}, std::size_t{17}}) {
      const Polytopes parts = polytopes(range);
      ASSERT_EQ(parts.sites, whole.sites) << "seed " << seed;
      ASSERT_EQ(parts.site_offsets, whole.site_offsets) << "seed " << seed;
      ASSERT_EQ(parts.member_offsets, whole.member_offsets) << "seed " << seed;
      for (std::uint32_t p = 0; p < parts.count(); ++p)
        for (std::uint32_t m = parts.member_offsets[p]; m < parts.member_offsets[p + 1]; ++m)
          ASSERT_EQ(parts.polytope_of[parts.members[m]], p) << "seed " << seed;
    }
  }
}

// The fast paths against plain 128-bit evaluation, on points around ties at every magnitude.
TEST(Predicates, FilteredSignsAreExact) {
  std::mt19937_64 random(7);
  for (const std::array<std::int64_t, 3> spacing :
       {std::array<std::int64_t, 3>{1, 1, 1}, {391, 391, 2500}, {1, 2, 3}}) {
    const Predicates predicates(spacing, std::int64_t{1} << 20);
    const auto& w = predicates.weights();
    int ties = 0;
    for (int i = 0; i < 60000; ++i) {
      const int range = 1 << (1 + i % 19);
      if (range > (1 << 20) / 2500) {
        if (spacing[2] == 2500) continue;
      }
      const auto coordinate = [&] { return static_cast<std::int32_t>(random() % static_cast<unsigned>(range)); };
      // Corners of a box and their mirror images are cospherical; the fifth point is one of them or next to one.
      const std::int32_t x = coordinate() + 1, y = coordinate() + 1, z = coordinate() + 1;
      Point p[5] = {{0, 0, 0, 0}, {x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {x, y, z, 0}};
      const auto nudge = static_cast<std::int32_t>(random() % 5);
      if (nudge < 3) p[4].x += nudge - 1;
      const auto lift = [&](const Point& a) {
        const Int128 dx = a.x - p[4].x, dy = a.y - p[4].y, dz = a.z - p[4].z;
        return w[0] * dx * dx + w[1] * dy * dy + w[2] * dz * dz;
      };
      // Cofactors along the lifted column.
      Int128 det = 0;
      for (int k = 0; k < 4; ++k) {
        Point q[3];
        for (int j = 0, m = 0; j < 4; ++j)
          if (j != k) q[m++] = p[j];
        const Int128 minor = orientation_determinant<Int128>(p[4], q[0], q[1], q[2]);
        det += (k % 2 ? -1 : 1) * lift(p[k]) * minor;
      }
      const int expected = (det > 0) - (det < 0);
      ASSERT_EQ(predicates.in_sphere(p[0], p[1], p[2], p[3], p[4]), expected) << "range " << range;
      ASSERT_EQ(predicates.on_sphere(predicates.sphere(p[0], p[1], p[2], p[3]), p[4]), expected == 0)
          << "range " << range;
      ties += expected == 0;
    }
    EXPECT_GT(ties, 1000);
  }
}

}  // namespace delaunay_test
}  // namespace quench::delaunay
