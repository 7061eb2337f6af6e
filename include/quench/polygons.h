// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

/// Polygons of the plane: digitized into pixel shapes, and the outlines of pixel shapes as polygons.
namespace quench {

using Vec2 = Eigen::Vector2d;

/// A region of the plane bounded by closed rings: outlines of parts and of holes, in any order and direction. A ring
/// may cross itself and others: a PolygonFill says what is inside. The first point need not be repeated at the end.
struct Polygons {
  std::vector<std::vector<Vec2>> rings;
};

/// Which points are inside, by their winding number about all rings together.
enum class PolygonFill {
  evenodd,  ///< odd: directions of rings do not matter; what two parts both cover is outside
  nonzero   ///< not 0: parts may overlap; holes go round the other way than what they are in
};

/// A polygon of a file.
struct PolygonFeature {
  Polygons polygons;
  std::uint64_t number = 0;  ///< of the feature in its file, from 0
  std::string id;            ///< JSON text of a string or a number; empty: none
  std::string properties;    ///< JSON text of an object; empty: none
  PolygonFill fill = PolygonFill::evenodd;
  bool y_down = false;  ///< y of the coordinates grows downwards (SVG)
};

/// The size of pixels. At most one of `resolution` and `pixel` may be set; with neither, the resolution is
/// kDefaultResolution.
struct DigitizeOptions {
  std::optional<std::int64_t> resolution;  ///< pixels along the longest side of the box of the rings, 1 to 2^20
  std::optional<double> pixel;             ///< side of a pixel, in units of the coordinates
  PolygonFill fill = PolygonFill::evenodd;
};

/// A pixel is a thousandth of the longest side: about what is printed or seen of one shape, and the core of such an
/// outline takes milliseconds.
inline constexpr std::int64_t kDefaultResolution = 1024;
/// Pixels along a side of a digitized region, which is what the predicates of the plane take.
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 20;

/// The pixels whose centres are inside, on a grid that depends on these rings alone: square pixels from the least x and
/// y of the rings on, as many as cover their box; origin + pixel * (i, j), as exact real numbers of these doubles, is
/// the centre of pixel (i, j). So between the boundary of the region and that of the pixels are at most
/// pixel / sqrt(2) from any point of the latter to the former, and as much the other way round wherever the region is
/// not thinner than a pixel.
///
/// Exact for every double: floating point decides where a bound on its error allows, else a sum of products without
/// rounding. Ties, by which adjacent regions share no pixel and leave none out: of centres on the boundary those with
/// the region at their right (greater x) are inside, on horizontal edges those with the region above (greater y).
///
/// Notes when the rings do not touch and the pixel shape has other numbers of components or holes than the region,
/// where that is cheap to know (rings of up to a million points).
///
/// Throws Error(usage) for an impossible option. Throws Error(input) for coordinates that are not finite, a ring of
/// less than three different points, pixels beyond 1e-30 to 1e30, coordinates beyond 10^12 pixels from 0, more than
/// kMostPixels along a side, and when no centre is inside: then the sentence says how thin the region is and which
/// resolution finds pixels in it. Throws Error(failed) when the crossings need more memory than there is.
///
/// O(points + c log c) for c crossings of rings with rows of centres; 4 bytes per crossing and point. One thread.
VoxelShape digitize(const Polygons& polygons, const DigitizeOptions& options = {}, Context* context = nullptr);

/// The boundary of a pixel shape as rings of corners of pixels, in the world. Neighbouring edges are never collinear.
/// The shape is at the left where x goes right and y goes up: outer rings go counter-clockwise, holes clockwise. Where
/// two pixels share a corner only, rings touch there without crossing: there are as many outer rings as 4-connected
/// components, and one ring per hole. In the order of the least (y, x) of their corners. O(runs log runs).
Polygons boundary_rings(const VoxelShape& plane);

/// Rings of boundary_rings() by the part they bound: the outer ring of each, and behind it its holes. O(points), and
/// O(points log points) where there are holes.
std::vector<Polygons> parts_of(const Polygons& boundary);

namespace io {

struct PolygonReadOptions {
  /// SVG: how far flattened curves are from the true ones at most, as a fraction of the longest side of their shape.
  double curve_tolerance = 1e-5;
};

/// Reads .geojson and .json (GeoJSON), .geojsonl, .geojsons and .ndjson (a GeoJSON object per line), .wkt and .svg, and
/// hands over one feature after the other, in the order of the file; returns how many there were, bad ones included.
/// A feature that cannot be used is handed to `bad` without its rings, with an Error(input) whose sentence names file
/// and feature; what is empty or thin is left to digitize().
///
/// GeoJSON: Polygon, MultiPolygon and GeometryCollection, in a Feature, a FeatureCollection or alone. Memory for one
/// feature; z is left out. WKT: POLYGON and MULTIPOLYGON, also inside GEOMETRYCOLLECTION; `SRID=...;`, Z, M and EMPTY;
/// one after the other, on as many lines as they like; memory for one. SVG: see docs/user/files.md; the drawing is in
/// memory as a whole.
///
/// Notes what the coordinates suggest: degrees, exchanged axes. Throws Error(failed) when the file cannot be read and
/// Error(input) when it is not of its format or damaged; features before the damage have been handed over. What `take`
/// throws goes through.
std::uint64_t for_each_feature(const std::filesystem::path& file, const std::function<void(PolygonFeature&&)>& take,
                               const std::function<void(PolygonFeature&&, const Error&)>& bad,
                               Context* context = nullptr, const PolygonReadOptions& options = {});

}  // namespace io

}  // namespace quench
