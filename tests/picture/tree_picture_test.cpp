// SPDX-License-Identifier: Apache-2.0
// Pictures of trees: tubes, their colours, where they are seen from.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "picture/caption.h"
#include "picture/tube.h"
#include "quench/error.h"
#include "quench/picture.h"
#include "tree_of_root.h"

namespace quench {
namespace tree_picture_test {

using picture::Tube;
using picture::Vec3f;
using Colour = std::array<int, 3>;

/// The least distance along the ray to any of many balls between the ends; 0: it meets none.
double first_ball(const Vec3f& a, const Vec3f& b, double ra, double rb, const Vec3& ray) {
  double nearest = 0;
  for (int i = 0; i <= 20000; ++i) {
    const double s = i / 20000.0, radius = ra + s * (rb - ra), square = ray.squaredNorm();
    const Vec3 centre = a.cast<double>() + s * (b - a).cast<double>();
    const double half = ray.dot(centre), inside = half * half - square * (centre.squaredNorm() - radius * radius);
    if (inside < 0) continue;
    const double t = (half - std::sqrt(inside)) / square;
    if (nearest == 0 || t < nearest) nearest = t;
  }
  return nearest;
}

TEST(Tube, IsTheUnionOfItsBalls) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  int met = 0, missed = 0;
  for (int i = 0; i < 600; ++i) {
    const auto place = [&] {
      return Vec3f(Vec3(0.3 * unit(random), 0.3 * unit(random), -3 + 0.5 * unit(random)).cast<float>());
    };
    const Vec3f a = place(), b = i % 10 == 0 ? a : place();
    const double ra = 0.02 + 0.1 * std::abs(unit(random)),
                 rb = i % 7 == 0 ? 4 * ra + 0.5 : 0.02 + 0.1 * std::abs(unit(random));
    const Vec3 ray(0.1 * unit(random), 0.1 * unit(random), -1);
    const auto hit = Tube(a, b, ra, rb).hit(ray);
    const double expected = first_ball(a, b, ra, rb, ray);
    if (!hit) {
      EXPECT_EQ(expected, 0) << i;
      ++missed;
      continue;
    }
    ++met;
    EXPECT_NEAR(hit->distance, expected, 1e-3) << i;
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-5);
    // The place is on the ball that it says, in the direction of the normal.
    const Vec3 centre = a.cast<double>() + hit->share * (b - a).cast<double>();
    const Vec3 surface = centre + (ra + hit->share * (rb - ra)) * hit->normal.cast<double>();
    EXPECT_LT((surface - hit->distance * ray).norm(), 1e-5) << i;
    EXPECT_LE(hit->normal.dot(ray.cast<float>()), 1e-4F);
  }
  EXPECT_GT(met, 100);
  EXPECT_GT(missed, 100);
}

/// A stem of radius 0.1 along -z with an axis of level 1 to +x and one of level 2 below it.
struct SmallTree {
  Tree tree;
  Page page;

  SmallTree() {
    add(kNone, 0, {{0, 0, 0}, {0, 0, -0.5}}, 0.1);
    add(0, 0, {{0, 0, -0.5}, {0, 0, -2}}, 0.1);
    add(0, 1, {{0, 0, -0.5}, {0.5, 0, -0.5}}, 0.06);
    add(2, 1, {{0.5, 0, -0.5}, {1, 0, -0.5}}, 0.06);
    add(2, 2, {{0.5, 0, -0.5}, {0.5, 0, -1}}, 0.04);
    tree.axes.resize(3);
    tree.axes[1].parent = 0;
    tree.axes[2].parent = 1;
    tree.axes[1].level = 1;
    tree.axes[2].level = 2;
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b)
      tree.axes[tree.branches[b].axis].points = tree.branches[b].points;
    for (Tree::Axis& axis : tree.axes) axis.radius.assign(axis.points.size(), 0.1);
    page.side = 2;
    add_tree(page, tree, testing_trees::traits_of_root(tree), {});
  }
  void add(std::uint32_t parent, std::uint32_t axis, const std::vector<Vec3>& points, double radius) {
    Tree::Branch branch;
    branch.parent = parent;
    branch.axis = axis;
    branch.points = points;
    branch.radius.assign(points.size(), radius);
    tree.branches.push_back(branch);
  }
};

constexpr int kSide = 400;
const std::string kFront = "camera=0.3,-5,-1,0.3,0,-1,0,0,1";

/// Where a place in the plane y = 0 is seen.
Colour at(const Picture& picture, double x, double z) {
  const double unit = kSide / 2.0 / std::tan(15 * std::numbers::pi / 180) / 5;
  const auto px = static_cast<std::size_t>(kSide / 2.0 + (x - 0.3) * unit),
             py = static_cast<std::size_t>(kSide / 2.0 - (z + 1) * unit);
  const std::size_t i = 3 * (py * kSide + px);
  return {picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]};
}

char hue(const Colour& c) {
  if (c == Colour{255, 255, 255}) return '.';
  if (c[2] > c[0] + 25) return 'b';
  if (c[0] > c[1] + 25 && c[1] > c[2]) return 'o';
  return c[1] > c[0] + 15 && c[1] > c[2] + 15 ? 'g' : '?';
}

TEST(TreePicture, TubesAreAsThickAsTheyAreInTheColoursOfTheirLevels) {
  SmallTree small;
  small.page.state = kFront;
  const Picture picture = draw_page(small.page, {kSide, kSide, false, false});
  std::string hues;
  for (const auto& [x, z] : std::vector<std::pair<double, double>>{{0, -1.5},
                                                                   {0.085, -1.5},
                                                                   {0.115, -1.5},
                                                                   {0.3, -0.5},
                                                                   {0.3, -0.45},
                                                                   {0.3, -0.42},
                                                                   {0.5, -0.8},
                                                                   {0.53, -0.8},
                                                                   {0.55, -0.8}})
    hues += hue(at(picture, x, z));
  EXPECT_EQ(hues, "bb.oo.gg.");
}

TEST(TreePicture, StandsUprightInTheMiddle) {
  SmallTree small;
  const Picture picture = draw_page(small.page, {600, 400, false, false});
  std::vector<std::size_t> blue_rows, orange_rows;
  for (std::size_t y = 0; y < 400; ++y)
    for (std::size_t x = 0; x < 600; ++x) {
      const std::size_t i = 3 * (600 * y + x);
      const char h = hue({picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]});
      if (h == 'b') blue_rows.push_back(y);
      if (h == 'o') orange_rows.push_back(y);
      EXPECT_TRUE(h == '.' || (y >= 5 && y < 395));  // not even the round ends are cut
    }
  ASSERT_FALSE(blue_rows.empty() || orange_rows.empty());
  EXPECT_LT(orange_rows.back(), 170U);  // it grows near the top
  EXPECT_GT(blue_rows.back(), 350U);
}

TEST(TreePicture, TakesTheColoursOfItsState) {
  SmallTree small;
  const auto drawn = [&](const std::string& color) {
    small.page.state = kFront + "&color=" + color;
    return draw_page(small.page, {kSide, kSide, false, false});
  };
  const Colour thick = at(drawn("radius"), 0, -1.5), thin = at(drawn("radius"), 0.5, -0.8);
  EXPECT_GT(thick[1], 2 * thick[2]);  // the largest radius is yellow, the smallest violet
  EXPECT_GT(thin[2], thin[1]);
  const Colour longest = at(drawn("axes/length"), 0, -1.5), shortest = at(drawn("branches/length"), 0.8, -0.5);
  EXPECT_GT(longest[1], 2 * longest[2]);
  EXPECT_GT(shortest[2], shortest[1]);
  for (const char* color : {"axis", "branch", "plant", "bridged", "order", "strahler", "angle_to_down", "none"})
    drawn(color);
  for (const char* color : {"axes/class", "axes/nothing", "length", "sample/total_length"})
    EXPECT_THROW(drawn(color), Error) << color;
}

TEST(TreePicture, SaysWhatItShows) {
  SmallTree small;
  small.page.title = "root";
  small.page.unit = "mm";
  EXPECT_EQ(caption_of(small.page), (std::vector<std::string>{"root", "3 axes · length 2.5 mm"}));
  EXPECT_EQ(picture::label_of("axes/mean_radius"), "mean radius of the axis");
  EXPECT_EQ(picture::unit_of(small.page, "branches/length"), "mm");
  EXPECT_EQ(picture::unit_of(small.page, "angle_to_down"), "°");
  // The legend has a swatch for each level, and nothing else is that far down at the left.
  const Picture picture = draw_page(small.page, {800, 500, true, false});
  std::array<int, 3> swatches{};
  for (std::size_t y = 450; y < 500; ++y)
    for (std::size_t x = 0; x < 350; ++x) {
      const std::size_t i = 3 * (800 * y + x);
      for (std::size_t level = 0; level < 3; ++level) {
        const Vec3f colour = picture::rgb(picture::kParts[level]) * 255;
        swatches[level] += picture.pixels[i] == std::lround(colour[0]) &&
                           picture.pixels[i + 1] == std::lround(colour[1]) &&
                           picture.pixels[i + 2] == std::lround(colour[2]);
      }
    }
  for (const int pixels : swatches) EXPECT_GT(pixels, 40);
}

TEST(TreePicture, ArraysThatDoNotFitAreRefused) {
  for (const char* name : {"tree/branch_axis", "tree/branch_offsets", "tree/point/radius", "tree/axis_level"}) {
    SmallTree small;
    std::erase_if(small.page.arrays, [&](const PageArray& array) { return array.name == name; });
    EXPECT_THROW(draw_page(small.page, {64, 64, false, false}), Error) << name;
  }
}

TEST(TreePicture, IsTheSameForEveryNumberOfThreads) {
  const Tree tree = testing_trees::tree_of_root(make_sample("root", {.branches = 40}));
  Page page;
  page.side = 1;
  add_tree(page, tree, testing_trees::traits_of_root(tree), {});
  std::vector<std::vector<std::uint8_t>> pixels;
  for (const int threads : {1, 3}) {
    Context context;
    context.threads = threads;
    pixels.push_back(draw_page(page, {300, 200, true, false}, &context).pixels);
  }
  EXPECT_EQ(pixels[0], pixels[1]);
}

}  // namespace tree_picture_test
}  // namespace quench
