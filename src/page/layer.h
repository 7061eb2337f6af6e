// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/rounded_down.h"
#include "quench/page.h"

namespace quench::page {

/// Levels of the cells of a complex by one measure.
struct Levels {
  std::string name;
  std::vector<float> vertex, edge, face;
};

/// Which cells of a complex a layer shows, and their levels. No levels: the layer has none.
struct LayerCells {
  std::vector<std::uint32_t> faces;  ///< in the order they are written: decreasing by the first levels
  std::vector<char> edge, vertex;    ///< closed: the sides of the faces are among the edges, their ends among vertices
  std::vector<Levels> levels;
};

/// Rows of the vertices and edges in the arrays of the layer, or kNone.
struct LayerRows {
  std::vector<std::uint32_t> vertex, edge;
  std::vector<std::uint32_t> vertices, edges;  ///< per row
};

/// Adds points, polygons, edges and levels of a layer (`face_level` ..., of all but the first `face_level/NAME` ...),
/// vertices and edges in their order; widens the box of the page.
LayerRows add_layer(Page& page, const std::string& layer, const CellComplex& complex, std::span<const Vec3> points,
                    const LayerCells& cells);

/// The value of a measure: rounded to 17 bits (5 digits), which saves a quarter of its memory.
inline float measure_of(double value) {
  const auto nearest = static_cast<float>(value);
  if (!std::isfinite(nearest)) return nearest;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(nearest);
  return std::bit_cast<float>((bits + 0x3F + (bits >> 7 & 1)) & ~0x7FU);
}

/// Adds `layer/point/name`, of the vertices that are shown. `value` is called from several threads.
template <class Value>
void add_measure(Page& page, const std::string& layer, const std::string& name, const LayerRows& rows, Value&& value) {
  std::vector<float> values(rows.vertices.size());
  base::for_indices(values.size(), [&](std::size_t row) { values[row] = measure_of(value(rows.vertices[row])); });
  page.arrays.push_back({layer + "/point/" + name, 1, std::move(values)});
}

/// Adds the arrays of one component among `measures`, row r of them for vertex v where row_of(v) = r; infinite where
/// their flag (`unburned`, `curve_unburned`) is set.
void add_measures(Page& page, const std::string& layer, const std::vector<DataArray>& measures, const LayerRows& rows,
                  std::span<const std::uint32_t> row_of);

/// The measures of the fires on sheets and curves: calls add(name, value of vertex v) for each. `of`: a RefinedAxis or
/// a Skeleton; `on_curve`: per vertex, whether those of curves are defined. In the plane there is one fire, on curves.
template <class Times, class Add>
void each_fire_measure(const Times& of, const std::vector<char>& on_curve, const Add& add) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (of.plane) {
    add("burn_time", [&](std::uint32_t v) { return of.curve_burn_time[v]; });
    add("erosion_thickness", [&](std::uint32_t v) { return std::max(0.0, of.curve_burn_time[v] - of.radius[v]); });
    return;
  }
  add("burn_time", [&](std::uint32_t v) { return of.burn_time[v]; });
  add("erosion_thickness", [&](std::uint32_t v) { return std::max(0.0, of.burn_time[v] - of.radius[v]); });
  add("curve_burn_time", [&](std::uint32_t v) { return on_curve[v] ? of.curve_burn_time[v] : kNothing; });
  add("curve_erosion_thickness", [&](std::uint32_t v) {
    if (!on_curve[v]) return kNothing;
    if (std::isinf(of.curve_burn_time[v])) return std::numeric_limits<double>::infinity();
    return std::max(0.0, of.curve_burn_time[v] - of.burn_time[v]);
  });
}

/// A column as pages describe it, and its values as numbers.
PageColumn column_of(const char* table, const Table::Column& column, std::vector<float>& values);

void widen(Page& page, std::span<const Vec3> points);

/// Points as pages hold them, without the origin of the page.
std::vector<float> places_of(const Page& page, std::span<const Vec3> points);

/// Faces in decreasing order of level, and the floor at which no more than `budget` triangles are left: 0 when all fit,
/// else the least float above the level of those that do not. Faces below are not in the list.
struct Floor {
  std::vector<std::uint32_t> faces;
  std::size_t triangles = 0;
  float level = 0;
};
class FacesByLevel {
 public:
  FacesByLevel(const CellComplex& complex, const std::vector<float>& face_level);
  Floor within(std::size_t budget) const;
  std::vector<std::uint32_t> order() && { return std::move(order_); }  ///< all faces

 private:
  const CellComplex& complex_;
  const std::vector<float>& level_;
  std::vector<std::uint32_t> order_;
};

/// Merges the vertices of each cube of a grid, as fine as `max_triangles` allows; for display only. Cells that become
/// degenerate or duplicate are left out; `kept`: per new vertex one of the old ones it stands for. `finest`: side of
/// the cubes to begin with; 0: as the area suggests.
Record clustered(const Record& data, std::size_t max_triangles, std::vector<std::uint32_t>& kept, double finest = 0);

std::size_t triangle_count(const Record& data);

/// "1.5 million", "120,000": a count in a sentence.
std::string count_text(std::size_t count);

/// " (NAME)", where the front end has a name for the limit.
std::string limit_text(const Page& page);
/// A length in a sentence: "0.31 mm".
std::string length_text(const Page& page, double length);
/// What a page shows begins there: "= 0.31 mm", or "> 0" for the smallest number above it.
std::string floor_text(const Page& page, double floor);

}  // namespace quench::page
