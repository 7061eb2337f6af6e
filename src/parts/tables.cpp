// SPDX-License-Identifier: Apache-2.0
#include <numeric>
#include <type_traits>
#include <utility>

#include "quench/parts.h"

namespace quench {
namespace {

class PartColumns {
 public:
  explicit PartColumns(std::vector<std::uint32_t> rows) : rows_(std::move(rows)) { table_.rows = rows_.size(); }

  template <class Get>
  void add(std::string name, std::string unit, std::string meaning, const Get& get) {
    using T = std::decay_t<decltype(get(0u))>;
    using Value = std::conditional_t<std::is_integral_v<T>, std::int64_t, T>;
    std::vector<Value> values;
    values.reserve(rows_.size());
    for (const std::uint32_t row : rows_) values.push_back(static_cast<Value>(get(row)));
    table_.columns.push_back({std::move(name), std::move(unit), std::move(meaning), std::move(values)});
  }
  template <class Point>
  void add_point(const std::string& name, const std::string& unit, const std::string& meaning, const Point& point) {
    for (int k = 0; k < 3; ++k)
      add(name + "_" + "xyz"[k], unit, meaning + ": " + "xyz"[k] + ".", [&](std::uint32_t i) { return point(i)[k]; });
  }
  Table take() { return std::move(table_); }

 private:
  std::vector<std::uint32_t> rows_;
  Table table_;
};

std::vector<std::uint32_t> all_rows(std::size_t count) {
  std::vector<std::uint32_t> rows(count);
  std::iota(rows.begin(), rows.end(), 0u);
  return rows;
}

std::string numbers_text(const std::vector<std::uint32_t>& numbers) {
  std::string text;
  for (const std::uint32_t n : numbers) {
    if (!text.empty()) text += ' ';
    text += std::to_string(n);
  }
  return text;
}

std::string area_unit(const std::string& unit) { return unit.empty() ? unit : unit + "^2"; }

}  // namespace

Table sheet_table(const Parts& parts, const std::string& unit) {
  PartColumns columns(parts.by_area());
  const auto of = [&](std::uint32_t i) -> const Sheet& { return parts.sheets[i]; };
  const auto number = [&](const char* name, const std::string& in, const char* meaning, double Sheet::*value) {
    columns.add(name, in, meaning, [&](std::uint32_t i) { return of(i).*value; });
  };
  columns.add("sheet", "", "Number of the sheet, as in the array `sheet` of files.", [](std::uint32_t i) { return i; });
  columns.add("component", "", "Connected component it is part of.", [&](std::uint32_t i) { return of(i).component; });
  columns.add("faces", "", "Polygons of the medial axis.", [&](std::uint32_t i) { return of(i).faces; });
  number("area", area_unit(unit), "Area.", &Sheet::area);
  number("mean_thickness", unit, "Thickness, 2 r, mean by area.", &Sheet::mean_thickness);
  number("min_thickness", unit, "The least.", &Sheet::min_thickness);
  number("max_thickness", unit, "The largest.", &Sheet::max_thickness);
  number("mean_erosion_thickness", unit, "Erosion thickness, mean by area.", &Sheet::mean_erosion);
  number("max_erosion_thickness", unit, "The largest.", &Sheet::max_erosion);
  columns.add("boundary_length", unit, "Length of rims and seams around it.",
              [&](std::uint32_t i) { return of(i).boundary_length(); });
  number("rim_length", unit, "Of it where the sheet ends.", &Sheet::rim_length);
  number("seam_length", unit, "Of it along seams.", &Sheet::seam_length);
  columns.add("borders", "", "Closed curves around it; 0: it is closed.",
              [&](std::uint32_t i) { return of(i).borders; });
  columns.add("euler", "", "Euler characteristic, cut off along seams: 1 of a disk.",
              [&](std::uint32_t i) { return of(i).euler; });
  columns.add("orientable", "", "1: it has two sides.",
              [&](std::uint32_t i) { return static_cast<int>(of(i).orientable); });
  columns.add_point("centre", unit, "Centre of area", [&](std::uint32_t i) { return of(i).centre; });
  columns.add_point("normal", "", "Across the fitted plane", [&](std::uint32_t i) { return of(i).normal; });
  number("flatness", unit, "Root of the mean squared distance to that plane.", &Sheet::flatness);
  number("largest_off", unit, "Largest distance to it.", &Sheet::largest_off);
  columns.add("seams", "", "Seams it meets.", [&](std::uint32_t i) { return numbers_text(of(i).seams); });
  columns.add("neighbours", "", "Sheets it meets there.",
              [&](std::uint32_t i) { return numbers_text(of(i).neighbours); });
  return columns.take();
}

Table seam_table(const Parts& parts, const std::string& unit) {
  PartColumns columns(all_rows(parts.seams.size()));
  const auto of = [&](std::uint32_t i) -> const Seam& { return parts.seams[i]; };
  const auto end = [](std::uint32_t junction) { return junction == kNone ? std::int64_t{-1} : std::int64_t{junction}; };
  columns.add("seam", "", "Number of the seam, as in the array `seam` of files.", [](std::uint32_t i) { return i; });
  columns.add("edges", "", "Edges of the medial axis.", [&](std::uint32_t i) { return of(i).edges; });
  columns.add("length", unit, "Length.", [&](std::uint32_t i) { return of(i).length; });
  columns.add("mean_thickness", unit, "Thickness, 2 r, mean by length.",
              [&](std::uint32_t i) { return of(i).mean_thickness; });
  columns.add("min_thickness", unit, "The least.", [&](std::uint32_t i) { return of(i).min_thickness; });
  columns.add("max_thickness", unit, "The largest.", [&](std::uint32_t i) { return of(i).max_thickness; });
  columns.add("closed", "", "1: it is a loop without junction.",
              [&](std::uint32_t i) { return static_cast<int>(of(i).closed); });
  columns.add("from", "", "Junction where it begins; -1 of a closed one.",
              [&](std::uint32_t i) { return end(of(i).ends[0]); });
  columns.add("to", "", "Junction where it ends.", [&](std::uint32_t i) { return end(of(i).ends[1]); });
  columns.add("sheets", "", "Sheets that meet there, each as often as it does.",
              [&](std::uint32_t i) { return numbers_text(of(i).sheets); });
  return columns.take();
}

Table junction_table(const Parts& parts, const std::string& unit) {
  PartColumns columns(all_rows(parts.junctions.size()));
  const auto of = [&](std::uint32_t i) -> const Junction& { return parts.junctions[i]; };
  columns.add("junction", "", "Number of the junction.", [](std::uint32_t i) { return i; });
  for (int k = 0; k < 3; ++k)
    columns.add(std::string(1, "xyz"[k]), unit, "Where it is.", [&](std::uint32_t i) { return of(i).point[k]; });
  columns.add("thickness", unit, "Thickness, 2 r.", [&](std::uint32_t i) { return of(i).thickness; });
  columns.add("seams", "", "Seams that meet there.", [&](std::uint32_t i) { return numbers_text(of(i).seams); });
  columns.add("sheets", "", "Sheets that meet there.", [&](std::uint32_t i) { return numbers_text(of(i).sheets); });
  return columns.take();
}

}  // namespace quench
