// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "plane_shapes.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace specks_test {

using Voxel = std::array<std::int64_t, 3>;

// The component of every voxel, by flood fill over neighbours that differ in at most so many coordinates.
std::map<Voxel, int> components_of(const VoxelShape& shape, int differing) {
  const auto& dims = shape.grid().dims;
  std::map<Voxel, int> component;
  int count = 0;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        std::vector<Voxel> todo{{x, y, z}};
        const int here = count;
        while (!todo.empty()) {
          const Voxel p = todo.back();
          todo.pop_back();
          if (!shape.contains(p[0], p[1], p[2]) || !component.emplace(p, here).second) continue;
          count = here + 1;
          for (const std::int64_t dz : {-1, 0, 1})
            for (const std::int64_t dy : {-1, 0, 1})
              for (const std::int64_t dx : {-1, 0, 1})
                if (std::abs(dx) + std::abs(dy) + std::abs(dz) <= differing)
                  todo.push_back({p[0] + dx, p[1] + dy, p[2] + dz});
        }
      }
  return component;
}

void expect_specks(const VoxelShape& shape, std::int64_t below, std::uint64_t seed) {
  const std::map<Voxel, int> component = components_of(shape, 1), around = components_of(shape, 3);
  std::map<int, std::int64_t> size;
  std::map<int, std::map<int, int>> parts;  // of those around
  for (const auto& [voxel, c] : component) {
    ++size[c];
    ++parts[around.at(voxel)][c];
  }
  Specks expected;
  for (const auto& [whole, of] : parts)
    for (const auto& [c, voxels] : of)
      if (size[c] < below) {
        ++expected.count;
        expected.voxels += voxels;
        expected.touching += of.size() > 1;
      }
  const Specks found = specks_of(shape, below);
  ASSERT_EQ(found.count, expected.count) << seed;
  ASSERT_EQ(found.voxels, expected.voxels) << seed;
  ASSERT_EQ(found.touching, expected.touching) << seed;
}

TEST(Specks, AreThoseOfAFloodFill) {
  for (std::uint64_t seed = 0; seed < 500 && !HasFatalFailure(); ++seed) {
    const auto below = static_cast<std::int64_t>(1 + seed % 7);
    expect_specks(testing_shapes::random_shape(seed, 8), below, seed);
    expect_specks(testing_planes::random_plane_shape(seed, 14), below, seed);
  }
}

TEST(Specks, OfNothing) {
  Grid grid;
  grid.dims = {3, 3, 3};
  EXPECT_EQ(specks_of(testing_shapes::from_predicate(grid, [](int, int, int) { return false; }), 30).count, 0);
}

}  // namespace specks_test
}  // namespace quench
