// SPDX-License-Identifier: Apache-2.0
// Holes of the plane and cavities of space, and those that are filled, against a flood fill of the test's own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "plane_shapes.h"
#include "quench/shape.h"

namespace quench {
namespace holes_test {

using Pixel = std::array<std::int64_t, 2>;

// The pixels of each hole: background that is connected by sides and corners and does not reach outside.
std::vector<std::set<Pixel>> holes_of(const VoxelShape& shape) {
  const std::int64_t width = shape.grid().dims[0], height = shape.grid().dims[1];
  std::set<Pixel> seen;
  std::vector<std::set<Pixel>> holes;
  for (std::int64_t y = -1; y <= height; ++y)
    for (std::int64_t x = -1; x <= width; ++x) {
      if (shape.contains(x, y, 0) || seen.count({x, y})) continue;
      std::set<Pixel> part;
      std::vector<Pixel> todo{{x, y}};
      while (!todo.empty()) {
        const Pixel p = todo.back();
        todo.pop_back();
        if (p[0] < -1 || p[1] < -1 || p[0] > width || p[1] > height || shape.contains(p[0], p[1], 0)) continue;
        if (!part.insert(p).second) continue;
        for (const std::int64_t dy : {-1, 0, 1})
          for (const std::int64_t dx : {-1, 0, 1}) todo.push_back({p[0] + dx, p[1] + dy});
      }
      seen.insert(part.begin(), part.end());
      if (!part.count({-1, -1})) holes.push_back(std::move(part));
    }
  return holes;
}

TEST(Holes, AreThoseOfAFloodFillAndSmallOnesAreFilled) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    const VoxelShape shape = testing_planes::random_plane_shape(seed, 14);
    const std::vector<std::set<Pixel>> holes = holes_of(shape);
    std::vector<std::int64_t> sizes;
    for (const auto& hole : holes) sizes.push_back(static_cast<std::int64_t>(hole.size()));
    std::ranges::sort(sizes, std::greater());
    ASSERT_EQ(cavity_sizes(shape), sizes) << "seed " << seed;
    for (const std::int64_t least : {2, 4}) {
      ForegroundOptions options;
      options.min_cavity = least;
      ForegroundReport report;
      const VoxelShape filled = clean(shape, options, &report);
      std::int64_t pixels = 0;
      for (const auto& hole : holes) {
        const bool fills = static_cast<std::int64_t>(hole.size()) < least;
        pixels += fills ? static_cast<std::int64_t>(hole.size()) : 0;
        found += fills;
        for (const Pixel& p : hole) ASSERT_EQ(filled.contains(p[0], p[1], 0), fills) << "seed " << seed;
      }
      EXPECT_EQ(report.voxels_filled, pixels) << "seed " << seed;
      EXPECT_EQ(filled.voxel_count(), shape.voxel_count() + pixels) << "seed " << seed;
    }
  }
  EXPECT_GT(found, 500u);  // the shapes do have small holes
}

TEST(Holes, CavitiesOfSpaceToo) {
  Grid grid;
  grid.dims = {9, 5, 5};
  VoxelShape shape(grid);
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 5; ++y) {
      std::vector<quench::Run> runs{{0, 9}};
      if (y == 2 && z == 2) runs = {{0, 2}, {3, 5}, {7, 9}};  // a cavity of one voxel, and one of two
      shape.append_row(runs);
    }
  EXPECT_EQ(cavity_sizes(shape), (std::vector<std::int64_t>{2, 1}));
  ForegroundOptions options;
  options.min_cavity = 2;
  EXPECT_EQ(cavity_sizes(clean(shape, options)), (std::vector<std::int64_t>{2}));
}

}  // namespace holes_test
}  // namespace quench
