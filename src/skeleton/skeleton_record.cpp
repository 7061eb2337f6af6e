// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/constants.h"
#include "base/union_find.h"
#include "quench/skeleton.h"
#include "record/infinite.h"

namespace quench {
Record to_record(const Skeleton& s) {
  const CellComplex& c = s.complex;
  Record data;
  data.points = s.points;
  std::vector<char> has_edge(c.vertex_count, 0), has_face(c.edges.size(), 0);
  for (const auto& e : c.edges)
    for (const std::uint32_t v : e) has_edge[v] = 1;
  for (const std::uint32_t e : c.face_edges) has_face[e] = 1;
  base::UnionFind sets(c.vertex_count);
  for (const auto& e : c.edges) sets.unite(e[0], e[1]);
  std::vector<std::int32_t> component(c.vertex_count);
  std::int32_t components = 0;
  for (std::uint32_t v = 0; v < c.vertex_count; ++v)
    component[v] = sets.find(v) == v ? components++ : component[sets.find(v)];

  std::vector<std::uint8_t> kind;
  std::vector<std::int32_t> cell_component;
  std::vector<double> sheet_level, curve_level, thickness, curve_thickness;
  const auto add = [&](std::uint8_t k, std::uint32_t vertex, double sheet, double curve, double et, double curve_et) {
    kind.push_back(k);
    cell_component.push_back(component[vertex]);
    sheet_level.push_back(std::min(sheet, kInfiniteLevelInFiles));
    curve_level.push_back(std::min(curve, kInfiniteLevelInFiles));
    thickness.push_back(et);
    curve_thickness.push_back(curve_et);
  };
  using base::kNever;
  for (std::uint32_t v = 0; v < c.vertex_count; ++v) {
    if (has_edge[v]) continue;
    data.verts.push_back(v);
    add(2, v, kNever, kNever, 0, 0);
  }
  for (std::uint32_t e = 0; e < c.edges.size(); ++e) {
    if (has_face[e]) continue;
    data.lines.push_back(c.edges[e]);
    // A line that is not part of the medial curves is what topology needs of a sheet.
    const bool curve = !std::isnan(s.edge_thickness[e]);
    add(1, c.edges[e][0], kNever, curve ? s.edge_level[e] : kNever, 0, curve ? s.edge_thickness[e] : kNever);
  }
  data.poly_offsets = c.face_offsets;
  data.poly_corners = c.face_vertices;
  for (std::size_t f = 0; f < c.face_count(); ++f)
    add(0, c.corners(f)[0], s.face_level[f], kNever, s.face_thickness[f], 0);

  std::vector<double> et(s.points.size()), curve_time(s.points.size()), curve_et(s.points.size());
  for (std::size_t v = 0; v < et.size(); ++v) {
    et[v] = std::max(0.0, s.burn_time[v] - s.radius[v]);
    // Off the curves the measures of curves are not defined; the time of the sheet keeps them continuous.
    curve_time[v] = s.on_curve[v] ? s.curve_burn_time[v] : s.burn_time[v];
    curve_et[v] = s.on_curve[v] && std::isinf(s.curve_burn_time[v]) ? kNever
                  : s.on_curve[v] ? std::max(0.0, s.curve_burn_time[v] - s.burn_time[v])
                                  : 0;
  }
  data.point_data.push_back({"radius", 1, s.radius});
  data.point_data.push_back({"burn_time", 1, record::finite(s.burn_time)});
  data.point_data.push_back({"erosion_thickness", 1, record::finite(et)});
  data.point_data.push_back({"unburned", 1, record::flags_of_infinite(s.burn_time)});
  data.point_data.push_back({"curve_burn_time", 1, record::finite(curve_time)});
  data.point_data.push_back({"curve_erosion_thickness", 1, record::finite(curve_et)});
  data.point_data.push_back({"curve_unburned", 1, record::flags_of_infinite(curve_et)});
  data.cell_data.push_back({"kind", 1, std::move(kind)});
  data.cell_data.push_back({"component", 1, std::move(cell_component)});
  data.cell_data.push_back({"sheet_level", 1, std::move(sheet_level)});
  data.cell_data.push_back({"curve_level", 1, std::move(curve_level)});
  data.cell_data.push_back({"erosion_thickness", 1, record::finite(std::move(thickness))});
  data.cell_data.push_back({"curve_erosion_thickness", 1, record::finite(std::move(curve_thickness))});
  return data;
}

}  // namespace quench
