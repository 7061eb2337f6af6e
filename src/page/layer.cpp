// SPDX-License-Identifier: Apache-2.0
#include "page/layer.h"

#include <fmt/format.h>

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

LayerRows add_layer(Page& page, const std::string& layer, const CellComplex& complex, std::span<const Vec3> points,
                    const LayerCells& cells) {
  LayerRows rows;
  rows.vertex.assign(complex.vertex_count, kNone);
  rows.edge.assign(complex.edges.size(), kNone);
  const auto add = [&](const std::string& name, int components, PageArray::Values values) {
    page.arrays.push_back({layer + "/" + name, components, std::move(values)});
  };
  const auto add_levels = [&](const std::string& array, std::vector<float> Levels::*of, const auto& each_shown) {
    for (const Levels& levels : cells.levels) {
      std::vector<float> values;
      each_shown([&](std::uint32_t cell) { values.push_back((levels.*of)[cell]); });
      add(&levels == &cells.levels.front() ? array : array + "/" + levels.name, 1, std::move(values));
    }
  };
  const auto each_with_row = [](const std::vector<std::uint32_t>& row) {
    return [&row](const auto& visit) {
      for (std::uint32_t cell = 0; cell < row.size(); ++cell)
        if (row[cell] != kNone) visit(cell);
    };
  };
  std::vector<float> place;
  std::vector<Vec3> shown;
  for (std::uint32_t v = 0, row = 0; v < complex.vertex_count; ++v) {
    if (!cells.vertex[v]) continue;
    rows.vertex[v] = row++;
    shown.push_back(points[v]);
    for (int a = 0; a < 3; ++a) place.push_back(static_cast<float>(points[v][a] - page.origin[a]));
  }
  widen(page, shown);
  add("points", 3, std::move(place));
  add_levels("vertex_level", &Levels::vertex, each_with_row(rows.vertex));

  std::vector<std::uint32_t> ends;
  for (std::uint32_t e = 0, row = 0; e < complex.edges.size(); ++e) {
    if (!cells.edge[e]) continue;
    rows.edge[e] = row++;
    for (const std::uint32_t v : complex.edges[e]) ends.push_back(rows.vertex[v]);
  }
  add("edges", 2, std::move(ends));
  add_levels("edge_level", &Levels::edge, each_with_row(rows.edge));

  std::vector<std::uint32_t> offsets{0}, corners, sides;
  for (const std::uint32_t f : cells.faces) {
    for (const std::uint32_t v : complex.corners(f)) corners.push_back(rows.vertex[v]);
    for (const std::uint32_t e : complex.sides(f)) sides.push_back(rows.edge[e]);
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  add("polygon_offsets", 1, std::move(offsets));
  add("polygon_corners", 1, std::move(corners));
  add("polygon_edges", 1, std::move(sides));
  add_levels("face_level", &Levels::face, [&](const auto& visit) { std::ranges::for_each(cells.faces, visit); });
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
  for (std::uint32_t f = 0; f < keys.size(); ++f)
    keys[f] = std::uint64_t{~std::bit_cast<std::uint32_t>(level_[f])} << 32 | f;
  std::sort(keys.begin(), keys.end());
  order_.reserve(keys.size());
  for (const std::uint64_t key : keys) order_.push_back(static_cast<std::uint32_t>(key));
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
