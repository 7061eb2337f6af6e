// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "picture/camera.h"
#include "picture/light.h"
#include "picture/tile.h"
#include "picture/tube.h"

namespace quench::picture {

/// Everything of a scene that is drawn, numbered in the order in which it is drawn: triangles of the sheets, curves,
/// isolated points, boundary and seams of the sheets, triangles of the shape.
class Primitives {
 public:
  Primitives(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera, double unit);

  std::uint32_t count() const { return shape_end_; }
  /// The samples it may cover.
  Box box_of(std::uint32_t id) const;
  void draw(std::uint32_t id, Tile& tile) const;
  /// The colour of what is solid at a position, in samples.
  Vec3f colour_at(std::uint32_t id, double x, double y) const;
  Light::Glass glass_at(std::uint32_t id, double x, double y) const;
  /// What lies under thin lines, with them.
  Vec3f under_lines(const Vec3f& colour, std::uint8_t kinds) const;

 private:
  using Corners = std::array<std::uint32_t, 3>;
  bool is_shape(std::uint32_t id) const { return id >= lines_end_; }
  Projected projected(const Vec3f& view) const {
    return {focus_ * view.x() - centre_x_ * view.z(), -focus_ * view.y() - centre_y_ * view.z(), -double{view.z()}};
  }
  std::array<Vec3f, 3> triangle(std::uint32_t id) const;
  std::array<std::uint32_t, 2> ends(std::uint32_t id) const;
  BarSetup bar(std::uint32_t id) const;
  /// Curves are tubes of the radii of their points, but no thinner than what is seen well.
  bool is_tube(std::uint32_t id) const { return id >= sheets_end_ && id < curves_end_ && !scene_.radius.empty(); }
  Tube tube(std::uint32_t id) const;
  double tube_radius(std::uint32_t v) const;
  Vec3 ray(double x, double y) const { return {(x - centre_x_) / focus_, (centre_y_ - y) / focus_, -1}; }
  bool is_before_eye(std::uint32_t v) const { return -points_[v].z() > near_; }
  Vec3f point_colour(std::uint32_t v) const {
    return curve_plain_ ? *curve_plain_ : light_.colour_of(scene_.values[v]);
  }
  Vec3f colour_of_sheet(std::uint32_t id, double x, double y) const;
  Vec3f colour_of_curve(std::uint32_t id, double x, double y) const;
  Vec3f colour_of_tube(std::uint32_t id, double x, double y) const;
  Vec3f base_of_curve(std::uint32_t id, float share) const;
  Vec3f colour_of_point(std::uint32_t id, double x, double y) const;

  const Scene& scene_;
  Light light_;
  double focus_, centre_x_, centre_y_, near_;  ///< samples
  double range_bias_;                          ///< of depth, per bias of the page
  double curve_half_, tube_half_, point_half_, boundary_half_, seam_half_;
  float boundary_opacity_, seam_opacity_;
  Vec3f boundary_colour_, seam_colour_;
  std::optional<Vec3f> sheet_plain_, curve_plain_;  ///< one colour
  std::vector<Vec3f> points_, shape_points_;        ///< before the eye
  std::vector<Vec3f> normals_, shape_normals_;      ///< per corner
  std::vector<Corners> sheets_, shape_;             ///< rows of corners
  std::vector<std::uint32_t> polygon_;              ///< per triangle of the sheets
  std::uint32_t sheets_end_, curves_end_, points_end_, boundary_end_, lines_end_, shape_end_;
};

}  // namespace quench::picture
