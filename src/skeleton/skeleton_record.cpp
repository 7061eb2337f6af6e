// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/constants.h"
#include "base/union_find.h"
#include "quench/skeleton.h"
#include "quench/structure.h"
#include "record/infinite.h"

namespace quench {
namespace {

struct Line {
  std::uint32_t from, to, edge;
};

// The edges of every branch in a row, from its end with the smaller index, and of closed ones from their node, which
// comes before all points inside of branches.
void add_branches(const Skeleton& s, std::vector<Line>& lines) {
  std::vector<std::uint32_t> of_branches;
  for (std::uint32_t e = 0; e < s.edge_branch.size(); ++e)
    if (s.edge_branch[e] >= 0) of_branches.push_back(e);
  std::stable_sort(of_branches.begin(), of_branches.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return s.edge_branch[a] < s.edge_branch[b]; });
  using AtVertex = std::array<std::uint32_t, 2>;  // vertex, edge
  std::vector<AtVertex> at;
  for (std::size_t i = 0, next = 0; i < of_branches.size(); i = next) {
    at.clear();
    for (next = i; next < of_branches.size() && s.edge_branch[of_branches[next]] == s.edge_branch[of_branches[i]];
         ++next)
      for (const std::uint32_t v : s.complex.edges[of_branches[next]]) at.push_back({v, of_branches[next]});
    std::sort(at.begin(), at.end());
    const auto edges_at = [&](std::uint32_t v) {
      const auto first = std::lower_bound(at.begin(), at.end(), AtVertex{v, 0});
      return std::pair(first, std::find_if(first, at.end(), [v](const AtVertex& a) { return a[0] != v; }));
    };
    std::uint32_t v = at.front()[0], edge = at.front()[1];
    for (std::size_t k = 0; k + 1 < at.size() && edges_at(v).second - edges_at(v).first != 1; ++k) {
      const auto [first, last] = edges_at(at[k][0]);
      if (last - first == 1) v = at[k][0], edge = at[k][1];
    }
    for (std::size_t count = next - i; count > 0; --count) {
      const auto& [a, b] = s.complex.edges[edge];
      const std::uint32_t to = a == v ? b : a;
      lines.push_back({v, to, edge});
      v = to;
      for (auto [first, last] = edges_at(v); first != last; ++first)
        if ((*first)[1] != edge) {
          edge = (*first)[1];
          break;
        }
    }
  }
}

// Of a line that is not part of the medial curves, as topology needs it of a sheet, both are infinite.
std::array<double, 2> level_and_thickness(const Skeleton& s, std::uint32_t e) {
  if (std::isnan(s.edge_thickness[e])) return {base::kNever, base::kNever};
  return {s.edge_level[e], s.edge_thickness[e]};
}

}  // namespace

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
  std::vector<Line> lines;
  for (std::uint32_t e = 0; e < c.edges.size(); ++e)
    if (!has_face[e] && (s.edge_branch.empty() || s.edge_branch[e] < 0))
      lines.push_back({c.edges[e][0], c.edges[e][1], e});
  add_branches(s, lines);
  std::vector<std::int32_t> branch(data.verts.size(), -1);
  for (std::size_t i = 0, next = 0; i < lines.size(); i = next) {
    const std::int32_t b = s.edge_branch.empty() ? -1 : s.edge_branch[lines[i].edge];
    std::array<double, 2> most{0, 0};
    for (next = i; next < lines.size() && (next == i || (b >= 0 && s.edge_branch[lines[next].edge] == b)); ++next)
      for (const std::size_t k : {0, 1}) most[k] = std::max(most[k], level_and_thickness(s, lines[next].edge)[k]);
    for (std::size_t k = i; k < next; ++k) {
      data.lines.push_back({lines[k].from, lines[k].to});
      add(1, lines[k].from, kNever, most[0], 0, most[1]);
      branch.push_back(b);
    }
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
    // In the plane fire starts at the radius, which was measured anew where branches were smoothed.
    curve_et[v] = s.on_curve[v] && std::isinf(s.curve_burn_time[v]) ? kNever
                  : s.on_curve[v] ? std::max(0.0, s.curve_burn_time[v] - (s.plane ? s.radius[v] : s.burn_time[v]))
                                  : 0;
  }
  data.point_data.push_back({"radius", 1, s.radius});
  data.cell_data.push_back({"kind", 1, std::move(kind)});
  data.cell_data.push_back({"component", 1, std::move(cell_component)});
  if (s.edge_branch.size() == c.edges.size()) {
    branch.resize(data.cell_count(), -1);
    data.cell_data.push_back({"branch", 1, std::move(branch)});
  }
  if (s.plane) {
    data.point_data.push_back({"burn_time", 1, record::finite(curve_time)});
    data.point_data.push_back({"erosion_thickness", 1, record::finite(curve_et)});
    data.point_data.push_back({"unburned", 1, record::flags_of_infinite(curve_et)});
    if (!s.mgf.empty()) data.point_data.push_back({"mgf", 1, s.mgf});
    data.cell_data.push_back({"curve_level", 1, std::move(curve_level)});
    data.cell_data.push_back({"erosion_thickness", 1, record::finite(std::move(curve_thickness))});
    return data;
  }
  data.point_data.push_back({"burn_time", 1, record::finite(s.burn_time)});
  data.point_data.push_back({"erosion_thickness", 1, record::finite(et)});
  data.point_data.push_back({"unburned", 1, record::flags_of_infinite(s.burn_time)});
  data.point_data.push_back({"curve_burn_time", 1, record::finite(curve_time)});
  data.point_data.push_back({"curve_erosion_thickness", 1, record::finite(curve_et)});
  data.point_data.push_back({"curve_unburned", 1, record::flags_of_infinite(curve_et)});
  const Structure structure = structure_of(c);
  data.point_data.push_back({"seam", 1, structure.vertex_seam});
  data.point_data.push_back(
      {"junction", 1, std::vector<std::uint8_t>(structure.junction.begin(), structure.junction.end())});
  std::vector<std::int32_t> sheet(data.cell_count() - c.face_count(), -1);
  sheet.insert(sheet.end(), structure.face_sheet.begin(), structure.face_sheet.end());
  data.cell_data.push_back({"sheet", 1, std::move(sheet)});
  data.cell_data.push_back({"sheet_level", 1, std::move(sheet_level)});
  data.cell_data.push_back({"curve_level", 1, std::move(curve_level)});
  data.cell_data.push_back({"erosion_thickness", 1, record::finite(std::move(thickness))});
  data.cell_data.push_back({"curve_erosion_thickness", 1, record::finite(std::move(curve_thickness))});
  return data;
}

}  // namespace quench
