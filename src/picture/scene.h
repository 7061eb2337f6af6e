// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "picture/style.h"
#include "picture/view_state.h"
#include "quench/page.h"

namespace quench::picture {

/// Polygons by the numbers of their corners.
struct Polygons {
  std::vector<std::uint32_t> offsets{0}, corners;
  std::size_t size() const { return offsets.size() - 1; }
};

/// World to scene: the box is centred and the longest side of the shape is 1.
struct Placement {
  Vec3 centre = Vec3::Zero();  ///< world
  double scale = 1;
  Vec3 to_scene(const Vec3& world) const { return (world - centre) * scale; }
};
Placement placement_of(const Page& page);

/// What of a page is drawn, in scene units.
struct Scene {
  Placement placement;
  std::vector<Vec3f> points;
  std::vector<float> values;  ///< per point, infinite and missing as their codes; empty: one colour
  Polygons sheets;
  std::vector<std::array<std::uint32_t, 2>> curves, boundary, seams;
  std::vector<std::uint32_t> sheet_parts, curve_parts;  ///< per polygon, per curve; empty unless they give the colour
  std::vector<std::pair<std::string, std::uint32_t>> part_names;  ///< for a legend: names of parts
  std::vector<std::uint32_t> isolated;                            ///< points without any cell
  std::vector<float> radius;                                      ///< per point: curves are tubes; empty: lines
  double area = 0, curve_length = 0;
  std::vector<Vec3f> shape_points;
  Polygons shape;
  std::vector<float> sheet_values;  ///< per polygon: a value instead of those of its points; empty: of points
  bool plane = false;
  std::vector<std::array<std::uint32_t, 2>> outline;  ///< of a plane: sides of the shape, directed around it
  double sheet_crease = kCrease;
  double shape_crease = kCrease;  ///< surfaces of voxels have steps, no edges: a right angle
};
Scene scene_of(const Page& page, const ViewState& state);

/// The range of colours, and what there is beside it.
struct ColourRange {
  double low = 0, high = 1;    ///< of the colours
  double least = 0, most = 0;  ///< of all finite values
  bool finite = false, infinite = false, missing = false;
};
ColourRange colour_range(const Scene& scene, const ViewState& state);

/// Per corner the mean of the normals around its vertex that turn off by no more than `crease` degrees, weighted by
/// area; their sign does not matter. Zero where there is none.
std::vector<Vec3f> crease_normals(const std::vector<Vec3f>& points, const Polygons& polygons, double crease);

}  // namespace quench::picture
