// SPDX-License-Identifier: Apache-2.0
#include "picture/tube.h"

#include <cmath>

namespace quench::picture {

Tube::Tube(const Vec3f& a, const Vec3f& b, double radius_a, double radius_b)
    : a_(a.cast<double>()),
      along_((b - a).cast<double>()),
      radius_(radius_a),
      grow_(radius_b - radius_a),
      room_(along_.squaredNorm() - grow_ * grow_) {}

// The ball at the share s has the centre a + s along and the radius r + s grow. A point a + q is on the envelope where
// |q - s along|^2 - (r + s grow)^2 is zero together with its derivative by s:
//   s room = q along + r grow,   room (q q - r^2) = (q along + r grow)^2.
std::optional<Tube::Hit> Tube::hit(const Vec3& ray) const {
  if (room_ > 0) {
    const Vec3 from = -a_;
    const double along_ray = along_.dot(ray), along_from = along_.dot(from) + radius_ * grow_;
    const double square = room_ * ray.squaredNorm() - along_ray * along_ray;
    const double linear = room_ * ray.dot(from) - along_from * along_ray;
    const double rest = room_ * (from.squaredNorm() - radius_ * radius_) - along_from * along_from;
    const double inside = linear * linear - square * rest;
    // Of a ray steeper than a wide cone the square is negative, and the root is the place where it comes in, too.
    if (square != 0 && inside >= 0) {
      const double t = (-linear - std::sqrt(inside)) / square, share = (along_from + t * along_ray) / room_;
      if (share > 0 && share < 1) return Hit{t, share, (t * ray - a_ - share * along_).normalized().cast<float>()};
    }
  }
  const std::optional<Hit> first = hit_ball(ray, 0), second = hit_ball(ray, 1);
  if (!first || !second) return first ? first : second;
  return first->distance <= second->distance ? first : second;
}

std::optional<Tube::Hit> Tube::hit_ball(const Vec3& ray, double share) const {
  const Vec3 centre = a_ + share * along_;
  const double radius = radius_ + share * grow_, square = ray.squaredNorm(), half = ray.dot(centre);
  const double inside = half * half - square * (centre.squaredNorm() - radius * radius);
  if (inside < 0) return {};
  const double t = (half - std::sqrt(inside)) / square;
  return Hit{t, share, (t * ray - centre).normalized().cast<float>()};
}

}  // namespace quench::picture
