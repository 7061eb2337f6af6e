// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "picture/scene.h"
#include "picture/style.h"

namespace quench::picture {

/// The light of the page (viewer/src/scene/shaders.ts). Directions are those of the eye: x right, y up, z towards it.
class Light {
 public:
  Light(const ColourRange& range, bool dark);

  /// The colour of a value, ready for lit().
  Vec3f colour_of(float value) const;
  /// A colour of 0 to 1 the same way.
  static Vec3f linear(const Vec3f& colour);
  /// A matte surface seen from the direction `to_eye`; both sides are alike.
  Vec3f lit(const Vec3f& linear_colour, const Vec3f& normal, const Vec3f& to_eye, float gloss) const;
  /// The glass of the shape.
  struct Glass {
    Vec3f colour;
    float opacity;
  };
  Glass glass(const Vec3f& normal, const Vec3f& to_eye) const;

 private:
  float encoded(float x) const;
  float low_, factor_;
  Vec3f key_, fill_, tint_, rim_, missing_, infinite_;
  std::vector<Vec3f> map_;      ///< colours at equal steps
  std::vector<float> encoded_;  ///< by the square root
  std::vector<float> edge_;     ///< of glass, by how much it faces the eye
};

}  // namespace quench::picture
