// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>
#include <vector>

#include "quench/polygons.h"

namespace quench::io {

using SvgTransform = Eigen::Affine2d;

/// The course of a path in coordinates of the drawing: closed subpaths of lines and curves of Bézier.
class SvgPath {
 public:
  explicit SvgPath(const SvgTransform& transform) : transform_(transform) {}

  void move_to(const Vec2& p);
  void line_to(const Vec2& p);
  void cubic_to(const Vec2& a, const Vec2& b, const Vec2& end);
  /// An arc of an ellipse (SVG 2, appendix B.2), in curves of at most 22.5 degrees, which are 1e-7 of the radius off.
  void arc_to(const Vec2& radii, double degrees, bool large, bool clockwise, const Vec2& end);
  void close() {
    at_ = start_;
    begun_ = false;
  }
  const Vec2& at() const { return at_; }

  /// The subpaths as rings of points; what is flattened is off by `tolerance` of the longest side of the box of all
  /// control points at most. Subpaths of less than three different points are left out: they fill nothing. Throws
  /// SvgDamage for coordinates of 1e100 or more.
  Polygons flattened(double tolerance) const;

 private:
  /// A line, or a curve with two control points.
  struct Piece {
    bool curve;
    std::array<Vec2, 3> points;  // the last one is the end
  };
  struct Subpath {
    Vec2 start;
    std::vector<Piece> pieces;
  };
  Subpath& subpath();

  SvgTransform transform_;
  Vec2 at_{0, 0}, start_{0, 0};  // in coordinates of the path
  bool begun_ = false;
  std::vector<Subpath> subpaths_;
};

/// Why the text of an attribute cannot be read.
struct SvgDamage {
  std::string reason;
};

/// Reads the text of a `d` attribute (SVG 2, section 9.3). Throws SvgDamage.
void read_path_data(std::string_view text, SvgPath& path);
/// Numbers separated by blanks and commas. Throws SvgDamage.
std::vector<double> read_svg_numbers(std::string_view text);
/// The text of a `transform` attribute. Throws SvgDamage.
SvgTransform read_svg_transform(std::string_view text);

}  // namespace quench::io
