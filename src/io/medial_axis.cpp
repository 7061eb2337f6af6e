// SPDX-License-Identifier: Apache-2.0
#include "quench/medial_axis.h"

#include <algorithm>
#include <limits>

#include "complex/union_find.h"

namespace quench {
namespace {

// Cells of the file in the order verts, lines, polys: which vertices, edges and faces of the complex they are.
struct WrittenCells {
  std::vector<std::uint32_t> vertices, edges;
  std::vector<char> vertex_has_edge, edge_has_face;
};

WrittenCells cells_to_write(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  const bool levels = !axis.vertex_level.empty();
  WrittenCells cells;
  cells.vertex_has_edge.assign(complex.vertex_count, 0);
  cells.edge_has_face.assign(complex.edges.size(), 0);
  std::vector<double> from_edges(complex.vertex_count, -1), from_faces(complex.edges.size(), -1);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t e : complex.sides(f)) {
      cells.edge_has_face[e] = 1;
      from_faces[e] = std::max(from_faces[e], levels ? axis.face_level[f] : 0);
    }
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    for (std::uint32_t v : complex.edges[e]) {
      cells.vertex_has_edge[v] = 1;
      from_edges[v] = std::max(from_edges[v], levels ? axis.edge_level[e] : 0);
    }
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    if (from_edges[v] < (levels ? axis.vertex_level[v] : 0)) cells.vertices.push_back(v);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (from_faces[e] < (levels ? axis.edge_level[e] : 0)) cells.edges.push_back(e);
  return cells;
}

// A cell array of doubles over the written cells, from values per vertex, edge and face.
DataArray cell_array(const char* name, const WrittenCells& cells, const std::vector<double>& vertex,
                     const std::vector<double>& edge, const std::vector<double>& face) {
  std::vector<double> values;
  values.reserve(cells.vertices.size() + cells.edges.size() + face.size());
  for (std::uint32_t v : cells.vertices) values.push_back(vertex[v]);
  for (std::uint32_t e : cells.edges) values.push_back(edge[e]);
  values.insert(values.end(), face.begin(), face.end());
  for (double& x : values) x = std::min(x, kInfiniteLevelInFiles);
  return {name, 1, std::move(values)};
}

std::vector<std::int32_t> components_of(const CellComplex& complex) {
  UnionFind sets(complex.vertex_count);
  for (const auto& e : complex.edges) sets.unite(e[0], e[1]);
  std::vector<std::int32_t> component(complex.vertex_count);
  std::int32_t count = 0;
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)  // roots come first: they are the smallest of their set
    component[v] = sets.find(v) == v ? count++ : component[sets.find(v)];
  return component;
}

}  // namespace

PolyData to_poly_data(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  const WrittenCells cells = cells_to_write(axis);
  PolyData data;
  data.points = axis.points;
  data.verts = cells.vertices;
  for (std::uint32_t e : cells.edges) data.lines.push_back(complex.edges[e]);
  data.poly_offsets = complex.face_offsets;
  data.poly_corners = complex.face_vertices;

  data.point_data.push_back({"radius", 1, axis.radius});
  if (!axis.vertex_lambda.empty()) data.point_data.push_back({"lambda", 1, axis.vertex_lambda});

  const std::vector<std::int32_t> component_of = components_of(complex);
  std::vector<std::uint8_t> kind;
  std::vector<std::int32_t> component, site_a, site_b;
  const auto add = [&](std::uint8_t k, std::uint32_t vertex, std::int32_t a, std::int32_t b) {
    kind.push_back(k);
    component.push_back(component_of[vertex]);
    site_a.push_back(a);
    site_b.push_back(b);
  };
  for (std::uint32_t v : cells.vertices) add(cells.vertex_has_edge[v] ? 0 : 2, v, -1, -1);
  for (std::uint32_t e : cells.edges) add(cells.edge_has_face[e] ? 0 : 1, complex.edges[e][0], -1, -1);
  const bool sites = axis.face_sites.size() == complex.face_count() && !axis.sites.empty();
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    add(0, complex.corners(f)[0], sites ? static_cast<std::int32_t>(axis.face_sites[f][0]) : -1,
        sites ? static_cast<std::int32_t>(axis.face_sites[f][1]) : -1);
  data.cell_data.push_back({"kind", 1, std::move(kind)});
  data.cell_data.push_back({"component", 1, std::move(component)});
  if (!axis.face_lambda.empty() || !axis.vertex_lambda.empty())
    data.cell_data.push_back(cell_array("lambda", cells, axis.vertex_lambda, axis.edge_lambda, axis.face_lambda));
  if (!axis.vertex_level.empty())
    data.cell_data.push_back(cell_array("lambda_level", cells, axis.vertex_level, axis.edge_level, axis.face_level));
  if (!axis.vertex_lambda.empty()) {  // a core of ours
    data.cell_data.push_back({"site_a", 1, std::move(site_a)});
    data.cell_data.push_back({"site_b", 1, std::move(site_b)});
    std::vector<std::int32_t> triples;
    triples.reserve(axis.sites.size() * 3);
    for (const LatticePoint& s : axis.sites) triples.insert(triples.end(), s.begin(), s.end());
    data.field_data.push_back({"sites", 3, std::move(triples)});
    const Grid& g = axis.grid;
    data.field_data.push_back({"dims", 3, std::vector<std::int64_t>(g.dims.begin(), g.dims.end())});
    data.field_data.push_back({"spacing", 3, std::vector<double>(g.spacing.data(), g.spacing.data() + 3)});
    data.field_data.push_back({"origin", 3, std::vector<double>(g.origin.data(), g.origin.data() + 3)});
    std::vector<double> rows;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) rows.push_back(g.direction(r, c));
    data.field_data.push_back({"direction", 9, std::move(rows)});
  }
  return data;
}

CellComplex complex_of(const PolyData& data, std::vector<std::uint32_t>* point_of) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> vertex_of(data.points.size(), kUnused);
  const auto use = [&](std::uint32_t p) { vertex_of[p] = 0; };
  for (std::uint32_t v : data.verts) use(v);
  for (const auto& line : data.lines)
    for (std::uint32_t v : line) use(v);
  for (std::uint32_t v : data.poly_corners) use(v);
  std::uint32_t count = 0;
  if (point_of) point_of->clear();
  for (std::uint32_t p = 0; p < vertex_of.size(); ++p)
    if (vertex_of[p] != kUnused) {
      vertex_of[p] = count++;
      if (point_of) point_of->push_back(p);
    }
  std::vector<std::array<std::uint32_t, 2>> lines = data.lines;
  for (auto& line : lines)
    for (auto& v : line) v = vertex_of[v];
  std::vector<std::uint32_t> corners = data.poly_corners;
  for (auto& v : corners) v = vertex_of[v];
  return make_complex(count, lines, data.poly_offsets, std::move(corners));
}

}  // namespace quench
