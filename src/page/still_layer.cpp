// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "page/layer.h"

namespace quench {
namespace {

/// The cells as a complex on all points: corners that repeat the one before are left out, and a polygon of which fewer
/// than three are left is a line or a point.
CellComplex complex_to_draw(const Record& data) {
  std::vector<std::array<std::uint32_t, 2>> lines;
  for (const auto& line : data.lines)
    if (line[0] != line[1]) lines.push_back(line);
  std::vector<std::uint32_t> offsets{0}, corners, own;
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    own.assign(data.poly_corners.begin() + data.poly_offsets[p], data.poly_corners.begin() + data.poly_offsets[p + 1]);
    own.erase(std::unique(own.begin(), own.end()), own.end());
    while (own.size() > 1 && own.front() == own.back()) own.pop_back();
    if (own.size() > 2) {
      corners.insert(corners.end(), own.begin(), own.end());
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    } else if (own.size() == 2) {
      lines.push_back({own[0], own[1]});
    }
  }
  return make_complex(static_cast<std::uint32_t>(data.points.size()), lines, std::move(offsets), std::move(corners));
}

}  // namespace

std::size_t page::triangle_count(const Record& data) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    const std::uint32_t corners = data.poly_offsets[p + 1] - data.poly_offsets[p];
    if (corners > 2) count += corners - 2;
  }
  return count;
}

std::size_t add_still(Page& page, const Record& data, std::size_t max_triangles) {
  const std::size_t given = page::triangle_count(data);
  const bool simplify = given > max_triangles;
  std::vector<std::uint32_t> row_of;
  Record fewer;
  if (simplify) {
    fewer = page::clustered(data, max_triangles, row_of);
    page.notes.push_back(
        fmt::format("Of its {} triangles {} are drawn: vertices close to each other are merged in "
                    "this page{}",
                    page::count_text(given), page::count_text(page::triangle_count(fewer)), page::limit_text(page)));
  }
  const Record& drawn = simplify ? fewer : data;
  const CellComplex complex = complex_to_draw(drawn);
  page::LayerCells cells;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f) cells.faces.push_back(f);
  cells.edge.assign(complex.edges.size(), 1);
  cells.vertex.assign(complex.vertex_count, 1);
  const page::LayerRows rows = page::add_layer(page, "still", complex, drawn.points, cells);
  page::add_measures(page, "still", data.point_data, rows, row_of);
  return page::triangle_count(drawn);
}

}  // namespace quench
