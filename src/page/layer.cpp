// SPDX-License-Identifier: Apache-2.0
#include "page/layer.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>

#include "quench/error.h"

namespace quench::page {

void widen(Page& page, std::span<const Vec3> points) {
  if (points.empty()) return;
  if (page.low == page.high) page.low = page.high = points[0];
  for (const Vec3& p : points) {
    page.low = page.low.cwiseMin(p);
    page.high = page.high.cwiseMax(p);
  }
}

std::vector<float> places_of(const Page& page, std::span<const Vec3> points) {
  std::vector<float> places(3 * points.size());
  base::for_indices(points.size(), [&](std::size_t row) {
    for (int a = 0; a < 3; ++a)
      places[3 * row + static_cast<std::size_t>(a)] = static_cast<float>(points[row][a] - page.origin[a]);
  });
  return places;
}

namespace {

void number_rows(const std::vector<char>& shown, std::vector<std::uint32_t>& row_of,
                 std::vector<std::uint32_t>& cell_of) {
  row_of.assign(shown.size(), kNone);
  for (std::uint32_t cell = 0; cell < shown.size(); ++cell)
    if (shown[cell]) {
      row_of[cell] = static_cast<std::uint32_t>(cell_of.size());
      cell_of.push_back(cell);
    }
}

}  // namespace

LayerRows add_layer(Page& page, const std::string& layer, const CellComplex& complex, std::span<const Vec3> points,
                    const LayerCells& cells) {
  const auto add = [&](const std::string& name, int components, PageArray::Values values) {
    page.arrays.push_back({layer + "/" + name, components, std::move(values)});
  };
  const auto add_levels = [&](const std::string& array, std::vector<float> Levels::*of,
                              const std::vector<std::uint32_t>& shown) {
    for (const Levels& levels : cells.levels) {
      std::vector<float> values(shown.size());
      base::for_indices(shown.size(), [&](std::size_t row) { values[row] = (levels.*of)[shown[row]]; });
      add(&levels == &cells.levels.front() ? array : array + "/" + levels.name, 1, std::move(values));
    }
  };
  LayerRows rows;
  number_rows(cells.vertex, rows.vertex, rows.vertices);
  number_rows(cells.edge, rows.edge, rows.edges);
  std::vector<Vec3> shown(rows.vertices.size());
  base::for_indices(shown.size(), [&](std::size_t row) { shown[row] = points[rows.vertices[row]]; });
  widen(page, shown);
  add("points", 3, places_of(page, shown));
  add_levels("vertex_level", &Levels::vertex, rows.vertices);

  std::vector<std::uint32_t> ends(2 * rows.edges.size());
  base::for_indices(rows.edges.size(), [&](std::size_t row) {
    const auto [a, b] = complex.edges[rows.edges[row]];
    ends[2 * row] = rows.vertex[a];
    ends[2 * row + 1] = rows.vertex[b];
  });
  add("edges", 2, std::move(ends));
  add_levels("edge_level", &Levels::edge, rows.edges);

  std::vector<std::uint32_t> offsets(cells.faces.size() + 1, 0);
  for (std::size_t row = 0; row < cells.faces.size(); ++row)
    offsets[row + 1] = offsets[row] + static_cast<std::uint32_t>(complex.corners(cells.faces[row]).size());
  std::vector<std::uint32_t> corners(offsets.back()), sides(offsets.back());
  base::for_indices(cells.faces.size(), [&](std::size_t row) {
    const auto v = complex.corners(cells.faces[row]), e = complex.sides(cells.faces[row]);
    for (std::size_t i = 0; i < v.size(); ++i) {
      corners[offsets[row] + i] = rows.vertex[v[i]];
      sides[offsets[row] + i] = rows.edge[e[i]];
    }
  });
  add("polygon_offsets", 1, std::move(offsets));
  add("polygon_corners", 1, std::move(corners));
  add("polygon_edges", 1, std::move(sides));
  add_levels("face_level", &Levels::face, cells.faces);
  return rows;
}

void add_measures(Page& page, const std::string& layer, const std::vector<DataArray>& measures, const LayerRows& rows,
                  std::span<const std::uint32_t> row_of) {
  const auto flags = [&](const char* name) {
    const DataArray* array = find_array(measures, name);
    return array && array->components == 1 ? array->numbers() : std::vector<double>();
  };
  const std::vector<double> unburned = flags("unburned"), curve_unburned = flags("curve_unburned");
  for (const DataArray& array : measures) {
    if (array.components != 1 || std::holds_alternative<std::vector<std::string>>(array.values)) continue;
    if (array.name == "voxel_radius") continue;  // radius says it better
    if (array.name == "unburned" || array.name == "curve_unburned") continue;
    const std::vector<double>* flag = nullptr;
    if (array.name == "burn_time" || array.name == "erosion_thickness") flag = &unburned;
    if (array.name == "curve_burn_time" || array.name == "curve_erosion_thickness") flag = &curve_unburned;
    const std::vector<double> values = array.numbers();
    const std::size_t last = row_of.empty() ? rows.vertex.size() : *std::max_element(row_of.begin(), row_of.end()) + 1;
    if (values.size() < last)
      throw Error(ErrorCode::usage, fmt::format("the measure '{}' of a page has {} values for {} vertices", array.name,
                                                values.size(), last));
    add_measure(page, layer, array.name, rows, [&](std::uint32_t v) {
      const std::uint32_t row = row_of.empty() ? v : row_of[v];
      if (flag && row < flag->size() && (*flag)[row] != 0) return std::numeric_limits<double>::infinity();
      return values[row];
    });
  }
}

FacesByLevel::FacesByLevel(const CellComplex& complex, const std::vector<float>& face_level)
    : complex_(complex), level_(face_level) {
  // Levels are not negative, so their bits are in their order.
  std::vector<std::uint64_t> keys(complex.face_count());
  base::for_indices(
      keys.size(), [&](std::size_t f) { keys[f] = std::uint64_t{~std::bit_cast<std::uint32_t>(level_[f])} << 32 | f; });
  tbb::parallel_sort(keys.begin(), keys.end());
  order_.resize(keys.size());
  base::for_indices(keys.size(), [&](std::size_t i) { order_[i] = static_cast<std::uint32_t>(keys[i]); });
}

Floor FacesByLevel::within(std::size_t budget) const {
  Floor floor;
  std::size_t kept = 0;
  while (kept < order_.size()) {
    // Faces of one level are kept or left out together; those of infinite level are always kept.
    const float level = level_[order_[kept]];
    std::size_t end = kept, more = 0;
    for (; end < order_.size() && level_[order_[end]] == level; ++end) more += complex_.corners(order_[end]).size() - 2;
    if (floor.triangles + more > budget && std::isfinite(level)) {
      floor.level = std::nextafter(level, std::numeric_limits<float>::infinity());
      break;
    }
    floor.triangles += more;
    kept = end;
  }
  floor.faces.assign(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(kept));
  return floor;
}

std::string count_text(std::size_t count) {
  if (count >= 950'000) return fmt::format("{:.3g} million", static_cast<double>(count) / 1e6);
  if (count >= 1000) return fmt::format("{},{:03}", count / 1000, count % 1000);
  return std::to_string(count);
}

std::string limit_text(const Page& page) {
  return page.limit_name.empty() ? std::string() : fmt::format(" ({})", page.limit_name);
}

std::string floor_text(const Page& page, double floor) {
  return floor < std::numeric_limits<float>::min() ? "> 0" : "= " + length_text(page, floor);
}

std::string length_text(const Page& page, double length) {
  return fmt::format("{:.4g}{}{}", length, page.unit.empty() ? "" : " ", page.unit);
}

}  // namespace quench::page
