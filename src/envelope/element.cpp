// SPDX-License-Identifier: Apache-2.0
#include "envelope/element.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace quench::envelope {

Element::Element(const Vec3& a, double r_a) : a_(a), r_{r_a, 0, 0}, corners_(1) {}

Element::Element(const Vec3& a, double r_a, const Vec3& b, double r_b)
    : a_(a), ab_(b - a), r_{r_a, r_b, 0}, corners_(2) {}

Element::Element(const Vec3& a, double r_a, const Vec3& b, double r_b, const Vec3& c, double r_c)
    : a_(a), ab_(b - a), ac_(c - a), r_{r_a, r_b, r_c}, corners_(3) {
  constexpr double kFlat = 1e-10, kThin = 1e-4;  // height over longest side
  const Vec3 cross = ab_.cross(ac_);
  const double twice = cross.norm(),
               longest2 = std::max({ab_.squaredNorm(), ac_.squaredNorm(), (ac_ - ab_).squaredNorm()});
  if (!(twice > kFlat * longest2)) return;  // in a line: the union of its three cones, to 1e-10 of its length
  thin_ = twice < kThin * longest2;
  normal_ = cross / twice;
  b_ = ac_.cross(normal_) / twice;
  c_ = normal_.cross(ab_) / twice;
  const Vec3 gradient = (r_b - r_a) * b_ + (r_c - r_a) * c_;
  const double steep2 = gradient.squaredNorm();
  if (!(steep2 < 1)) return;
  planes_ = true;
  const double slope = 1 / std::sqrt(1 - steep2);
  slope_b_ = slope * b_.dot(gradient);
  slope_c_ = slope * c_.dot(gradient);
}

NearBall Element::in_segment(const Vec3& q, int i, int j) const {
  const Vec3 from = i == 0 ? Vec3::Zero() : i == 1 ? ab_ : ac_, along = (j == 1 ? ab_ : ac_) - from, own = q - from;
  const double r = r_[static_cast<std::size_t>(i)], rise = r_[static_cast<std::size_t>(j)] - r;
  const double length2 = along.squaredNorm(), clear2 = length2 - rise * rise;
  double t;
  if (clear2 > 0) {
    const double foot = own.dot(along) / length2, away = (own - foot * along).norm();
    t = std::clamp(foot + away * rise / std::sqrt(clear2 * length2), 0.0, 1.0);
  } else {
    t = rise > 0 ? 1 : 0;  // one of the balls holds the other
  }
  NearBall near;
  near.radius = r + t * rise;
  near.distance = (own - t * along).norm() - near.radius;
  near.weight = {0, 0, 0};
  near.weight[static_cast<std::size_t>(i)] = 1 - t;
  near.weight[static_cast<std::size_t>(j)] = t;
  return near;
}

NearBall Element::nearest(const Vec3& p) const {
  const Vec3 q = p - a_;
  if (corners_ == 1) return {q.norm() - r_[0], r_[0], {1, 0, 0}};
  if (corners_ == 2) return in_segment(q, 0, 1);
  bool side_a = true, side_b = true, side_c = true;  // opposite of the corners: those that may have the nearest ball
  NearBall best;
  best.distance = std::numeric_limits<double>::infinity();
  if (planes_) {
    const double height = std::abs(normal_.dot(q));
    const double b = b_.dot(q) + height * slope_b_, c = c_.dot(q) + height * slope_c_, a = 1 - b - c;
    if (a >= 0 && b >= 0 && c >= 0) {
      best.radius = r_[0] + b * (r_[1] - r_[0]) + c * (r_[2] - r_[0]);
      best.distance = (q - b * ab_ - c * ac_).norm() - best.radius;
      best.weight = {a, b, c};
      if (!thin_) return best;
    } else if (!thin_) {
      // The function is convex: its minimum lies on a side beyond which it would fall further.
      side_a = a < 0;
      side_b = b < 0;
      side_c = c < 0;
    }
  }
  const auto try_side = [&](bool wanted, int i, int j) {
    if (!wanted) return;
    const NearBall near = in_segment(q, i, j);
    if (near.distance < best.distance) best = near;
  };
  try_side(side_c, 0, 1);
  try_side(side_b, 0, 2);
  try_side(side_a, 1, 2);
  return best;
}

}  // namespace quench::envelope
