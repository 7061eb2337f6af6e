// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "page/layer.h"
#include "quench/error.h"

namespace quench {
namespace {

// FacesByLevel sorts and compares them.
bool are_levels(const std::vector<double>& levels) {
  return std::ranges::all_of(levels, [](double level) { return level >= 0; });
}

// pruned() counts levels within 1e-12 below lambda as equal.
std::vector<float> comparable(const std::vector<double>& levels) {
  std::vector<float> floats;
  floats.reserve(levels.size());
  for (const double level : levels) floats.push_back(page::rounded_down(level / (1 - 1e-12)));
  return floats;
}

}  // namespace

std::size_t add_core(Page& page, const MedialAxis& axis, const std::vector<DataArray>& measures,
                     std::size_t max_triangles) {
  if (axis.face_level.size() != axis.complex.face_count() || axis.edge_level.size() != axis.complex.edges.size() ||
      axis.vertex_level.size() != axis.complex.vertex_count || !are_levels(axis.face_level) ||
      !are_levels(axis.edge_level) || !are_levels(axis.vertex_level))
    throw Error(ErrorCode::usage, "a page shows a medial axis with a level for each of its cells; see prune_levels()");
  page::LayerCells cells;
  cells.face_level = comparable(axis.face_level);
  cells.edge_level = comparable(axis.edge_level);
  cells.vertex_level = comparable(axis.vertex_level);
  page::Floor floor = page::FacesByLevel(axis.complex, cells.face_level).within(max_triangles);
  cells.faces = std::move(floor.faces);
  for (const float level : cells.edge_level) cells.edge.push_back(level >= floor.level);
  for (const float level : cells.vertex_level) cells.vertex.push_back(level >= floor.level);
  const page::LayerRows rows = page::add_layer(page, "core", axis.complex, axis.points, cells);
  page::add_measures(page, "core", measures, rows, {});
  page.lambda_floor = page.lambda ? static_cast<double>(page::rounded_down(*page.lambda)) : 0;
  if (floor.level > *page.lambda_floor) {
    page.lambda_floor = floor.level;
    page.notes.push_back(
        fmt::format("The core is shown from lambda {} on, {} of its {} faces; thinner parts are left out of this "
                    "page{}",
                    page::floor_text(page, floor.level), page::count_text(cells.faces.size()),
                    page::count_text(axis.complex.face_count()), page::limit_text(page)));
  }
  return floor.triangles;
}

bool take_levels(MedialAxis& axis, const Record& data) {
  const DataArray* array = find_array(data.cell_data, "lambda_level");
  const CellComplex& c = axis.complex;
  if (!array || array->components != 1 || array->size() != data.cell_count() || c.face_count() != data.poly_count())
    return false;
  if (std::ranges::any_of(data.verts, [&](std::uint32_t v) { return v >= c.vertex_count; })) return false;
  for (const auto& [a, b] : data.lines)
    if (a == b) return false;
  std::vector<double> level = array->numbers();
  if (!are_levels(level)) return false;
  for (double& x : level)
    if (x >= kInfiniteLevelInFiles) x = std::numeric_limits<double>::infinity();
  // A cell that is not written has the largest level of those it is a side of (to_record).
  std::vector<double> vertex(c.vertex_count, 0), edge(c.edges.size(), 0);
  const auto raise = [](double& value, double by) { value = std::max(value, by); };
  const std::size_t lines = data.verts.size(), polys = lines + data.lines.size();
  for (std::size_t l = 0; l < data.lines.size(); ++l) {
    const std::array<std::uint32_t, 2> ends{std::min(data.lines[l][0], data.lines[l][1]),
                                            std::max(data.lines[l][0], data.lines[l][1])};
    const auto at = std::lower_bound(c.edges.begin(), c.edges.end(), ends);
    if (at == c.edges.end() || *at != ends) return false;
    raise(edge[static_cast<std::size_t>(at - c.edges.begin())], level[lines + l]);
  }
  for (std::size_t f = 0; f < c.face_count(); ++f)
    for (const std::uint32_t e : c.sides(f)) raise(edge[e], level[polys + f]);
  for (std::size_t v = 0; v < data.verts.size(); ++v) raise(vertex[data.verts[v]], level[v]);
  for (std::size_t e = 0; e < edge.size(); ++e)
    for (const std::uint32_t v : c.edges[e]) raise(vertex[v], edge[e]);
  axis.face_level.assign(level.begin() + static_cast<std::ptrdiff_t>(polys), level.end());
  axis.edge_level = std::move(edge);
  axis.vertex_level = std::move(vertex);
  return true;
}

}  // namespace quench
