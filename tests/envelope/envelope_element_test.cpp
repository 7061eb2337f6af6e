// SPDX-License-Identifier: Apache-2.0
// Closed formulas of balls, cones and slabs, and the tree of them, against search and balls at random between.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "envelope/element.h"
#include "envelope/element_tree.h"

namespace quench::envelope {
namespace envelope_element_test {

double outside(const Element& e, const Vec3& p, double b, double c) {
  const Vec3 centre =
      (1 - b - c) * e.corner(0) + b * e.corner(std::min(1, e.corners() - 1)) + c * e.corner(e.corners() - 1);
  const double r =
      (1 - b - c) * e.radius(0) + b * e.radius(std::min(1, e.corners() - 1)) + c * e.radius(e.corners() - 1);
  return (p - centre).norm() - r;
}

// The least value of a convex function of [low, high].
template <class Function>
double least(double low, double high, const Function& f) {
  double best = std::min(f(low), f(high));
  for (int round = 0; round < 90; ++round) {
    const double third = (high - low) / 3, left = f(low + third), right = f(high - third);
    best = std::min({best, left, right});
    (left < right ? high : low) = left < right ? high - third : low + third;
  }
  return best;
}

// Over the balls between the corners, by search: |p - c| - r is convex in the weights.
double by_search(const Element& e, const Vec3& p) {
  return least(0, 1, [&](double b) { return least(0, 1 - b, [&](double c) { return outside(e, p, b, c); }); });
}

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  Vec3 point(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

  // Of all kinds: general ones, equal radii, balls in balls, points, corners that coincide or lie in a line.
  Element element() {
    const int corners = 1 + below(3), kind = below(8);
    Vec3 x[3] = {point(1), point(1), point(1)};
    double r[3] = {in(0, 0.6), in(0, 0.6), in(0, 0.6)};
    if (kind == 1) r[1] = r[2] = r[0];
    if (kind == 2) r[below(3)] = 3;
    if (kind == 3) r[below(3)] = 0;
    if (kind == 4) x[1] = x[0];
    if (kind == 5) x[2] = x[0] + in(-1, 2) * (x[1] - x[0]);
    if (kind == 6) x[2] = x[0] + in(0, 1) * (x[1] - x[0]) + 1e-6 * point(1);
    if (kind == 7) r[1] = r[0] + (x[1] - x[0]).norm();  // touches from inside
    if (corners == 1) return {x[0], r[0]};
    if (corners == 2) return {x[0], r[0], x[1], r[1]};
    return {x[0], r[0], x[1], r[1], x[2], r[2]};
  }

 private:
  std::mt19937_64 random_;
};

TEST(EnvelopeElement, DistancesAreTheLeastOfAllBallsBetween) {
  Random random(1);
  for (int i = 0; i < 4000; ++i) {
    const Element element = random.element();
    const Vec3 p = random.point(i % 2 ? 1 : 3);
    const NearBall near = element.nearest(p);
    ASSERT_NEAR(near.distance, by_search(element, p), 1e-8) << i;
    // It is a ball of the element, and no other is nearer by more than rounding.
    ASSERT_NEAR(near.weight[0] + near.weight[1] + near.weight[2], 1, 1e-12);
    ASSERT_GE(*std::min_element(near.weight.begin(), near.weight.end()), -1e-12);
    Vec3 centre = Vec3::Zero();
    double radius = 0;
    for (int k = 0; k < element.corners(); ++k) {
      centre += near.weight[static_cast<std::size_t>(k)] * element.corner(k);
      radius += near.weight[static_cast<std::size_t>(k)] * element.radius(k);
    }
    ASSERT_NEAR(radius, near.radius, 1e-12);
    ASSERT_NEAR((p - centre).norm() - radius, near.distance, 1e-12);
    for (int s = 0; s < 200; ++s) {
      const double b = random.in(0, 1), c = random.in(0, 1 - b);
      ASSERT_GE(outside(element, p, b, c), near.distance - 1e-9) << i;
    }
  }
}

TEST(EnvelopeElement, HasClosedForms) {
  // A cylinder with round ends.
  const Element capsule(Vec3(0, 0, 0), 1, Vec3(4, 0, 0), 1);
  EXPECT_NEAR(capsule.nearest(Vec3(2, 3, 0)).distance, 2, 1e-15);
  EXPECT_NEAR(capsule.nearest(Vec3(7, 4, 0)).distance, 4, 1e-15);
  EXPECT_NEAR(capsule.nearest(Vec3(1, 0, 0.25)).distance, -0.75, 1e-15);
  // A cone whose tangent rises with sine 0.6 : the distance of (x, y) to its side is 0.8 y - 0.6 x - r(0).
  const Element cone(Vec3(0, 0, 0), 1, Vec3(5, 0, 0), 4);
  EXPECT_NEAR(cone.nearest(Vec3(0, 0, 5)).distance, 0.8 * 5 - 1, 1e-14);
  EXPECT_NEAR(cone.nearest(Vec3(-1, 0, 5)).distance, 0.8 * 5 + 0.6 - 1, 1e-14);
  // One end holds the other: the ball alone.
  const Element ball(Vec3(0, 0, 0), 3, Vec3(1, 0, 0), 1);
  EXPECT_NEAR(ball.nearest(Vec3(5, 0, 0)).distance, 2, 1e-15);
  // A plate: half its thickness over the plane, rounded at the rim.
  const Element plate(Vec3(0, 0, 0), 0.5, Vec3(4, 0, 0), 0.5, Vec3(0, 4, 0), 0.5);
  EXPECT_NEAR(plate.nearest(Vec3(1, 1, 2)).distance, 1.5, 1e-15);
  EXPECT_NEAR(plate.nearest(Vec3(1, 1, 0.1)).distance, -0.4, 1e-15);
  EXPECT_NEAR(plate.nearest(Vec3(-3, -4, 0)).distance, 4.5, 1e-15);
  // A wedge between planes through the y axis whose half angle has the sine 0.6: over the plane the distance is that of
  // its upper plane.
  const Element wedge(Vec3(1, 0, 0), 0.6, Vec3(5, 0, 0), 3, Vec3(3, 8, 0), 1.8);
  EXPECT_NEAR(wedge.nearest(Vec3(2, 3, 3)).distance, 0.8 * 3 - 0.6 * 2, 1e-14);
  EXPECT_NEAR(wedge.nearest(Vec3(2, 3, 1)).distance, 0.8 * 1 - 0.6 * 2, 1e-14);
  // Radii too steep for planes that touch all three balls: its cones.
  const Element steep(Vec3(0, 0, 0), 0.1, Vec3(4, 0, 0), 0.1, Vec3(2, 1, 0), 2);
  for (const Vec3& p : {Vec3(2, 0.5, 3), Vec3(0, 1, 1), Vec3(3, -2, 0.2), Vec3(2, 0.2, 0)}) {
    const double least = std::min({Element(Vec3(0, 0, 0), 0.1, Vec3(4, 0, 0), 0.1).nearest(p).distance,
                                   Element(Vec3(0, 0, 0), 0.1, Vec3(2, 1, 0), 2).nearest(p).distance,
                                   Element(Vec3(4, 0, 0), 0.1, Vec3(2, 1, 0), 2).nearest(p).distance});
    EXPECT_EQ(steep.nearest(p).distance, least);
  }
}

TEST(EnvelopeElement, TheTreeFindsTheNearestOfAll) {
  Random random(2);
  for (int round = 0; round < 60; ++round) {
    std::vector<Element> elements;
    const int count = round < 10 ? round : 1 + random.below(400);
    const double size = round % 3 == 0 ? 1 : 20;
    for (int i = 0; i < count; ++i) {
      const Element e = random.element();
      const Vec3 at = random.point(size);
      elements.push_back(e.corners() == 1   ? Element(e.corner(0) + at, e.radius(0))
                         : e.corners() == 2 ? Element(e.corner(0) + at, e.radius(0), e.corner(1) + at, e.radius(1))
                                            : Element(e.corner(0) + at, e.radius(0), e.corner(1) + at, e.radius(1),
                                                      e.corner(2) + at, e.radius(2)));
    }
    const ElementTree tree(elements);
    for (int i = 0; i < 50; ++i) {
      const Vec3 p = random.point(1.2 * size);
      double wanted = std::numeric_limits<double>::infinity();
      bool in = false;
      for (const Element& e : elements) {
        const NearBall near = e.nearest(p);
        wanted = std::min(wanted, near.distance);
        in = in || near.distance <= 1e-9 * near.radius;
      }
      constexpr double kAll = std::numeric_limits<double>::infinity();
      const ElementTree::Near near = tree.nearest(p, kAll, -kAll);
      if (count == 0) {
        ASSERT_EQ(near.element, kNone);
      } else {
        ASSERT_EQ(near.ball.distance, wanted);
        ASSERT_EQ(elements[near.element].nearest(p).distance, wanted);
        ASSERT_EQ(tree.nearest(p, wanted, -kAll).element, kNone);
        ASSERT_LE(tree.nearest(p, kAll, wanted + 0.1).ball.distance, wanted + 0.1);
      }
      ASSERT_EQ(tree.contains(p, 1e-9), in);
    }
  }
}

}  // namespace envelope_element_test
}  // namespace quench::envelope
