// SPDX-License-Identifier: Apache-2.0
#include "quench/record.h"

#include <fmt/format.h>

#include <type_traits>

#include "base/text.h"
#include "quench/error.h"

namespace quench {

std::vector<double> DataArray::numbers() const {
  return std::visit(
      [&](const auto& v) -> std::vector<double> {
        using T = typename std::decay_t<decltype(v)>::value_type;
        if constexpr (std::is_same_v<T, std::string>)
          throw Error(ErrorCode::input,
                      fmt::format("the array '{}' holds text where numbers are needed", base::plain(name)));
        else
          return {v.begin(), v.end()};
      },
      values);
}

const DataArray* find_array(const std::vector<DataArray>& arrays, std::string_view name) {
  for (const DataArray& array : arrays)
    if (array.name == name) return &array;
  return nullptr;
}

void Record::validate() const {
  const auto fail = [](const std::string& what) { throw Error(ErrorCode::invariant, "poly data: " + what); };
  for (std::uint32_t v : verts)
    if (v >= points.size()) fail(fmt::format("a vertex cell refers to point {} of {}", v, points.size()));
  for (const auto& line : lines)
    for (std::uint32_t v : line)
      if (v >= points.size()) fail(fmt::format("a line refers to point {} of {}", v, points.size()));
  if (poly_offsets.empty() || poly_offsets.front() != 0 || poly_offsets.back() != poly_corners.size())
    fail("polygon offsets do not span the corners");
  for (std::size_t p = 0; p + 1 < poly_offsets.size(); ++p)
    if (poly_offsets[p] > poly_offsets[p + 1]) fail(fmt::format("offsets of polygon {} decrease", p));
  for (std::uint32_t v : poly_corners)
    if (v >= points.size()) fail(fmt::format("a polygon refers to point {} of {}", v, points.size()));
  const auto lengths = [&](const std::vector<DataArray>& arrays, std::size_t rows, const char* kind) {
    for (const DataArray& array : arrays)
      if (array.components < 1 || array.size() != rows * static_cast<std::size_t>(array.components))
        fail(fmt::format("the {} array '{}' has {} values for {} rows of {}", kind, array.name, array.size(), rows,
                         array.components));
  };
  lengths(point_data, points.size(), "point");
  lengths(cell_data, cell_count(), "cell");
}

TriangleMesh to_triangle_mesh(const Record& data) {
  TriangleMesh mesh;
  mesh.points = data.points;
  for (std::size_t p = 0; p < data.poly_count(); ++p)
    for (std::uint32_t c = data.poly_offsets[p] + 2; c < data.poly_offsets[p + 1]; ++c)
      mesh.triangles.push_back(
          {data.poly_corners[data.poly_offsets[p]], data.poly_corners[c - 1], data.poly_corners[c]});
  return mesh;
}

Record to_record(const TriangleMesh& mesh) {
  Record data;
  data.points = mesh.points;
  data.poly_corners.reserve(3 * mesh.triangles.size());
  data.poly_offsets.reserve(mesh.triangles.size() + 1);
  for (const auto& t : mesh.triangles) {
    data.poly_corners.insert(data.poly_corners.end(), t.begin(), t.end());
    data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
  }
  return data;
}

}  // namespace quench
