// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "picture/tile.h"

namespace quench::picture {

/// The balls whose centres and radii go evenly from those of one point to those of another, before the eye: x to the
/// right, y up, z towards the viewer.
class Tube {
 public:
  struct Hit {
    double distance;  ///< along the line of sight
    double share;     ///< of the way from a to b
    Vec3f normal;
  };

  Tube(const Vec3f& a, const Vec3f& b, double radius_a, double radius_b);
  /// The first place on the ray from the eye through (x, y, -1).
  std::optional<Hit> hit(const Vec3& ray) const;

 private:
  std::optional<Hit> hit_ball(const Vec3& ray, double share) const;
  Vec3 a_, along_;
  double radius_, grow_;  ///< the radius at a, and how much more it is at b
  double room_;           ///< how much farther the centres are apart than the radii differ, of squares
};

}  // namespace quench::picture
