// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "page/layer.h"
#include "quench/error.h"

namespace quench {
namespace {

// FacesByLevel sorts and compares them.
bool are_levels(const std::vector<double>& levels) {
  return std::ranges::all_of(levels, [](double level) { return level >= 0; });
}

// pruned() counts levels within 1e-12 below a threshold as equal.
std::vector<float> comparable(const std::vector<double>& levels) {
  std::vector<float> floats;
  floats.reserve(levels.size());
  for (const double level : levels) floats.push_back(base::rounded_down(level / (1 - 1e-12)));
  return floats;
}

// Where the slider of a measure begins; a note when that leaves something out.
double floor_of(Page& page, const std::string& measure, const page::Floor& floor, std::size_t faces) {
  const bool is_pruning = page.pruning && page.pruning->measure == measure;
  const double start = is_pruning ? static_cast<double>(base::rounded_down(page.pruning->threshold)) : 0;
  if (!(floor.level > start)) return start;
  page.notes.push_back(fmt::format(
      "The medial axis begins at {} {}, with {} of its {} faces: below, it has more triangles than the page "
      "holds{}",
      measure, page::floor_text(page, floor.level), page::count_text(floor.faces.size()), page::count_text(faces),
      page::limit_text(page)));
  return floor.level;
}

}  // namespace

std::size_t add_core(Page& page, const MedialAxis& axis, const std::vector<DataArray>& point_data,
                     std::size_t max_triangles) {
  const CellComplex& c = axis.complex;
  page::LayerCells cells;
  for (const Measure& measure : axis.measures) {
    const CellValues& level = measure.level;
    if (level.empty()) continue;
    if (!level.complete(c) || !are_levels(level.face) || !are_levels(level.edge) || !are_levels(level.vertex))
      throw Error(ErrorCode::usage, fmt::format("a page shows a medial axis with a level of {} for each of its cells; "
                                                "see prune_levels()",
                                                measure.name));
    cells.levels.push_back({measure.name, comparable(level.vertex), comparable(level.edge), comparable(level.face)});
  }
  if (cells.levels.empty())
    throw Error(ErrorCode::usage, "a page shows a medial axis with a level for each of its cells; see prune_levels()");
  // What is above the floor of one measure is there, so that the pruning by it is complete.
  cells.edge.assign(c.edges.size(), 0);
  cells.vertex.assign(c.vertex_count, 0);
  std::vector<char> face(c.face_count(), 0);
  page::FacesByLevel in_order(c, cells.levels.front().face);
  for (const page::Levels& levels : cells.levels) {
    const std::size_t share = max_triangles / cells.levels.size();
    const bool first = &levels == &cells.levels.front();
    const page::Floor floor = first ? in_order.within(share) : page::FacesByLevel(c, levels.face).within(share);
    for (const std::uint32_t f : floor.faces) face[f] = 1;
    for (std::size_t e = 0; e < levels.edge.size(); ++e) cells.edge[e] |= levels.edge[e] >= floor.level;
    for (std::size_t v = 0; v < levels.vertex.size(); ++v) cells.vertex[v] |= levels.vertex[v] >= floor.level;
    page.measures.push_back({levels.name, floor_of(page, levels.name, floor, c.face_count())});
  }
  cells.faces = std::move(in_order).order();
  std::erase_if(cells.faces, [&](std::uint32_t f) { return !face[f]; });
  const page::LayerRows rows = page::add_layer(page, "core", c, axis.points, cells);
  page::add_measures(page, "core", point_data, rows, {});
  std::size_t triangles = 0;
  for (const std::uint32_t f : cells.faces) triangles += c.corners(f).size() - 2;
  return triangles;
}

}  // namespace quench
