// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <utility>

#include "parts/cut_sheets.h"
#include "quench/parts.h"
#include "record/infinite.h"

namespace quench {
namespace {

// `of[i]`: the point of the mesh that is row i.
void add_point_arrays(Record& data, const SheetMesh& mesh, const std::vector<std::uint32_t>& of,
                      const PartsOptions& options) {
  const auto take = [&](const std::vector<double>& values) {
    std::vector<double> rows;
    rows.reserve(of.size());
    for (const std::uint32_t v : of) rows.push_back(values[v]);
    return rows;
  };
  std::vector<double> radius = take(mesh.radius), thickness = radius;
  for (double& t : thickness) t = 2 * (t + options.more_radius);
  data.point_data.push_back({"radius", 1, std::move(radius)});
  data.point_data.push_back({"thickness", 1, std::move(thickness)});
  if (!mesh.erosion.empty()) data.point_data.push_back({"erosion_thickness", 1, record::finite(take(mesh.erosion))});
}

}  // namespace

std::vector<Record> sheet_records(const SheetMesh& mesh, const PartsOptions& options) {
  const std::vector<parts::TriangleSide> sides = parts::sorted_sides(mesh.triangles);
  const parts::CutSheets cut = parts::cut_sheets(mesh.triangles, sides);
  std::int32_t sheets = 0;
  for (const std::int32_t s : mesh.sheet) sheets = std::max(sheets, s + 1);
  std::vector<Record> records(static_cast<std::size_t>(sheets));
  std::vector<std::vector<std::uint32_t>> of(records.size());  // per point of a record: that of the mesh
  std::vector<std::uint32_t> row(cut.vertices, kNone);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto s = static_cast<std::size_t>(mesh.sheet[t]);
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& place = row[cut.vertex[3 * t + i]];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(of[s].size());
        of[s].push_back(mesh.triangles[t][i]);
        records[s].points.push_back(mesh.points[mesh.triangles[t][i]]);
      }
      records[s].poly_corners.push_back(place);
    }
    records[s].poly_offsets.push_back(static_cast<std::uint32_t>(records[s].poly_corners.size()));
  }
  for (std::size_t s = 0; s < records.size(); ++s) {
    add_point_arrays(records[s], mesh, of[s], options);
    records[s].point_data.push_back({"point", 1, std::vector<std::int64_t>(of[s].begin(), of[s].end())});
  }
  return records;
}

Record to_record(const SheetMesh& mesh, const PartsOptions& options) {
  Record data;
  data.points = mesh.points;
  std::vector<std::uint32_t> of(mesh.points.size());
  for (std::uint32_t v = 0; v < of.size(); ++v) of[v] = v;
  add_point_arrays(data, mesh, of, options);
  data.lines = mesh.seam_edges;
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t t) { return mesh.sheet[t]; });
  std::vector<std::int32_t> sheet(mesh.seam_edges.size(), -1), seam = mesh.seam;
  for (const std::uint32_t t : order) {
    const auto& corners = mesh.triangles[t];
    data.poly_corners.insert(data.poly_corners.end(), corners.begin(), corners.end());
    data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
    sheet.push_back(mesh.sheet[t]);
  }
  seam.resize(sheet.size(), -1);
  data.cell_data.push_back({"sheet", 1, std::move(sheet)});
  data.cell_data.push_back({"seam", 1, std::move(seam)});
  return data;
}

}  // namespace quench
