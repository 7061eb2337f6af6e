// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "quench/axis.h"
#include "quench/error.h"
#include "quench/shape.h"

namespace quench {
namespace image_test {

// Samples of a small image of different sides, few values, in runs.
struct Picture {
  std::array<std::int64_t, 3> dims;
  std::vector<std::int16_t> values;  // x fastest

  explicit Picture(unsigned seed, std::array<std::int64_t, 3> d) : dims(d) {
    std::mt19937 random(seed);
    std::int16_t value = 0;
    for (std::int64_t i = 0; i < dims[0] * dims[1] * dims[2]; ++i) {
      if (random() % 3 == 0) value = static_cast<std::int16_t>(static_cast<int>(random() % 5) - 1);
      values.push_back(value);
    }
  }
  std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z));
  }
};

// A copy in another order of axes (`axes[2]` closest), with gaps, and backwards along the axes of `backwards`.
struct Laid {
  std::vector<std::int16_t> memory;
  ImageView view;

  Laid(const Picture& picture, std::array<std::size_t, 3> axes, std::array<bool, 3> backwards, std::int64_t gap) {
    std::int64_t step = gap;
    for (std::size_t i = 3; i-- > 0;) {
      view.strides[axes[i]] = step;
      step *= picture.dims[axes[i]];
    }
    memory.assign(static_cast<std::size_t>(step), 7);
    std::int64_t first = 0;
    for (std::size_t a = 0; a < 3; ++a)
      if (backwards[a]) {
        first += view.strides[a] * (picture.dims[a] - 1);
        view.strides[a] = -view.strides[a];
      }
    for (std::int64_t z = 0; z < picture.dims[2]; ++z)
      for (std::int64_t y = 0; y < picture.dims[1]; ++y)
        for (std::int64_t x = 0; x < picture.dims[0]; ++x)
          memory[static_cast<std::size_t>(first + x * view.strides[0] + y * view.strides[1] + z * view.strides[2])] =
              picture.values[picture.at(x, y, z)];
    view.grid.dims = picture.dims;
    view.grid.spacing = {1, 2, 3};
    view.type = SampleType::int16;
    view.data = memory.data() + first;
    for (auto& stride : view.strides) stride *= 2;
  }
};

std::vector<Laid> layouts(const Picture& picture) {
  std::vector<Laid> all;
  std::array<std::size_t, 3> axes{0, 1, 2};
  unsigned flips = 0;
  do {
    all.emplace_back(picture, axes, std::array<bool, 3>{(flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0},
                     flips % 2 + 1);
    ++flips;
  } while (std::next_permutation(axes.begin(), axes.end()));
  return all;
}

TEST(Image, ForegroundDoesNotDependOnTheOrderInMemory) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Picture picture(seed, {13, 9, seed % 2 ? 70 : 6});
    for (const Laid& laid : layouts(picture)) {
      ForegroundOptions options;
      options.threshold = 2;
      const VoxelShape shape = foreground(laid.view, options);
      shape.validate();
      for (std::int64_t z = 0; z < picture.dims[2]; ++z)
        for (std::int64_t y = 0; y < picture.dims[1]; ++y)
          for (std::int64_t x = 0; x < picture.dims[0]; ++x)
            ASSERT_EQ(shape.contains(x, y, z), picture.values[picture.at(x, y, z)] >= 2);
    }
  }
}

TEST(Image, EveryLabelIsWhatForegroundGives) {
  const Picture picture(5, {11, 8, 67});
  std::map<std::int64_t, std::int64_t> count;
  for (const auto v : picture.values) ++count[v];
  for (const Laid& laid : layouts(picture)) {
    const std::vector<LabelRuns> found = label_runs(laid.view);
    ASSERT_EQ(found.size(), count.size() - count.contains(0));
    for (const LabelRuns& runs : found) {
      EXPECT_NE(runs.label, 0);
      const VoxelShape shape = runs.shape(laid.view.grid);
      shape.validate();
      EXPECT_EQ(shape.voxel_count(), count[runs.label]);
      const auto box = shape.foreground_box();
      EXPECT_EQ(box.begin, (std::array<std::int64_t, 3>{0, 0, 0}));
      EXPECT_EQ(box.end, shape.grid().dims);
      ForegroundOptions options;
      options.label = runs.label;
      const VoxelShape whole = foreground(laid.view, options);
      const Vec3 shift = laid.view.grid.lattice(shape.grid().origin) - Vec3::Constant(0.5);
      for (std::int64_t z = 0; z < shape.grid().dims[2]; ++z)
        for (std::int64_t y = 0; y < shape.grid().dims[1]; ++y)
          for (const quench::Run& r : shape.row(y, z))
            for (std::int64_t x = r.begin; x < r.end; ++x)
              ASSERT_TRUE(
                  whole.contains(x + std::llround(shift[0]), y + std::llround(shift[1]), z + std::llround(shift[2])));
    }
  }
  const auto zero = label_runs(layouts(picture)[0].view, [](std::int64_t label) { return label == 0; });
  ASSERT_EQ(zero.size(), 1u);
  EXPECT_EQ(zero[0].label, 0);
}

TEST(Image, LabelsAreIntegers) {
  const std::vector<float> samples(8, 1);
  ImageView view;
  view.grid.dims = {2, 2, 2};
  view.type = SampleType::float32;
  view.data = samples.data();
  view.strides = {4, 8, 16};
  EXPECT_THROW(label_runs(view), Error);
  const std::vector<std::uint64_t> large(8, ~std::uint64_t{0});
  view.type = SampleType::uint64;
  view.data = large.data();
  view.strides = {8, 16, 32};
  EXPECT_THROW(label_runs(view), Error);
}

TEST(Raster, BallsAsOneByOneAndClippedByTheMask) {
  Grid grid;
  grid.spacing = {1, 0.5, 2};
  grid.origin = {10, 20, 30};
  grid.direction << 0, 1, 0, 1, 0, 0, 0, 0, -1;  // a reflection and a turn
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-3, 12);
  std::vector<Vec3> centres;
  std::vector<double> radius;
  for (int i = 0; i < 12; ++i) {
    centres.push_back(grid.world({place(random), place(random), place(random)}));
    radius.push_back(place(random) / 8 + 0.4);
  }
  const std::array<std::int64_t, 3> dims{9, 11, 5};
  for (const std::array<std::int64_t, 3>& strides :
       {std::array<std::int64_t, 3>{1, 9, 99}, {55, 5, 1}, {2 * 55, 2 * 5, 2}}) {
    std::vector<std::uint8_t> memory(2 * 9 * 11 * 5, 0);
    mark_balls(centres, radius, grid, {dims, strides, memory.data()});
    for (std::int64_t x = 0; x < 9; ++x)
      for (std::int64_t y = 0; y < 11; ++y)
        for (std::int64_t z = 0; z < 5; ++z) {
          const Vec3 p = grid.world(Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) +
                                    Vec3::Constant(0.5));
          bool inside = false;
          for (std::size_t b = 0; b < centres.size(); ++b) inside |= (p - centres[b]).norm() <= radius[b];
          ASSERT_EQ(memory[static_cast<std::size_t>(x * strides[0] + y * strides[1] + z * strides[2])] != 0, inside);
        }
  }
}

TEST(Raster, ATriangleIsWithoutGaps) {
  const std::vector<std::array<std::uint32_t, 2>> none;
  const CellComplex complex = make_complex(4, none, {0, 3}, {0, 1, 2});
  const std::vector<Vec3> points{{0, 0, 0}, {8, 1, 2}, {1, 7, 5}, {-5, 0, 0}};  // the last is outside the mask
  const std::array<std::int64_t, 3> dims{9, 9, 9};
  std::vector<std::uint8_t> memory(729, 0);
  mark_cells(complex, points, Grid(), {dims, {1, 9, 81}, memory.data()});
  // Every point of the triangle is in a marked voxel or beside one, and marked voxels touch it.
  for (double s = 0; s <= 1; s += 0.01)
    for (double t = 0; s + t <= 1; t += 0.01) {
      const Vec3 p = points[0] + s * (points[1] - points[0]) + t * (points[2] - points[0]);
      bool near = false;
      for (int dx = -1; dx <= 1; ++dx)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dz = -1; dz <= 1; ++dz) {
            const auto x = std::lround(p[0]) + dx, y = std::lround(p[1]) + dy, z = std::lround(p[2]) + dz;
            if (x >= 0 && y >= 0 && z >= 0 && x < 9 && y < 9 && z < 9)
              near |= memory[static_cast<std::size_t>(x + 9 * y + 81 * z)] != 0 &&
                      (p - Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z))).norm() < 1.01;
          }
      ASSERT_TRUE(near);
    }
  EXPECT_EQ(memory[0], 1);
  EXPECT_GT(std::count(memory.begin(), memory.end(), 1), 20);
  EXPECT_LT(std::count(memory.begin(), memory.end(), 1), 120);
}

}  // namespace image_test
}  // namespace quench
