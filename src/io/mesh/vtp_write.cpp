// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <ostream>
#include <type_traits>

#include "io/common/formats.h"
#include "io/mesh/vtk_xml.h"

/// VTK XML PolyData, version 1.0: XML that describes the arrays, then their bytes, compressed by zlib, as one appended
/// raw section. VTK and ParaView read it without loss.
namespace quench::io {
namespace {

/// Where the polylines begin in the lines, and the number of lines: lines that continue each other and are of one
/// `branch`, whose rows of all cell arrays are then the same, become one; others stay as they are.
std::vector<std::size_t> polylines_of(const Record& data) {
  const DataArray* array = find_array(data.cell_data, "branch");
  const auto* branch = array ? std::get_if<std::vector<std::int32_t>>(&array->values) : nullptr;
  const std::size_t first_row = data.verts.size();
  const auto same_rows = [&](std::size_t a, std::size_t b) {
    return std::ranges::all_of(data.cell_data, [&](const DataArray& values) {
      const auto n = static_cast<std::size_t>(values.components);
      return std::visit(
          [&](const auto& v) {
            const auto at = [&](std::size_t row) { return v.begin() + static_cast<std::ptrdiff_t>(n * row); };
            return std::equal(at(a), at(a + 1), at(b));
          },
          values.values);
    });
  };
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < data.lines.size(); ++i)
    if (i == 0 || !branch || (*branch)[first_row + i] < 0 || data.lines[i - 1][1] != data.lines[i][0] ||
        !same_rows(first_row + i - 1, first_row + i))
      begins.push_back(i);
  begins.push_back(data.lines.size());
  return begins;
}

/// The array with one row for every polyline.
DataArray rows_of_polylines(const DataArray& array, const Record& data, const std::vector<std::size_t>& polylines) {
  DataArray result{array.name, array.components, {}};
  std::visit(
      [&](const auto& values) {
        const auto n = static_cast<std::size_t>(array.components);
        std::decay_t<decltype(values)> rows;
        const auto take = [&](std::size_t begin, std::size_t end) {
          rows.insert(rows.end(), values.begin() + static_cast<std::ptrdiff_t>(n * begin),
                      values.begin() + static_cast<std::ptrdiff_t>(n * end));
        };
        const std::size_t first = data.verts.size();
        take(0, first);
        for (std::size_t i = 0; i + 1 < polylines.size(); ++i) take(first + polylines[i], first + polylines[i] + 1);
        take(first + data.lines.size(), data.cell_count());
        result.values = std::move(rows);
      },
      array.values);
  return result;
}

/// Cells of one kind: their corners, and where each ends.
template <class Index>
void write_cells(VtkXml& writer, pugi::xml_node piece, const Record& data, const std::vector<std::size_t>& polylines) {
  const auto cells = [&](const char* kind, const std::vector<Index>& corners, const std::vector<Index>& ends) {
    const pugi::xml_node node = piece.append_child(kind);
    writer.array(node, "connectivity", 1, corners);
    writer.array(node, "offsets", 1, ends);
  };
  std::vector<Index> corners(data.verts.begin(), data.verts.end()), ends;
  for (std::size_t i = 1; i <= data.verts.size(); ++i) ends.push_back(static_cast<Index>(i));
  cells("Verts", corners, ends);
  corners.clear();
  ends.clear();
  for (std::size_t p = 0; p + 1 < polylines.size(); ++p) {
    corners.push_back(static_cast<Index>(data.lines[polylines[p]][0]));
    for (std::size_t i = polylines[p]; i < polylines[p + 1]; ++i)
      corners.push_back(static_cast<Index>(data.lines[i][1]));
    ends.push_back(static_cast<Index>(corners.size()));
  }
  cells("Lines", corners, ends);
  cells("Strips", {}, {});
  corners.assign(data.poly_corners.begin(), data.poly_corners.end());
  ends.assign(data.poly_offsets.begin() + 1, data.poly_offsets.end());
  cells("Polys", corners, ends);
}

}  // namespace

void write_vtp(std::ostream& out, const Record& data) {
  VtkXml writer("PolyData");
  pugi::xml_node piece = writer.begin_piece(writer.root().append_child("PolyData"), data);
  const auto count = [&](const char* name, std::size_t value) {
    piece.append_attribute(name) = static_cast<unsigned long long>(value);
  };
  count("NumberOfPoints", data.points.size());
  count("NumberOfVerts", data.verts.size());
  const std::vector<std::size_t> polylines = polylines_of(data);
  count("NumberOfLines", polylines.size() - 1);
  count("NumberOfStrips", 0);
  count("NumberOfPolys", data.poly_count());

  writer.point_data(piece, data);
  const pugi::xml_node cell_data = piece.append_child("CellData");
  const bool merged = polylines.size() - 1 < data.lines.size();
  for (const DataArray& array : data.cell_data)
    writer.array(cell_data, merged ? rows_of_polylines(array, data, polylines) : array);

  writer.points(piece, data);
  // The smaller indices halve the time to compress; VTK reads both.
  constexpr std::size_t kLargest = std::numeric_limits<std::int32_t>::max();
  if (data.points.size() < kLargest && data.poly_corners.size() < kLargest && data.lines.size() < kLargest / 2)
    write_cells<std::int32_t>(writer, piece, data, polylines);
  else
    write_cells<std::int64_t>(writer, piece, data, polylines);
  writer.write(out);
}

}  // namespace quench::io
