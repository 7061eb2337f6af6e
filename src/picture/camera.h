// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "picture/scene.h"

namespace quench::picture {

/// What of the picture is covered by its border: nothing of the shape is framed there. Pixels.
struct Insets {
  double left = 0, right = 0, top = 0, bottom = 0;
};

/// A perspective camera; scene units.
class Camera {
 public:
  Camera(int width, int height, const Insets& insets) : width_(width), height_(height), insets_(insets) {}

  void look(const Vec3& position, const Vec3& target, const Vec3& up);
  /// Lets every `stride`-th point fit into what the insets leave, seen along the present direction.
  void frame(std::span<const Vec3f> points, std::size_t stride);

  /// To the eye: x to the right, y up, z towards the viewer.
  Vec3f view(const Vec3f& scene) const { return turn_.cast<float>() * (scene - eye_.cast<float>()); }
  Vec3 turned(const Vec3& direction) const { return turn_ * direction; }
  /// A point before the eye is at centre + focus (x, -y) / -z; pixels from the left top.
  double focus() const;
  double centre_x() const { return (width_ + insets_.left - insets_.right) / 2; }
  double centre_y() const { return (height_ + insets_.top - insets_.bottom) / 2; }
  double distance() const { return distance_; }
  double near() const { return std::max(distance_ - kReach, distance_ * kNearest); }
  double far() const { return distance_ + kReach; }
  /// Scene units per pixel at the target.
  double per_pixel() const { return distance_ / focus(); }

 private:
  int width_, height_;
  Insets insets_;
  Mat3 turn_ = Mat3::Identity();  ///< rows: right, up, towards the eye
  Vec3 target_ = Vec3::Zero(), eye_ = Vec3::Zero();
  double distance_ = 3;
};

/// As asked for, else three quarters from the front; volumes stand on z, meshes on y.
Camera first_look(const Page& page, const ViewState& state, const Scene& scene, int width, int height,
                  const Insets& insets);

}  // namespace quench::picture
