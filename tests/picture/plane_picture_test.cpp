// SPDX-License-Identifier: Apache-2.0
// Pictures of shapes of the plane: figures whose pixels are known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "picture/camera.h"
#include "picture/style.h"
#include "quench/picture.h"
#include "random_shapes.h"

using namespace quench;

namespace plane_picture_test {

constexpr int kSide = 200;

Vec3 at(const Picture& picture, int x, int y) {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x));
  return Vec3(picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]) / 255;
}

Vec3 mixed(const Vec3& a, std::uint32_t b, double share) { return a + (picture::rgb(b).cast<double>() - a) * share; }
Vec3 fill() { return mixed(Vec3::Ones(), picture::kLight.tint, picture::kPlaneFill); }

VoxelShape pixels(int width, int height, const std::function<bool(int, int)>& inside) {
  Grid grid;
  grid.dims = {width, height, 1};
  grid.make_plane();
  return testing_shapes::from_predicate(grid, [&](int x, int y, int) { return inside(x, y); });
}

/// A page of a shape in a box of side 10 around (4.5, 4.5), seen from a distance that shows 10 units in `kSide` pixels.
Page page_of(const VoxelShape& shape, bool y_down) {
  Page page;
  page.plane = true;
  page.y_down = y_down;
  page.side = 10;
  add_surface(page, shape, 1'000'000);
  page.low = {-0.5, -0.5, 0};
  page.high = {9.5, 9.5, 0};
  const double distance = 5 / std::tan(picture::kField / 2 * std::numbers::pi / 180);
  page.state = "camera=4.5,4.5," + std::to_string(distance) + ",4.5,4.5,0,0,1,0";
  return page;
}

/// One branch along `points`, its colours by `values`.
void add_line(Page& page, const std::vector<Vec3>& points, const std::vector<float>& values) {
  std::vector<float> places;
  std::vector<std::uint32_t> along;
  for (const Vec3& p : points) {
    along.push_back(static_cast<std::uint32_t>(along.size()));
    for (int i = 0; i < 3; ++i) places.push_back(static_cast<float>(p[i]));
  }
  page.arrays.push_back({"skeleton/points", 3, places});
  page.arrays.push_back({"skeleton/point/radius", 1, values});
  page.arrays.push_back(
      {"skeleton/branch_offsets", 1, std::vector<std::uint32_t>{0, static_cast<std::uint32_t>(along.size())}});
  page.arrays.push_back({"skeleton/branch_points", 1, along});
}

Picture drawn(const Page& page) { return draw_page(page, {kSide, kSide, false, false}); }

TEST(PlanePicture, TheFigureStandsAsTheAxisOfYSays) {
  // Pixel (1, 2) of 10 x 10, 20 pixels of the picture each.
  const VoxelShape shape = pixels(10, 10, [](int x, int y) { return x == 1 && y == 2; });
  for (const bool y_down : {true, false}) {
    const Picture picture = drawn(page_of(shape, y_down));
    const int row = y_down ? 50 : 200 - 50;
    EXPECT_LT((at(picture, 30, row) - fill()).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_EQ(at(picture, 30, 200 - row), Vec3::Ones());
    EXPECT_EQ(at(picture, 15, row), Vec3::Ones());
    EXPECT_EQ(at(picture, 45, row), Vec3::Ones());
    // The outline, on both sides of the edge of the pixel.
    for (const int x : {19, 20, 39, 40}) EXPECT_GT((Vec3::Ones() - at(picture, x, row)).minCoeff(), 0.1) << x;
  }
}

TEST(PlanePicture, ShapesCoverTheirShareOfPixels) {
  // Turned and shifted, so that no side is along a row; without an outline: dark pixels are area.
  for (int seed = 1; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    VoxelShape any = testing_shapes::random_shape(static_cast<std::uint64_t>(seed), 8);
    VoxelShape flat = pixels(8, 8, [&](int x, int y) { return any.contains(x, y, 1); });
    if (flat.empty()) continue;
    Page page = page_of(flat, seed % 2 == 0);
    auto& places =
        std::get<std::vector<float>>(std::find_if(page.arrays.begin(), page.arrays.end(), [](const PageArray& a) {
                                       return a.name == "shape/points";
                                     })->values);
    for (std::size_t i = 0; i < places.size(); i += 3) {
      const double x = places[i] - 3.5, y = places[i + 1] - 3.5, turn = 0.1 * seed;
      places[i] = static_cast<float>(4.63 + 0.8 * (std::cos(turn) * x - std::sin(turn) * y));
      places[i + 1] = static_cast<float>(4.21 + 0.8 * (std::sin(turn) * x + std::cos(turn) * y));
    }
    const Picture picture = drawn(page);
    // Inside, away from outlines, is the colour of the fill, outside white: count those.
    double whole = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const Vec3 colour = at(picture, x, y);
        if ((colour - fill()).cwiseAbs().maxCoeff() < 0.01)
          ++whole;
        else if (colour != Vec3::Ones())
          whole += 0.5;  // the outline lies half inside
      }
    const double area = 0.64 * 400 * static_cast<double>(flat.voxel_count());
    EXPECT_NEAR(whole, area, 0.06 * area);
  }
}

TEST(PlanePicture, LinesLieOverTheFigureAndKeepTheirWidth) {
  const VoxelShape shape = pixels(10, 10, [](int, int y) { return y > 1 && y < 8; });
  Page page = page_of(shape, true);
  // In many pieces: joints are not heavier than the line.
  std::vector<Vec3> points;
  for (int i = 0; i <= 60; ++i) points.emplace_back(1 + 0.1 * i, 3 + 0.03 * i, 0);
  add_line(page, points, std::vector<float>(points.size(), 1));
  const Picture picture = draw_page(page, {1600, 1000, false, false});
  Page one = page_of(shape, true);
  add_line(one, {points.front(), points.back()}, {1, 1});
  const Picture whole = draw_page(one, {1600, 1000, false, false});
  int different = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    different = std::max(different, std::abs(picture.pixels[i] - whole.pixels[i]));
  EXPECT_LE(different, 3);
  // Across the middle of the line: its width is 3 pixels, of colours between fill and map.
  const Vec3 colour = picture::colour_at(0).cast<double>();
  double across = 0;
  const int x = 800 + static_cast<int>(std::lround((4 - 4.5) * 100));
  for (int y = 300; y < 600; ++y)
    if (const double share = (at(picture, x, y) - fill()).norm() / (colour - fill()).norm(); share > 0.01)
      across += share;  // less is rounding
  EXPECT_NEAR(across, picture::kPlaneCurveWidth * std::sqrt(1 + 0.3 * 0.3), 0.1);
}

TEST(PlanePicture, ColoursRunAlongALineAndInfinityHasItsOwn) {
  Page page = page_of(pixels(10, 10, [](int, int) { return false; }), false);
  page.arrays.clear();
  add_line(page, {{0.5, 4.5, 0}, {8.5, 4.5, 0}, {9.4, 4.5, 0}}, {0, 1, std::numeric_limits<float>::infinity()});
  const Picture picture = drawn(page);
  // A line of 1.5 pixels covers three quarters of two rows.
  for (const double share : {0.25, 0.5, 0.75}) {
    const Vec3 wanted = (picture::colour_at(share).cast<double>() * 3 + Vec3::Ones()) / 4;
    for (const int row : {99, 100})
      EXPECT_LT((at(picture, static_cast<int>(20 + 160 * share), row) - wanted).cwiseAbs().maxCoeff(), 0.02);
  }
  EXPECT_GT(at(picture, 190, 99)[0], at(picture, 190, 99)[1]);  // pink
}

TEST(PlanePicture, ThreadsChangeNothing) {
  const VoxelShape shape = pixels(60, 50, [](int x, int y) { return (x * x + y * y) % 7 < 4; });
  Page page = page_of(shape, true);
  page.state.clear();
  page.side = 60;
  Context one, four;
  one.threads = 1;
  four.threads = 4;
  const PictureOptions options{300, 170, true, true};
  EXPECT_EQ(draw_page(page, options, &one).pixels, draw_page(page, options, &four).pixels);
}

}  // namespace plane_picture_test
