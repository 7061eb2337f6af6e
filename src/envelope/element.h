// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "quench/geometry.h"

namespace quench::envelope {

/// The ball of an element that a point is least outside of.
struct NearBall {
  double distance = 0;  ///< |p - centre| - radius: negative inside
  double radius = 0;
  std::array<double, 3> weight{1, 0, 0};  ///< of the corners of the element: centre and radius are their mean
};

/// One to three balls and all that lie linearly between them: a ball; a cone, swept along a segment; a slab, swept over
/// a triangle. It is the convex hull of its balls, as hulls of balls are unions of their convex combinations. Corners
/// may coincide or lie in a line, and balls in one another.
class Element {
 public:
  Element(const Vec3& a, double r_a);
  Element(const Vec3& a, double r_a, const Vec3& b, double r_b);
  Element(const Vec3& a, double r_a, const Vec3& b, double r_b, const Vec3& c, double r_c);

  /// The minimum of |p - c(x)| - r(x) over the element, in closed form (docs/algorithms/envelope.md): of one that p
  /// lies outside of its distance; of one with p inside what p lies below its surface. Double precision, relative to
  /// the size of the element and the distance.
  NearBall nearest(const Vec3& p) const;

  /// No more than that distance, and a tenth of the work: f(x) is at least its part along the direction u from the
  /// middle of the element to p, u.(p - c(x)) - r(x), which is linear and least at a corner. Near where elements are
  /// small beside their radii.
  double bound(const Vec3& p) const {
    if (corners_ == 1) return -std::numeric_limits<double>::infinity();
    const Vec3 q = p - a_, away = q - (ab_ + ac_) * (1.0 / corners_);
    const double length = away.norm();
    if (!(length > 0)) return -std::numeric_limits<double>::infinity();
    const double a = away.dot(q), scale = 1 / length;
    double least = std::min(a * scale - r_[0], (a - away.dot(ab_)) * scale - r_[1]);
    if (corners_ == 3) least = std::min(least, (a - away.dot(ac_)) * scale - r_[2]);
    return least - kRounding * (length + std::max({r_[0], r_[1], r_[2]}) + ab_.lpNorm<1>() + ac_.lpNorm<1>());
  }

  int corners() const { return corners_; }
  Vec3 corner(int i) const { return i == 0 ? a_ : i == 1 ? Vec3(a_ + ab_) : Vec3(a_ + ac_); }
  double radius(int i) const { return r_[static_cast<std::size_t>(i)]; }

 private:
  static constexpr double kRounding = 1e-14;
  NearBall in_segment(const Vec3& q, int i, int j) const;

  Vec3 a_, ab_ = Vec3::Zero(), ac_ = Vec3::Zero();
  std::array<double, 3> r_;
  // Of a slab with tangent planes: x - a has the weights b_.(x - a), c_.(x - a) of the second and third corner; the
  // nearest ball to a point at height h over the plane has its centre h times (slope_b_, slope_c_) beside its foot.
  Vec3 normal_ = Vec3::Zero(), b_ = Vec3::Zero(), c_ = Vec3::Zero();
  double slope_b_ = 0, slope_c_ = 0;
  int corners_;
  bool planes_ = false;  // there are planes that touch all three balls
  bool thin_ = false;    // weights are not to be trusted to tell which side is nearer
};

}  // namespace quench::envelope
