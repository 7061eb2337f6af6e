// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "page/layer.h"
#include "record/mended_cells.h"

namespace quench {
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
        fmt::format("The file has {} triangles; the page draws {}, with vertices close to each other merged{}",
                    page::count_text(given), page::count_text(page::triangle_count(fewer)), page::limit_text(page)));
  }
  const Record& drawn = simplify ? fewer : data;
  record::MendedCells mended = record::mended_cells(drawn);
  const CellComplex complex = make_complex(static_cast<std::uint32_t>(drawn.points.size()), mended.lines,
                                           std::move(mended.offsets), std::move(mended.corners));
  page::LayerCells cells;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f) cells.faces.push_back(f);
  cells.edge.assign(complex.edges.size(), 1);
  cells.vertex.assign(complex.vertex_count, 1);
  const page::LayerRows rows = page::add_layer(page, "still", complex, drawn.points, cells);
  page::add_measures(page, "still", data.point_data, rows, row_of);
  return page::triangle_count(drawn);
}

}  // namespace quench
