// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace voxel_topology_test {

// Everything below works on a dense array with two empty voxels around the shape.
struct Dense {
  int n[3];
  std::vector<char> voxels;

  explicit Dense(const VoxelShape& shape) {
    for (int a = 0; a < 3; ++a) n[a] = static_cast<int>(shape.grid().dims[static_cast<std::size_t>(a)]) + 4;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) voxels.push_back(shape.contains(x - 2, y - 2, z - 2));
  }
  std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>(x + n[0] * (y + n[1] * z)); }
  bool full(int x, int y, int z, int sx, int sy, int sz) const {
    for (int c = 0; c < 8; ++c)
      if (!voxels[index(x + (c & sx), y + (c >> 1 & sy), z + (c >> 2 & sz))]) return false;
    return true;
  }
  std::int64_t euler() const {
    std::int64_t sum = 0;
    for (int z = 0; z + 1 < n[2]; ++z)
      for (int y = 0; y + 1 < n[1]; ++y)
        for (int x = 0; x + 1 < n[0]; ++x)
          for (int s = 0; s < 8; ++s) {
            const int sx = s & 1, sy = s >> 1 & 1, sz = s >> 2;
            if (full(x, y, z, sx, sy, sz)) sum += (sx + sy + sz) % 2 ? -1 : 1;
          }
    return sum;
  }
  std::int64_t components(bool foreground) const {
    std::vector<char> todo = voxels;
    if (!foreground)
      for (char& v : todo) v = !v;
    std::int64_t count = 0;
    std::vector<std::array<int, 3>> stack;
    const auto take = [&](int x, int y, int z) {
      if (x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2] || !todo[index(x, y, z)]) return;
      todo[index(x, y, z)] = 0;
      stack.push_back({x, y, z});
    };
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          if (!todo[index(x, y, z)]) continue;
          ++count;
          take(x, y, z);
          while (!stack.empty()) {
            const auto p = stack.back();
            stack.pop_back();
            for (int dz = -1; dz <= 1; ++dz)
              for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                  if (!foreground || dx * dx + dy * dy + dz * dz == 1) take(p[0] + dx, p[1] + dy, p[2] + dz);
          }
        }
    return count;
  }
};

Topology by_definition(const VoxelShape& shape) {
  const Dense dense(shape);
  Topology t;
  t.euler = dense.euler();
  t.betti[0] = dense.components(true);
  t.betti[2] = dense.components(false) - 1;
  t.betti[1] = t.betti[0] + t.betti[2] - t.euler;
  return t;
}

void expect_equal(const Topology& a, const Topology& b, std::uint64_t seed) {
  ASSERT_EQ(a.euler, b.euler) << "seed " << seed;
  ASSERT_EQ(a.betti, b.betti) << "seed " << seed;
}

TEST(VoxelTopology, EqualsTheDefinitionOnRandomShapes) {
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, seed % 10 == 0 ? 20 : 9);
    const Topology t = topology(shape);
    expect_equal(t, by_definition(shape), seed);
    ASSERT_GE(t.betti[1], 0) << "seed " << seed;
  }
}

TEST(VoxelTopology, EqualsTheDefinitionOnNoiseOfEveryDensity) {
  std::mt19937_64 random(5);
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Grid grid;
    for (auto& d : grid.dims) d = 1 + static_cast<std::int64_t>(random() % 9);
    const std::uint64_t density = random() % 101;
    const VoxelShape shape =
        testing_shapes::from_predicate(grid, [&](int, int, int) { return random() % 100 < density; });
    expect_equal(topology(shape), by_definition(shape), seed);
  }
}

Topology known(std::int64_t b0, std::int64_t b1, std::int64_t b2) { return {b0 - b1 + b2, {b0, b1, b2}}; }

VoxelShape cube(int n, const std::function<bool(int, int, int)>& inside) {
  Grid grid;
  grid.dims = {n, n, n};
  return testing_shapes::from_predicate(grid, inside);
}

TEST(VoxelTopology, KnownShapes) {
  EXPECT_EQ(topology(VoxelShape()), known(0, 0, 0));
  EXPECT_EQ(topology(cube(3, [](int, int, int) { return false; })), known(0, 0, 0));
  EXPECT_EQ(topology(testing_shapes::box_shape(1, 1, 1, 0)), known(1, 0, 0));
  EXPECT_EQ(topology(testing_shapes::box_shape(4, 5, 6, 0)), known(1, 0, 0));
  const auto hole = [](int a, int b) { return a == 1 && b == 1; };
  for (int axis = 0; axis < 3; ++axis)  // a ring around each axis
    EXPECT_EQ(topology(cube(3, [&](int x, int y,
                                   int z) { return axis == 0   ? !hole(y, z)
                                                   : axis == 1 ? !hole(x, z)
                                                               : !hole(x, y); })),
              known(1, 1, 0));
  EXPECT_EQ(topology(cube(5, [](int x, int y, int z) { return x != 2 || y != 2 || z != 2; })), known(1, 0, 1));
  EXPECT_EQ(topology(cube(5, [&](int x, int y, int z) { return !(z == 2 && x > 0 && x < 4 && y > 0 && y < 4); })),
            known(1, 0, 1));
  // A cavity in the form of a ring makes a loop: b1 = 1 as well as b2 = 1.
  EXPECT_EQ(
      topology(cube(
          5, [&](int x, int y, int z) { return !(z == 2 && x > 0 && x < 4 && y > 0 && y < 4 && (x != 2 || y != 2)); })),
      known(1, 1, 1));
  // The frame of a cube: 12 edges, 8 corners: b1 = 5.
  EXPECT_EQ(topology(cube(5, [](int x, int y, int z) { return (x % 4 == 0) + (y % 4 == 0) + (z % 4 == 0) >= 2; })),
            known(1, 5, 0));
}

TEST(VoxelTopology, VoxelsThatTouchInAnEdgeOrACornerAreApartAndTheirBackgroundIsConnected) {
  EXPECT_EQ(topology(cube(2, [](int x, int y, int z) { return x == y && z == 0; })), known(2, 0, 0));
  EXPECT_EQ(topology(cube(2, [](int x, int y, int z) { return x == y && x == z; })), known(2, 0, 0));
  // Checkerboard: 14 voxels of 27, none adjacent; the background is one piece.
  EXPECT_EQ(topology(cube(3, [](int x, int y, int z) { return (x + y + z) % 2 == 0; })), known(14, 0, 0));
  // Two cavities that touch in a corner are one.
  EXPECT_EQ(topology(cube(4, [](int x, int y, int z) { return !(x == y && y == z && (x == 1 || x == 2)); })),
            known(1, 0, 1));
}

TEST(VoxelTopology, PaddingAndMirrorsChangeNothing) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 12);
    Grid grid;
    const auto& d = shape.grid().dims;
    grid.dims = {d[1] + 3, d[2] + 2, d[0] + 1};
    const VoxelShape turned = testing_shapes::from_predicate(
        grid, [&](int x, int y, int z) { return shape.contains(d[0] - z, x - 1, d[2] - y); });
    EXPECT_EQ(topology(shape), topology(turned)) << "seed " << seed;
  }
}

TEST(VoxelTopology, EmptyScanlinesOfALargeGridAreCheap) {
  Grid grid;
  grid.dims = {2000, 2000, 2000};
  VoxelShape shape(grid);
  const std::vector<quench::Run> one{{3, 5}, {7, 9}};
  for (std::int64_t r = 0; r < grid.dims[1] * grid.dims[2]; ++r)
    shape.append_row(r == 3'000'000 ? std::span<const quench::Run>(one) : std::span<const quench::Run>());
  EXPECT_EQ(topology(shape), known(2, 0, 0));
}

}  // namespace voxel_topology_test
}  // namespace quench
