// SPDX-License-Identifier: Apache-2.0
// Pictures of small pages whose pixels are known.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "picture/caption.h"
#include "picture/frame.h"
#include "picture/scene.h"
#include "picture/tile.h"
#include "quench/picture.h"
#include "temporary_folder.h"

using namespace quench;

namespace page_picture_test {

using Colour = std::array<int, 3>;
constexpr Colour kWhite{255, 255, 255};

Colour at(const Picture& picture, int x, int y) {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x));
  return {picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]};
}

/// A page of triangles with a value per vertex, seen along -z from a distance of 3.
struct TrianglePage {
  Page page;
  std::vector<float> points, values;
  std::vector<std::uint32_t> corners;

  TrianglePage() {
    page.side = 1;
    page.low = Vec3::Constant(-0.5);
    page.high = Vec3::Constant(0.5);
  }
  void add(const Vec3& a, const Vec3& b, const Vec3& c, double value) {
    for (const Vec3& p : {a, b, c}) {
      corners.push_back(static_cast<std::uint32_t>(values.size()));
      for (int i = 0; i < 3; ++i) points.push_back(static_cast<float>(p[i]));
      values.push_back(static_cast<float>(value));
    }
  }
  void add_square(double half, double z, double value) {
    add({-half, -half, z}, {half, -half, z}, {half, half, z}, value);
    add({-half, -half, z}, {half, half, z}, {-half, half, z}, value);
  }
  Page with_skeleton(const std::string& camera, const std::string& more = "") const {
    Page out = page;
    std::vector<std::uint32_t> offsets{0};
    while (offsets.back() < corners.size()) offsets.push_back(offsets.back() + 3);
    out.arrays.push_back({"skeleton/points", 3, points});
    out.arrays.push_back({"skeleton/polygon_offsets", 1, offsets});
    out.arrays.push_back({"skeleton/polygon_corners", 1, corners});
    out.arrays.push_back({"skeleton/point/radius", 1, values});
    out.state = "layer=skeleton&camera=" + camera + more;
    return out;
  }
  void add_as_shape(Page& out) const {
    out.arrays.push_back({"shape/points", 3, points});
    out.arrays.push_back({"shape/triangles", 3, corners});
  }
};

const std::string kFront = "0,0,3,0,0,0,0,1,0", kBack = "0,0,-3,0,0,0,0,1,0";

Picture drawn(const Page& page, int width = 200, int height = 200, bool caption = false) {
  return draw_page(page, {width, height, caption, false});
}

/// Pixels per scene unit at a distance from the eye, of a picture of that height.
double per_unit(int height, double distance) { return height / 2.0 / std::tan(15 * std::numbers::pi / 180) / distance; }

TEST(PagePicture, ATriangleCoversItsPixels) {
  TrianglePage triangle;
  triangle.add({-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0, 0.5, 0}, 1);
  const Picture picture = drawn(triangle.with_skeleton(kFront));
  const double unit = per_unit(200, 3);
  int wrong = 0, covered = 0;
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      const double px = (x + 0.5 - 100) / unit, py = (100 - y - 0.5) / unit;
      // Distance to the nearest side, positive inside.
      const double lower = py + 0.5, sides = (0.5 - py - 2 * std::abs(px)) / std::sqrt(5.0);
      const double inside = std::min(lower, sides) * unit;
      if (std::abs(inside) < 1.5) continue;
      covered += inside > 0;
      wrong += (at(picture, x, y) != kWhite) != (inside > 0);
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(covered, 6000);
}

TEST(PagePicture, WhatIsNearerHidesWhatIsBehind) {
  TrianglePage squares;
  squares.add_square(0.3, 0.2, 0);
  squares.add_square(0.3, -0.2, 1);
  const Colour front = at(drawn(squares.with_skeleton(kFront)), 100, 100);
  const Colour back = at(drawn(squares.with_skeleton(kBack)), 100, 100);
  EXPECT_GT(front[2], front[1]);  // the lower end of the colours is violet, the upper one yellow
  EXPECT_GT(back[1], 2 * back[2]);
}

TEST(PagePicture, PartsHaveColoursOfTheirOwn) {
  TrianglePage squares;
  squares.add_square(0.4, 0.1, 0);
  squares.add_square(0.2, 0.2, 0);
  Page page = squares.with_skeleton(kFront, "&color=sheet");
  page.arrays.push_back({"skeleton/polygon_sheet", 1, std::vector<std::uint32_t>{0, 0, 13, 13}});
  const Picture picture = drawn(page);
  const Colour outer = at(picture, 65, 100), inner = at(picture, 100, 100);
  EXPECT_GT(outer[2], outer[0]);        // blue, the first
  EXPECT_GT(inner[0], inner[2] + 100);  // orange, the second after twelve
}

TEST(PagePicture, GlassIsSeenThroughAndHidesNothing) {
  TrianglePage solid, before, behind;
  solid.add_square(0.2, 0, 1);
  before.add_square(0.4, 0.2, 0);
  behind.add_square(0.4, -0.2, 0);
  Page plain = solid.with_skeleton(kFront), tinted = plain, backed = plain;
  before.add_as_shape(tinted);
  behind.add_as_shape(backed);
  const Colour seen = at(drawn(plain), 90, 100), through = at(drawn(tinted), 90, 100);
  EXPECT_EQ(at(drawn(backed), 90, 100), seen);
  EXPECT_NE(through, seen);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(through[i], seen[i], 25);
  EXPECT_NE(at(drawn(backed), 60, 100), kWhite);  // beside what is solid
}

TEST(PagePicture, SharesOfCornersAreThoseInSpace) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 200; ++round) {
    std::array<Vec3, 3> corners;
    // The third corner is often behind the eye.
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = {unit(random), unit(random), i == 2 ? 2 * unit(random) : 1.5 + unit(random)};
    std::array<picture::Projected, 3> projected;
    for (std::size_t i = 0; i < 3; ++i)
      projected[i] = {300 * corners[i].x() + 200 * corners[i].z(), 300 * corners[i].y() + 100 * corners[i].z(),
                      corners[i].z()};
    const picture::TriangleSetup setup(projected[0], projected[1], projected[2]);
    const Vec3 shares(0.5 + 0.4 * unit(random), 0.05, 0);
    const Vec3 weights(shares[0], shares[1], 1 - shares[0] - shares[1]);
    const Vec3 place = weights[0] * projected[0] + weights[1] * projected[1] + weights[2] * projected[2];
    if (place.z() < 0.05 || std::abs(corners[0].dot(corners[1].cross(corners[2]))) < 1e-2) continue;
    const picture::Vec3f got = setup.weights(place.x() / place.z(), place.y() / place.z());
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], weights[i], 1e-4) << round;
    EXPECT_NEAR(setup.depth.dot(Vec3(place.x() / place.z(), place.y() / place.z(), 1)), 1 / place.z(),
                1e-6 / place.z());
  }
}

TEST(PagePicture, AFloorThatPassesTheEyeEndsAtTheHorizon) {
  TrianglePage floor;
  floor.add_square(50, 0, 1);
  for (std::size_t i = 0; i < floor.points.size(); i += 3) {
    std::swap(floor.points[i + 1], floor.points[i + 2]);
    floor.points[i + 1] = -0.2F;
  }
  const Picture picture = drawn(floor.with_skeleton("0,0,2,0,0,0,0,1,0"));
  EXPECT_EQ(at(picture, 100, 20), kWhite);
  EXPECT_NE(at(picture, 100, 190), kWhite);
  EXPECT_NE(at(picture, 10, 190), kWhite);
}

TEST(PagePicture, CurvesAreAsWideAsInThePage) {
  TrianglePage none;
  Page page = none.with_skeleton(kFront);
  page.arrays.clear();
  page.arrays.push_back({"skeleton/points", 3, std::vector<float>{-0.4F, 0, 0, 0.4F, 0, 0, 0, 0.3F, 0}});
  page.arrays.push_back({"skeleton/branch_offsets", 1, std::vector<std::uint32_t>{0, 2}});
  page.arrays.push_back({"skeleton/branch_points", 1, std::vector<std::uint32_t>{0, 1}});
  page.arrays.push_back({"skeleton/isolated", 1, std::vector<std::uint32_t>{2}});
  const Picture picture = drawn(page, 1600, 1000);
  const auto rows = [&](int x, int from, int to) {
    int count = 0;
    for (int y = from; y < to; ++y) count += at(picture, x, y) != kWhite;
    return count;
  };
  EXPECT_NEAR(rows(700, 450, 550), 5, 1);
  EXPECT_EQ(rows(300, 0, 1000), 0);
  const int above = 500 - static_cast<int>(std::lround(0.3 * per_unit(1000, 3)));
  EXPECT_NEAR(rows(800, above - 20, above + 20), 9, 1);
  const Colour curve = at(picture, 700, 500);
  EXPECT_GT(curve[0], 180);
  EXPECT_LT(curve[2], 120);
}

/// A cloud of triangles, with a shape around and curves.
Page crowd() {
  TrianglePage cloud, shape;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  const auto place = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  for (int i = 0; i < 800; ++i) {
    const Vec3 p = place();
    (i % 10 == 0 ? shape : cloud).add(p, p + 0.3 * place(), p + 0.3 * place(), p.x());
  }
  Page page = cloud.with_skeleton("1,1,3,0,0,0,0,1,0");
  shape.add_as_shape(page);
  std::vector<std::uint32_t> along;
  for (std::uint32_t v = 0; v < 200; ++v) along.push_back(7 * v);
  page.arrays.push_back({"skeleton/branch_offsets", 1, std::vector<std::uint32_t>{0, 200}});
  page.arrays.push_back({"skeleton/branch_points", 1, along});
  page.title = "crowd";
  return page;
}

TEST(PagePicture, ThreadsDoNotMatter) {
  const Page page = crowd();
  const TemporaryFolder folder;
  Picture first;
  std::string first_file;
  for (const int threads : {1, 2, 5}) {
    Context context;
    context.threads = threads;
    const Picture picture = draw_page(page, {700, 500, true, true}, &context);
    write_png(folder / "picture.png", picture, &context);
    std::ifstream in(folder / "picture.png", std::ios::binary);
    const std::string file{std::istreambuf_iterator<char>(in), {}};
    if (threads == 1) {
      first = picture;
      first_file = file;
    }
    EXPECT_EQ(picture.pixels, first.pixels);
    EXPECT_EQ(file, first_file);
  }
}

TEST(PagePicture, BandsDoNotMatter) {
  const Page page = crowd();
  const picture::ViewState state = picture::view_state(page);
  const picture::Scene scene = picture::scene_of(page, state);
  const picture::ColourRange range = picture::colour_range(scene, state);
  const picture::Camera camera = picture::first_look(page, state, scene, 150, 330, {});
  const auto in_bands = [&](int band) {
    return picture::draw_scene(scene, state, range, camera, 150, 330, 1.0, nullptr, band).pixels;
  };
  for (const int band : {17, 32, 100}) EXPECT_TRUE(in_bands(band) == in_bands(1000)) << band;
}

TEST(PagePicture, CancelStopsIt) {
  Context context;
  context.cancel();
  EXPECT_THROW(draw_page(crowd(), {}, &context), Error);
}

TEST(PagePicture, SizesFrom16To8192) {
  const Page page = crowd();
  for (const auto& [width, height] : {std::pair{16, 16}, {16, 8192}, {8192, 16}, {33, 97}, {240, 160}}) {
    const Picture picture = drawn(page, width, height, true);
    EXPECT_EQ(picture.pixels.size(), 3U * static_cast<unsigned>(width) * static_cast<unsigned>(height));
  }
  for (const auto& [width, height] : {std::pair{15, 16}, {16, 8193}, {0, 0}, {-100, 100}})
    EXPECT_THROW(drawn(page, width, height), Error);
}

TEST(PagePicture, AnEmptyPageIsTheGround) {
  Page page;
  EXPECT_EQ(drawn(page).pixels, std::vector<std::uint8_t>(200 * 200 * 3, 255));
  page.state = "dark=1";
  const Picture dark = drawn(page);
  EXPECT_NEAR(at(dark, 2, 2)[0], 0x1b, 1);
  EXPECT_NEAR(at(dark, 2, 197)[0], 0x0e, 1);
}

TEST(PagePicture, LayersAndArraysThatAreNotThereAreRefused) {
  TrianglePage triangle;
  triangle.add({-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0, 0.1, 0}, 1);
  EXPECT_THROW(drawn(triangle.with_skeleton(kFront, "&color=hue")), Error);
  Page page = triangle.with_skeleton(kFront);
  page.state = "layer=core";
  EXPECT_THROW(drawn(page), Error);
  page = triangle.with_skeleton(kFront);
  std::get<std::vector<std::uint32_t>>(page.arrays[2].values)[1] = 99;
  EXPECT_THROW(drawn(page), Error);
}

TEST(PagePicture, CaptionsSayWhatIsThere) {
  TrianglePage triangles;
  triangles.add({-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0, 0.1, 0}, 1);
  triangles.add({-0.1, -0.1, 0.1}, {0.1, -0.1, 0.1}, {0, 0.1, 0.1}, 2);
  Page page = triangles.with_skeleton(kFront);
  page.unit = "mm";
  page.theta2 = 0.03;
  page.theta1 = std::numeric_limits<double>::infinity();
  page.pruning = {"detail", 0.001234};
  page.files = {{"shape", "some where/a shape.off"}};
  EXPECT_EQ(caption_of(page), (std::vector<std::string>{"a shape.off", "θ₂ = 0.03 mm · θ₁ = ∞ · detail = 0.00123 mm"}));
  page.theta1 = 0.02;
  page.theta1_radii = 0.5;
  EXPECT_EQ(caption_of(page).back(), "θ₂ = 0.03 mm · θ₁ = 0.02 mm and 0.5 radii · detail = 0.00123 mm");
  const auto dark = [](const Picture& picture, int x0, int y0, int x1, int y1) {
    int count = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) count += at(picture, x, y)[0] < 128;
    return count;
  };
  const Picture with = draw_page(page, {1600, 1000, true, false}),
                without = draw_page(page, {1600, 1000, false, false});
  const Picture axes = draw_page(page, {1600, 1000, false, true});
  EXPECT_GT(dark(with, 20, 20, 400, 100), 500);  // the lines
  EXPECT_EQ(dark(without, 20, 20, 400, 100), 0);
  EXPECT_GT(dark(with, 1300, 900, 1600, 1000), 200);  // the scale bar
  EXPECT_GT(dark(with, 20, 880, 450, 1000), 1000);    // the colour bar
  EXPECT_EQ(dark(without, 1300, 900, 1600, 1000), 0);
  EXPECT_GT(dark(axes, 1400, 750, 1600, 1000), 100);
  Page core = page;
  core.arrays.push_back({"core/points", 3, std::vector<float>{0, 0, 0}});
  core.measures = {{"lambda", 0.5}};
  core.state = "layer=core&measure=lambda&threshold=0.25";
  EXPECT_EQ(caption_of(core).back(), "λ = 0.5 mm");
}

TEST(PagePicture, NumbersAreShort) {
  using picture::short_text;
  EXPECT_EQ(short_text(0.0312345), "0.0312");
  EXPECT_EQ(short_text(1234.7), "1235");
  EXPECT_EQ(short_text(12.0), "12");
  EXPECT_EQ(short_text(-0.5), "−0.5");
  EXPECT_EQ(short_text(0), "0");
  EXPECT_EQ(short_text(2.5e7), "2.50e+07");
  EXPECT_EQ(short_text(std::numeric_limits<double>::infinity()), "∞");
  EXPECT_EQ(picture::round_length(0.7), 0.5);
  EXPECT_EQ(picture::round_length(30), 20);
  EXPECT_EQ(picture::round_length(1), 1);
  EXPECT_EQ(picture::ticks(0, 1, 5), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(picture::names_of({0, 0.2, 0.4}), (std::vector<std::string>{"0", "0.2", "0.4"}));
  EXPECT_EQ(picture::names_of({0.049992, 0.049994}), (std::vector<std::string>{"0.049992", "0.049994"}));
  EXPECT_EQ(picture::names_of({0.0499925, 0.049995}), (std::vector<std::string>{"0.0499925", "0.049995"}));
}

TEST(PagePicture, ABarOnlyWhereSomethingHasItsColours) {
  Page page;
  page.side = 1;
  page.low = Vec3::Constant(-0.5);
  page.high = Vec3::Constant(0.5);
  page.theta2 = 0.03;
  const std::vector<float> points{-0.4F, 0, 0, 0, 0, 0, 0.4F, 0, 0}, values{1, 2, 3};
  page.arrays.push_back({"skeleton/points", 3, points});
  page.arrays.push_back({"skeleton/branch_offsets", 1, std::vector<std::uint32_t>{0, 3}});
  page.arrays.push_back({"skeleton/branch_points", 1, std::vector<std::uint32_t>{0, 1, 2}});
  page.arrays.push_back({"skeleton/point/radius", 1, values});
  page.arrays.push_back({"skeleton/point/erosion_thickness", 1, values});
  const auto bar = [&](const std::string& more) {  // pixels of the bar that are not the ground
    page.state = "layer=skeleton&camera=" + kFront + more;
    const Picture picture = draw_page(page, {1600, 1000, true, false});
    const Picture bare = draw_page(page, {1600, 1000, false, false});
    int count = 0;
    for (int y = 850; y < 1000; ++y)
      for (int x = 0; x < 500; ++x) count += at(picture, x, y) != at(bare, x, y);
    return count;
  };
  EXPECT_GT(bar(""), 3000);  // a skeleton of curves: these have the colours of their radius
  EXPECT_GT(bar("&color=erosion_thickness"), 3000);
  EXPECT_EQ(bar("&color=branch"), 0);
  std::erase_if(page.arrays, [](const PageArray& array) { return array.name == "skeleton/point/radius"; });
  EXPECT_EQ(bar(""), 0) << "curves have a colour of their own then, and there are no sheets";
}

TEST(PagePicture, NormalsBendButAtCreases) {
  // A roof of two squares: flat within 35 degrees, else sharp.
  for (const double angle : {20.0, 60.0}) {
    const auto c = static_cast<float>(std::cos(angle * std::numbers::pi / 180)),
               s = static_cast<float>(std::sin(angle * std::numbers::pi / 180));
    const std::vector<picture::Vec3f> points{{0, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {-1, 0, 0}, {c, 0, s}, {c, 1, s}};
    picture::Polygons roof;
    roof.offsets = {0, 4, 8};
    roof.corners = {0, 1, 2, 3, 0, 1, 5, 4};  // of different sides
    const std::vector<picture::Vec3f> normals = picture::crease_normals(points, roof, 35);
    const float along = std::abs(normals[0].z());
    EXPECT_NEAR(along, angle < 35 ? std::cos(angle / 2 * std::numbers::pi / 180) : 1, 1e-5);
    EXPECT_NEAR(std::abs(normals[2].z()), 1, 1e-6);
  }
}

// A file that says what was drawn: unpacked by code of its own.
TEST(PagePicture, PngFilesHoldThePixels) {
  const Picture picture = draw_page(crowd(), {521, 307, true, false});
  const TemporaryFolder folder;
  write_png(folder / "p.png", picture);
  std::ifstream in(folder / "p.png", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  ASSERT_TRUE(file.starts_with("\x89PNG\r\n\x1a\n"));
  const auto number = [&](std::size_t i) {
    std::uint32_t n = 0;
    for (std::size_t k = 0; k < 4; ++k) n = n << 8 | static_cast<unsigned char>(file[i + k]);
    return n;
  };
  std::string packed;
  for (std::size_t i = 8; i < file.size();) {
    const std::uint32_t length = number(i);
    const std::string type = file.substr(i + 4, 4);
    EXPECT_EQ(number(i + 8 + length), crc32(0, reinterpret_cast<const Bytef*>(&file[i + 4]), length + 4)) << type;
    if (type == "IHDR") {
      EXPECT_EQ(file.substr(i + 8, 13), std::string("\0\0\x02\x09\0\0\x01\x33\x08\x02\0\0\0", 13));
    }
    if (type == "IDAT") packed += file.substr(i + 8, length);
    i += length + 12;
  }
  const std::size_t width = 3 * 521;
  std::vector<std::uint8_t> rows(307 * (width + 1));
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()), Z_OK);
  ASSERT_EQ(size, rows.size());
  std::vector<std::uint8_t> pixels(307 * width);
  for (std::size_t y = 0; y < 307; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      const int left = x < 3 ? 0 : pixels[y * width + x - 3], up = y == 0 ? 0 : pixels[(y - 1) * width + x];
      const int corner = x < 3 || y == 0 ? 0 : pixels[(y - 1) * width + x - 3];
      const int p = left + up - corner;
      const int a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
      const std::array<int, 5> expected{0, left, up, (left + up) / 2, a <= b && a <= c ? left : b <= c ? up : corner};
      ASSERT_LT(rows[y * (width + 1)], 5);
      pixels[y * width + x] =
          static_cast<std::uint8_t>(rows[y * (width + 1) + 1 + x] + expected[rows[y * (width + 1)]]);
    }
  EXPECT_EQ(pixels, picture.pixels);
  EXPECT_THROW(write_png(folder / "absent" / "p.png", picture), Error);
}

}  // namespace page_picture_test
