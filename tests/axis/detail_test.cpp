// SPDX-License-Identifier: Apache-2.0
// Cap height, detail, and what the pruning by it promises (docs/algorithms/pruning.md).
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "quench/axis.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace detail_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const std::vector<Vec3>& spacings() {
  static const std::vector<Vec3> all{{1, 1, 1}, {1, 1, 2}, {0.5, 2, 1}, {0.782, 0.782, 5}};
  return all;
}

MedialAxis core_by_detail(const VoxelShape& shape) {
  MedialAxis axis = voxel_core(shape);
  add_detail(axis);
  prune_levels(axis, kDetail);
  return axis;
}

VoxelShape with_spacing(const VoxelShape& shape, const Vec3& spacing) {
  Grid grid = shape.grid();
  grid.spacing = spacing;
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return shape.contains(x, y, z); });
}

// The largest distance of a boundary vertex to the balls, one by one.
double brute_coverage(const VoxelShape& shape, const MedialAxis& axis) {
  double largest = 0;
  for (const LatticePoint& site : boundary_vertices(shape)) {
    double nearest = kInfinity;
    for (std::size_t v = 0; v < axis.points.size(); ++v)
      nearest = std::min(nearest, (shape.grid().world_of(site) - axis.points[v]).norm() - axis.radius[v]);
    largest = std::max(largest, nearest);
  }
  return largest;
}

TEST(CapHeight, IsTheSagittaOfItsDefinition) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const VoxelShape shape = with_spacing(testing_shapes::random_shape(seed, 6), spacings()[seed % spacings().size()]);
    const MedialAxis axis = voxel_core(shape);
    const CellValues height = derived_measure(axis, kCapHeight).value;
    const auto sagitta = [](double lambda, double r) { return r - std::sqrt(std::max(0.0, r * r - lambda * lambda)); };
    const CellComplex& c = axis.complex;
    std::vector<double> edge(c.edges.size(), -1), vertex(c.vertex_count, -1);
    for (std::size_t f = 0; f < c.face_count(); ++f) {
      const double lambda = 0.5 * (axis.grid.world_of(axis.sites[axis.face_sites[f][0]]) -
                                   axis.grid.world_of(axis.sites[axis.face_sites[f][1]]))
                                      .norm();
      double largest = 0;
      for (const std::uint32_t v : c.corners(f)) largest = std::max(largest, sagitta(lambda, axis.radius[v]));
      ASSERT_NEAR(height.face[f], largest, 1e-6) << seed;
      for (const std::uint32_t e : c.sides(f)) edge[e] = std::max(edge[e], height.face[f]);
    }
    for (std::size_t e = 0; e < edge.size(); ++e) {
      const auto [a, b] = c.edges[e];
      if (edge[e] < 0) edge[e] = sagitta(axis.measure().value.edge[e], std::min(axis.radius[a], axis.radius[b]));
      ASSERT_NEAR(height.edge[e], edge[e], 1e-6) << seed;
      for (const std::uint32_t v : c.edges[e]) vertex[v] = std::max(vertex[v], height.edge[e]);
    }
    for (std::uint32_t v = 0; v < c.vertex_count; ++v)
      ASSERT_NEAR(height.vertex[v], vertex[v] < 0 ? sagitta(axis.measure().value.vertex[v], axis.radius[v]) : vertex[v],
                  1e-6)
          << seed;
  }
}

// Voxels of a box whose centres lie below a plane.
struct FlatSide {
  Grid grid;
  std::array<std::int64_t, 3> normal{};
  std::int64_t offset = 0;
  bool contains(int x, int y, int z) const {
    return normal[0] * (2 * x + 1) + normal[1] * (2 * y + 1) + normal[2] * (2 * z + 1) <= 2 * offset;
  }
};

// The theorem: on a flat side of any orientation, also of anisotropic voxels, the cap height of a face is at most the
// distance of the middle of its two sites to the lattice.
TEST(CapHeight, OfStaircasesOfFlatSidesIsBounded) {
  std::mt19937 random(7);
  std::size_t faces = 0, attained = 0;
  for (int round = 0; round < 60; ++round) {
    constexpr int kSide = 36;
    FlatSide side;
    side.grid.dims = {kSide, kSide, kSide};
    side.grid.spacing = spacings()[static_cast<std::size_t>(round) % spacings().size()];
    std::uniform_int_distribution<std::int64_t> component(-9, 9);
    do
      for (auto& n : side.normal) n = component(random);
    while (side.normal == std::array<std::int64_t, 3>{});
    side.offset = (side.normal[0] + side.normal[1] + side.normal[2]) * kSide / 2;
    const VoxelShape shape =
        testing_shapes::from_predicate(side.grid, [&](int x, int y, int z) { return side.contains(x, y, z); });
    const MedialAxis axis = voxel_core(shape);
    const CellValues height = derived_measure(axis, kCapHeight).value;
    const auto inside = [&](const Vec3& p, double r) {  // a ball that meets the box of voxels only
      for (int a = 0; a < 3; ++a) {
        const double h = side.grid.spacing[a], x = side.grid.lattice(p)[a] * h;
        if (x - r < 1.5 * h || x + r > (kSide - 1.5) * h) return false;
      }
      return true;
    };
    for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
      const auto corners = axis.complex.corners(f);
      if (!std::ranges::all_of(corners, [&](std::uint32_t v) { return inside(axis.points[v], axis.radius[v]); }))
        continue;
      const LatticePoint &p = axis.sites[axis.face_sites[f][0]], &q = axis.sites[axis.face_sites[f][1]];
      double squared = 0;
      for (std::size_t a = 0; a < 3; ++a)
        if ((p[a] - q[a]) % 2 != 0) squared += std::pow(0.5 * side.grid.spacing[static_cast<int>(a)], 2);
      const double bound = std::sqrt(squared);
      ASSERT_LE(height.face[f], bound * (1 + 1e-12)) << "round " << round;
      ASSERT_LE(bound, auto_detail(side.grid) * (1 + 1e-15));
      ++faces;
      attained += height.face[f] > bound * (1 - 1e-9);
    }
  }
  EXPECT_GT(faces, 20000u);
  EXPECT_GT(attained, 100u);  // it is sharp
}

// So nothing of a flat side is significant: what is kept comes from its edges.
TEST(Detail, NothingIsSignificantUnderAFlatSide) {
  std::mt19937 random(11);
  for (int round = 0; round < 12; ++round) {
    std::uniform_int_distribution<std::int64_t> component(1, 9);
    FlatSide side;
    side.grid.dims = {40, 40, 40};
    for (auto& n : side.normal) n = component(random);
    side.offset = (side.normal[0] + side.normal[1] + side.normal[2]) * 20;
    const MedialAxis kept = pruned(core_by_detail(testing_shapes::from_predicate(
                                       side.grid, [&](int x, int y, int z) { return side.contains(x, y, z); })),
                                   auto_detail(side.grid), kDetail);
    for (std::size_t f = 0; f < kept.complex.face_count(); ++f) {
      const auto on_side = [&](const LatticePoint& p) {  // away from the walls of the box
        return std::ranges::all_of(p, [](std::int32_t x) { return x > 0 && x < 40; });
      };
      const bool both = on_side(kept.sites[kept.face_sites[f][0]]) && on_side(kept.sites[kept.face_sites[f][1]]);
      ASSERT_FALSE(both) << "round " << round << " face " << f;
    }
  }
}

TEST(Detail, EveryBoundaryVertexIsNearTheBallsForEveryDetail) {
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const VoxelShape shape = with_spacing(testing_shapes::random_shape(seed, 7), spacings()[seed % spacings().size()]);
    const MedialAxis axis = core_by_detail(shape);
    const Topology topology_of_shape = topology(shape);
    const double automatic = auto_detail(shape.grid());
    for (const double factor : {0.0, 0.5, 1.0, 1.3, 2.0, 3.5, 8.0, kInfinity}) {
      const double detail = factor == 0 ? 0 : factor * automatic;
      const MedialAxis kept = pruned(axis, detail, kDetail);
      ASSERT_EQ(topology(kept.complex), topology_of_shape) << seed;
      const double found = brute_coverage(shape, kept);
      ASSERT_LE(found, 2 * std::max(detail, automatic) * (1 + 1e-9)) << "seed " << seed << " factor " << factor;
      ASSERT_NEAR(coverage(shape, kept), found, 1e-9 * automatic) << seed;
    }
  }
}

TEST(Detail, DoesNotDependOnThreads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 12);
    tbb::task_arena one(1), four(4);
    const MedialAxis a = one.execute([&] { return core_by_detail(shape); });
    const MedialAxis b = four.execute([&] { return core_by_detail(shape); });
    ASSERT_EQ(a.measure(kDetail).value, b.measure(kDetail).value) << seed;
    ASSERT_EQ(a.measure(kDetail).level, b.measure(kDetail).level) << seed;
  }
}

TEST(Detail, ValuesDoNotDependOnPlaceOrPadding) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9);
    Grid grid = shape.grid();
    for (auto& n : grid.dims) n += 11;
    grid.origin = Vec3(-3, -4, -5);  // voxel (3, 4, 5) lies where voxel 0 was
    const VoxelShape moved =
        testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return shape.contains(x - 3, y - 4, z - 5); });
    const MedialAxis a = core_by_detail(shape), b = core_by_detail(moved);
    ASSERT_EQ(a.measure(kDetail).value, b.measure(kDetail).value) << seed;
  }
}

// Area of the faces whose corners lie in a box.
double area_within(const MedialAxis& axis, const Vec3& low, const Vec3& high) {
  double area = 0;
  for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
    const auto corners = axis.complex.corners(f);
    const auto in_box = [&](std::uint32_t v) {
      return (axis.points[v].array() >= low.array()).all() && (axis.points[v].array() <= high.array()).all();
    };
    if (!std::ranges::all_of(corners, in_box)) continue;
    for (std::size_t i = 2; i < corners.size(); ++i)
      area += 0.5 * (axis.points[corners[i - 1]] - axis.points[corners[0]])
                        .cross(axis.points[corners[i]] - axis.points[corners[0]])
                        .norm();
  }
  return area;
}

// Plates of one voxel and more, alone and standing on a block, are sheets.
TEST(Detail, ThinPlatesStaySheets) {
  for (const int thickness : {1, 2, 3, 4, 5})
    for (const bool on_block : {false, true}) {
      Grid grid;
      grid.dims = {40, 40, 40};
      const VoxelShape shape = testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
        const bool plate = x >= 4 && x < 34 && z >= 12 && z < 36 && y >= 18 && y < 18 + thickness;
        const bool block = x >= 4 && x < 34 && y >= 4 && y < 34 && z >= 4 && z < 12;
        return plate || (on_block && block);
      });
      const MedialAxis kept = pruned(core_by_detail(shape), auto_detail(grid), kDetail);
      const double middle = 18 + 0.5 * thickness - 0.5;  // voxel centres are at whole numbers
      const double area =
          area_within(kept, {3, middle - 0.4 - 0.25 * thickness, 16}, {35, middle + 0.4 + 0.25 * thickness, 36});
      EXPECT_GT(area, 0.8 * (30 - thickness) * (20 - 0.5 * thickness)) << thickness << (on_block ? " on a block" : "");
    }
}

TEST(Detail, NeedlesAndSingleVoxelsStay) {
  for (const int thickness : {1, 2, 3}) {
    Grid grid;
    grid.dims = {60, 24, 24};
    const VoxelShape shape = testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
      const bool needle = x >= 20 && x < 55 && y >= 10 && y < 10 + thickness && z >= 10 && z < 10 + thickness;
      const bool block = x >= 2 && x < 20 && y >= 2 && y < 20 && z >= 2 && z < 20;
      return needle || block || (x == 57 && y == 3 && z == 3);
    });
    const MedialAxis kept = pruned(core_by_detail(shape), auto_detail(grid), kDetail);
    double farthest = 0;
    for (const Vec3& p : kept.points)
      if (p[1] < 16) farthest = std::max(farthest, p[0] < 56 ? p[0] : 0);
    EXPECT_GT(farthest, 52.0) << thickness;
    EXPECT_TRUE(std::ranges::any_of(kept.points, [](const Vec3& p) { return p == Vec3(57, 3, 3); }));
  }
}

TEST(Detail, NeedsLambda) {
  MedialAxis axis;
  EXPECT_THROW(add_detail(axis), Error);
  EXPECT_EQ(coverage(VoxelShape(), axis), kInfinity);
}

}  // namespace detail_test
}  // namespace quench
