// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/surface.h"

namespace quench::axis {

/// A place where a ball could touch a surface: while the ball stays where it is, the place slides to the nearest one in
/// its neighbourhood, that is, to where the surface is at right angles to the line from the centre.
class ContactPlace {
 public:
  explicit ContactPlace(const Vec3& point) : point_(point), aim_(point) {}

  const Vec3& point() const { return point_; }

  /// One step from a point of the surface, as seen from a centre. Returns how far it was off.
  ///
  /// The nearest point to the middle between the centre and a place on a flat surface is half as far off as the place:
  /// so much again, and it is where it should be. From the middle, because from the centre itself the nearest point may
  /// be at another contact.
  double look_again(const Vec3& centre, const Surface& surface) {
    const Vec3 middle = 0.5 * (centre + aim_);
    const Surface::Foot foot = surface.nearest(middle, (1 + 1e-9) * (point_ - middle).norm());
    if (foot.triangle == kNone) return 0;
    const double off = (foot.point - aim_).norm();
    point_ = foot.point;
    aim_ = 2 * foot.point - aim_;
    return off;
  }

 private:
  Vec3 point_;  // of the surface
  Vec3 aim_;    // where it should be
};

}  // namespace quench::axis
