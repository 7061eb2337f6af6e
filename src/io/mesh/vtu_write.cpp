// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <ostream>

#include "io/common/formats.h"
#include "io/mesh/vtk_xml.h"

/// VTK XML UnstructuredGrid, as VTP files are written: points, lines, triangles and polygons as cells of one list, in
/// the order of the rows of cell arrays. Meshing programs (meshio, FEniCS, ...) read it.
namespace quench::io {
namespace {

constexpr std::uint8_t kVertex = 1, kLine = 3, kTriangle = 5, kPolygon = 7, kQuad = 9;

template <class Index>
void write_grid_cells(VtkXml& writer, pugi::xml_node piece, const Record& data) {
  std::vector<Index> corners, ends;
  std::vector<std::uint8_t> types;
  const auto end_cell = [&](std::uint8_t type) {
    ends.push_back(static_cast<Index>(corners.size()));
    types.push_back(type);
  };
  for (const std::uint32_t v : data.verts) {
    corners.push_back(static_cast<Index>(v));
    end_cell(kVertex);
  }
  for (const auto& [a, b] : data.lines) {
    corners.insert(corners.end(), {static_cast<Index>(a), static_cast<Index>(b)});
    end_cell(kLine);
  }
  for (std::size_t f = 0; f < data.poly_count(); ++f) {
    const std::size_t begin = data.poly_offsets[f], end = data.poly_offsets[f + 1];
    for (std::size_t c = begin; c < end; ++c) corners.push_back(static_cast<Index>(data.poly_corners[c]));
    end_cell(end - begin == 3 ? kTriangle : end - begin == 4 ? kQuad : kPolygon);
  }
  const pugi::xml_node node = piece.append_child("Cells");
  writer.array(node, "connectivity", 1, corners);
  writer.array(node, "offsets", 1, ends);
  writer.array(node, "types", 1, types);
}

}  // namespace

void write_vtu(std::ostream& out, const Record& data) {
  VtkXml writer("UnstructuredGrid");
  pugi::xml_node piece = writer.begin_piece(writer.root().append_child("UnstructuredGrid"), data);
  piece.append_attribute("NumberOfPoints") = static_cast<unsigned long long>(data.points.size());
  piece.append_attribute("NumberOfCells") = static_cast<unsigned long long>(data.cell_count());
  writer.point_data(piece, data);
  const pugi::xml_node cell_data = piece.append_child("CellData");
  for (const DataArray& array : data.cell_data) writer.array(cell_data, array);
  writer.points(piece, data);
  constexpr std::size_t kLargest = std::numeric_limits<std::int32_t>::max();
  if (data.points.size() < kLargest && data.poly_corners.size() + 2 * data.lines.size() + data.verts.size() < kLargest)
    write_grid_cells<std::int32_t>(writer, piece, data);
  else
    write_grid_cells<std::int64_t>(writer, piece, data);
  writer.write(out);
}

}  // namespace quench::io
