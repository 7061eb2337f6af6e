// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

#include "picture/style.h"
#include "quench/picture.h"

namespace quench::picture {

using Point = Eigen::Vector2d;  ///< pixels from the left top

/// Flat shapes and letters over a picture; what lies outside of it is not drawn.
class Canvas {
 public:
  explicit Canvas(Picture& picture);
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  ~Canvas();

  /// Width of a text in pixels; `size`: of the letters, in pixels. Texts are UTF-8.
  double width_of(const std::string& text, double size);
  /// The text, or as much of its beginning as fits, with an ellipsis.
  std::string fitted(const std::string& text, double size, double width);
  /// From the left end of the baseline.
  void write(const std::string& text, double size, const Point& at, const Vec3f& colour);
  /// A simple polygon.
  void fill(std::span<const Point> corners, const Vec3f& colour);
  void fill_box(const Point& low, const Point& high, const Vec3f& colour);
  /// From a to b.
  void stroke(const Point& a, const Point& b, double width, const Vec3f& colour);

 private:
  struct Letters;
  void blend(int x, int y, const Vec3f& colour, float cover);

  Picture& picture_;
  std::unique_ptr<Letters> letters_;
};

}  // namespace quench::picture
