// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "axis/measures.h"
#include "axis/top_cells.h"
#include "base/union_find.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/geometry.h"
#include "record/mended_cells.h"

namespace quench {
namespace {

// Cells of the file in the order verts, lines, polys: which vertices, edges and faces of the complex they are.
struct WrittenCells {
  std::vector<std::uint32_t> vertices, edges;
  std::vector<char> vertex_has_edge, edge_has_face;
};

// The largest of the values of the faces at each edge; -1 where there are none.
std::vector<double> largest_of_faces(const CellComplex& complex, const std::vector<double>& face) {
  std::vector<double> largest(complex.edges.size(), -1);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t e : complex.sides(f)) largest[e] = std::max(largest[e], face[f]);
  return largest;
}

// Marks the edges and vertices that do not follow from the larger cells around them.
void mark_cells_to_write(const CellComplex& complex, const Measure& measure, std::vector<char>& vertex,
                         std::vector<char>& edge) {
  const auto mark_edges = [&](const CellValues& values, const auto& differ) {
    const std::vector<double> from_faces = largest_of_faces(complex, values.face);
    for (std::size_t e = 0; e < complex.edges.size(); ++e)
      if (differ(from_faces[e], values.edge[e])) edge[e] = 1;
  };
  const CellValues& level = measure.level;
  if (!level.empty()) {
    mark_edges(level, std::less{});
    std::vector<double> from_edges(complex.vertex_count, -1);
    for (std::size_t e = 0; e < complex.edges.size(); ++e)
      for (std::uint32_t v : complex.edges[e]) from_edges[v] = std::max(from_edges[v], level.edge[e]);
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
      if (from_edges[v] < level.vertex[v]) vertex[v] = 1;
  }
  if (measure.name != kLambda && !measure.value.empty()) mark_edges(measure.value, std::not_equal_to{});
}

WrittenCells cells_to_write(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  WrittenCells cells;
  cells.vertex_has_edge.assign(complex.vertex_count, 0);
  cells.edge_has_face.assign(complex.edges.size(), 0);
  for (const auto& ends : complex.edges)
    for (std::uint32_t v : ends) cells.vertex_has_edge[v] = 1;
  for (std::uint32_t e : complex.face_edges) cells.edge_has_face[e] = 1;
  std::vector<char> vertex(complex.vertex_count), edge(complex.edges.size());
  std::ranges::transform(cells.vertex_has_edge, vertex.begin(), std::logical_not{});
  std::ranges::transform(cells.edge_has_face, edge.begin(), std::logical_not{});
  for (const Measure& measure : axis.measures) mark_cells_to_write(complex, measure, vertex, edge);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    if (vertex[v]) cells.vertices.push_back(v);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (edge[e]) cells.edges.push_back(e);
  return cells;
}

// A cell array of doubles over the written cells.
DataArray cell_array(std::string name, const WrittenCells& cells, const CellValues& of) {
  std::vector<double> values;
  values.reserve(cells.vertices.size() + cells.edges.size() + of.face.size());
  for (std::uint32_t v : cells.vertices) values.push_back(of.vertex[v]);
  for (std::uint32_t e : cells.edges) values.push_back(of.edge[e]);
  values.insert(values.end(), of.face.begin(), of.face.end());
  for (double& x : values) x = std::min(x, kInfiniteLevelInFiles);
  return {std::move(name), 1, std::move(values)};
}

// The arrays of a measure that is derived here.
struct DerivedArrays {
  DataArray cells, points;
};
template <class Number>
DerivedArrays arrays_of(const axis::DerivedMeasure& derived, const WrittenCells& cells, const CellValues& of) {
  const auto number = [](double x) { return static_cast<Number>(x); };
  std::vector<Number> values, points(of.vertex.size());
  values.reserve(cells.vertices.size() + cells.edges.size() + of.face.size());
  for (const std::uint32_t v : cells.vertices) values.push_back(number(of.vertex[v]));
  for (const std::uint32_t e : cells.edges) values.push_back(number(of.edge[e]));
  std::ranges::transform(of.face, std::back_inserter(values), number);
  std::ranges::transform(of.vertex, points.begin(), number);
  const std::string name(derived.name);
  return {{name, 1, std::move(values)}, {name, 1, std::move(points)}};
}
DerivedArrays arrays_of(const axis::DerivedMeasure& derived, const WrittenCells& cells, const MedialAxis& axis) {
  const CellValues values = derived.values(axis, axis.measure(derived.from).value);
  return derived.is_length ? arrays_of<double>(derived, cells, values) : arrays_of<float>(derived, cells, values);
}

// One of the two sites of each face, in a plane of each edge; -1 for other cells. 32 bits, unless that makes an index
// negative.
DataArray site_array(const char* name, const WrittenCells& cells, const MedialAxis& axis, std::size_t which) {
  const auto& sites_of = axis::top_sites(axis);
  const bool plane = axis.grid.is_plane();
  const std::size_t faces = axis.complex.face_count(), all = cells.vertices.size() + cells.edges.size() + faces;
  // Where the cells that have sites begin: in a plane all edges are written.
  const std::size_t first = cells.vertices.size() + (plane ? 0 : cells.edges.size());
  const bool known = sites_of.size() == (plane ? axis.complex.edges.size() : faces) && !axis.sites.empty();
  const auto array = [&](auto none) -> DataArray {
    std::vector<decltype(none)> values(all, none);
    for (std::size_t i = 0; known && i < sites_of.size(); ++i)
      values[first + i] = static_cast<decltype(none)>(sites_of[i][which]);
    return {name, 1, std::move(values)};
  };
  constexpr auto kMost = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
  const bool fits = std::ranges::all_of(sites_of, [&](const auto& sites) { return sites[which] <= kMost; });
  return fits ? array(std::int32_t{-1}) : array(std::int64_t{-1});
}

std::vector<std::int32_t> components_of(const CellComplex& complex) {
  base::UnionFind sets(complex.vertex_count);
  for (const auto& e : complex.edges) sets.unite(e[0], e[1]);
  std::vector<std::int32_t> component(complex.vertex_count);
  std::int32_t count = 0;
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)  // roots come first: they are the smallest of their set
    component[v] = sets.find(v) == v ? count++ : component[sets.find(v)];
  return component;
}

// Names are those of arrays that are not written otherwise; values per cell are there for all cells or for none.
void check_measures(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  if (axis.points.size() != complex.vertex_count || axis.radius.size() != complex.vertex_count)
    throw Error(ErrorCode::usage, "a medial axis needs a point and a radius for each vertex");
  std::vector<std::string> names{"", "radius", "voxel_point", "voxel_radius", "kind", "component", "site_a", "site_b"};
  const auto take_name = [&](const std::string& name) {
    if (std::ranges::find(names, name) != names.end())
      throw Error(
          ErrorCode::usage,
          fmt::format("a measure of a medial axis cannot have the name '{}': it is empty or another array has it",
                      name));
    names.push_back(name);
  };
  for (const Measure& m : axis.measures) take_name(m.name);
  for (const Measure& m : axis.measures) {
    take_name(m.name + "_level");
    for (const CellValues* values : {&m.value, &m.level})
      if (!values->empty() && !values->complete(complex))
        throw Error(ErrorCode::usage,
                    fmt::format("a medial axis needs a {} and a level of it for all cells or for none", m.name));
  }
}

// The derived measures that the axis does not have already.
std::vector<axis::DerivedMeasure> measures_to_derive(const MedialAxis& axis) {
  std::vector<axis::DerivedMeasure> list = axis::derivable(axis);
  std::erase_if(list, [&](const axis::DerivedMeasure& derived) { return axis.find_measure(derived.name); });
  return list;
}

// What the two sites of faces are, and where they lie.
void add_sites(Record& data, const MedialAxis& axis, const WrittenCells& cells) {
  data.cell_data.push_back(site_array("site_a", cells, axis, 0));
  data.cell_data.push_back(site_array("site_b", cells, axis, 1));
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
  if (g.is_plane()) data.field_data.push_back({"dimension", 1, std::vector<std::int64_t>{g.dimension}});
}

// What may be taken from an axis that is not needed any more is moved, after what is computed from it.
template <class Axis>
Record record_of(Axis&& axis) {
  check_measures(axis);
  const CellComplex& complex = axis.complex;
  const WrittenCells cells = cells_to_write(axis);
  Record data;
  data.verts = cells.vertices;
  for (std::uint32_t e : cells.edges) data.lines.push_back(complex.edges[e]);

  const std::vector<std::int32_t> component_of = components_of(complex);
  std::vector<std::uint8_t> kind;
  std::vector<std::int32_t> component;
  const auto add = [&](std::uint8_t k, std::uint32_t vertex) {
    kind.push_back(k);
    component.push_back(component_of[vertex]);
  };
  for (std::uint32_t v : cells.vertices) add(cells.vertex_has_edge[v] ? 0 : 2, v);
  for (std::uint32_t e : cells.edges) add(cells.edge_has_face[e] ? 0 : 1, complex.edges[e][0]);
  for (std::size_t f = 0; f < complex.face_count(); ++f) add(0, complex.corners(f)[0]);
  data.cell_data.push_back({"kind", 1, std::move(kind)});
  data.cell_data.push_back({"component", 1, std::move(component)});
  std::vector<std::string> names;
  for (const Measure& m : axis.measures) {
    if (!m.value.empty()) data.cell_data.push_back(cell_array(m.name, cells, m.value));
    if (!m.level.empty()) data.cell_data.push_back(cell_array(m.name + "_level", cells, m.level));
    if (!m.value.empty() || !m.level.empty()) names.push_back(m.name);
  }
  std::vector<DataArray> derived_of_points;
  for (const axis::DerivedMeasure& derived : measures_to_derive(axis)) {
    DerivedArrays arrays = arrays_of(derived, cells, axis);
    data.cell_data.push_back(std::move(arrays.cells));
    derived_of_points.push_back(std::move(arrays.points));
    names.emplace_back(derived.name);
  }
  if (const Measure* lambda = axis.find_measure(kLambda); lambda && !lambda->value.empty())
    add_sites(data, axis, cells);
  data.field_data.push_back({"format_version", 1, std::vector<std::int64_t>{kFormatVersion}});
  if (!names.empty()) data.field_data.push_back({"measures", 1, std::move(names)});
  data.points = std::forward<Axis>(axis).points;
  data.poly_offsets = std::forward<Axis>(axis).complex.face_offsets;
  data.poly_corners = std::forward<Axis>(axis).complex.face_vertices;
  data.point_data.push_back({"radius", 1, std::forward<Axis>(axis).radius});
  if (axis.is_fitted()) {
    std::vector<double> coordinates;
    coordinates.reserve(3 * axis.voxel_points.size());
    for (const Vec3& p : axis.voxel_points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
    data.point_data.push_back({"voxel_point", 3, std::move(coordinates)});
    data.point_data.push_back({"voxel_radius", 1, std::forward<Axis>(axis).voxel_radius});
    data.field_data.push_back({"surface", 1, std::vector<std::string>{std::string(name_of(axis.surface))}});
  }
  for (auto& m : axis.measures)  // copied where the axis is const
    if (!m.value.vertex.empty()) data.point_data.push_back({m.name, 1, std::move(m.value.vertex)});
  std::ranges::move(derived_of_points, std::back_inserter(data.point_data));
  return data;
}

}  // namespace

Record to_record(const MedialAxis& axis) { return record_of(axis); }

Record to_record(MedialAxis&& axis) {
  Record data = record_of(std::move(axis));
  axis = {};
  return data;
}

CellComplex complex_of(const Record& data, std::vector<std::uint32_t>* point_of) {
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

namespace {

// Removes polygons with the corners of an earlier one, in any order.
std::size_t drop_duplicates(std::vector<std::uint32_t>& offsets, std::vector<std::uint32_t>& corners) {
  const std::size_t faces = offsets.size() - 1;
  std::vector<std::uint32_t> sorted = corners;
  std::vector<std::uint64_t> hash(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    std::sort(sorted.begin() + offsets[f], sorted.begin() + offsets[f + 1]);
    std::uint64_t h = offsets[f + 1] - offsets[f];
    for (std::uint32_t c = offsets[f]; c < offsets[f + 1]; ++c) h = (h ^ sorted[c]) * 0x9E3779B97F4A7C15ull;
    hash[f] = h;
  }
  std::vector<std::uint32_t> order(faces);
  std::iota(order.begin(), order.end(), 0u);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    if (hash[a] != hash[b]) return hash[a] < hash[b];
    return std::lexicographical_compare(sorted.begin() + offsets[a], sorted.begin() + offsets[a + 1],
                                        sorted.begin() + offsets[b], sorted.begin() + offsets[b + 1]);
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return less(a, b) || (!less(b, a) && a < b); });
  std::vector<char> drop(faces, 0);
  std::size_t dropped = 0;
  for (std::size_t i = 1; i < faces; ++i)
    if (!less(order[i - 1], order[i])) {
      drop[order[i]] = 1;
      ++dropped;
    }
  if (dropped == 0) return 0;
  std::vector<std::uint32_t> kept_offsets{0}, kept;
  for (std::size_t f = 0; f < faces; ++f) {
    if (drop[f]) continue;
    kept.insert(kept.end(), corners.begin() + offsets[f], corners.begin() + offsets[f + 1]);
    kept_offsets.push_back(static_cast<std::uint32_t>(kept.size()));
  }
  offsets = std::move(kept_offsets);
  corners = std::move(kept);
  return dropped;
}

// What fit_to_surface() has left of the voxel core, where the file has all of it.
void take_voxel_geometry(MedialAxis& axis, const Record& data) {
  const DataArray *name = find_array(data.field_data, "surface"), *point = find_array(data.point_data, "voxel_point"),
                  *radius = find_array(data.point_data, "voxel_radius");
  const auto* text = name ? std::get_if<std::vector<std::string>>(&name->values) : nullptr;
  if (!text || text->size() != 1 || !point || point->components != 3 || !radius || radius->components != 1) return;
  const std::optional<SurfaceKind> kind = surface_kind_of(text->front());
  if (!kind || point->size() != 3 * data.points.size() || radius->size() != data.points.size()) return;
  const std::vector<double> at = point->numbers();
  axis.surface = *kind;
  axis.voxel_radius = radius->numbers();
  axis.voxel_points.resize(data.points.size());
  for (std::size_t v = 0; v < data.points.size(); ++v)
    axis.voxel_points[v] = Vec3(at[3 * v], at[3 * v + 1], at[3 * v + 2]);
}

bool is_plane(const Record& data) {
  const DataArray* dimension = find_array(data.field_data, "dimension");
  return dimension && dimension->size() == 1 && !std::holds_alternative<std::vector<std::string>>(dimension->values) &&
         dimension->numbers()[0] == 2 && data.poly_count() == 0;
}

void check_lengths(const MedialAxis& axis) {
  for (std::size_t v = 0; v < axis.points.size(); ++v) {
    const double r = axis.radius[v], farthest = axis.points[v].cwiseAbs().maxCoeff();
    if (!(r >= 0 && r <= kLargestLength))
      throw Error(ErrorCode::input,
                  fmt::format("the radius of vertex {} is {}; radii are numbers from 0 to {}", v, r, kLargestLength));
    if (!(farthest <= kLargestLength))
      throw Error(ErrorCode::input,
                  fmt::format("vertex {} is {} from 0 along an axis; coordinates are numbers up to {}", v, farthest,
                              kLargestLength));
  }
}

}  // namespace

MedialAxis medial_axis_of(const Record& data, AxisRepair* repair) {
  AxisRepair mended;
  const DataArray* radius = find_array(data.point_data, "radius");
  if (!radius || radius->components != 1)
    throw Error(ErrorCode::input, "there is no radius per vertex (a point array 'radius'); give a .r file of radii",
                "radii");
  MedialAxis axis;
  axis.points = data.points;
  axis.radius = radius->numbers();
  if (is_plane(data)) axis.grid.make_plane();
  check_lengths(axis);
  take_voxel_geometry(axis, data);
  record::MendedCells cells = record::mended_cells(data);
  mended.degenerate = cells.degenerate;
  mended.duplicate = drop_duplicates(cells.offsets, cells.corners);
  axis.complex = make_complex(static_cast<std::uint32_t>(data.points.size()), cells.lines, std::move(cells.offsets),
                              std::move(cells.corners));
  if (repair) *repair = mended;
  return axis;
}

namespace {

// The names of the measures of a file.
std::vector<std::string> measures_of(const Record& data) {
  const DataArray* names = find_array(data.field_data, "measures");
  if (!names) return {std::string(kLambda)};
  const auto* texts = std::get_if<std::vector<std::string>>(&names->values);
  return texts ? *texts : std::vector<std::string>{};
}

// The edges that are the lines of the file. None when one of them is not in the complex.
std::optional<std::vector<std::uint32_t>> edges_of_lines(const CellComplex& complex, const Record& data) {
  std::vector<std::uint32_t> edges;
  edges.reserve(data.lines.size());
  for (const auto& line : data.lines) {
    const std::array<std::uint32_t, 2> ends{std::min(line[0], line[1]), std::max(line[0], line[1])};
    const auto at = std::ranges::lower_bound(complex.edges, ends);
    if (at == complex.edges.end() || *at != ends) return {};
    edges.push_back(static_cast<std::uint32_t>(at - complex.edges.begin()));
  }
  return edges;
}

// Levels of all cells from those of the cells of the file: one that is not written has the largest level of those it is
// a side of (to_record).
CellValues levels_of(const CellComplex& complex, const Record& data, const std::vector<std::uint32_t>& line_edges,
                     const std::vector<double>& level) {
  CellValues all;
  all.vertex.assign(complex.vertex_count, 0);
  all.edge.assign(complex.edges.size(), 0);
  const auto raise = [](double& value, double by) { value = std::max(value, by); };
  const std::size_t lines = data.verts.size(), polys = lines + data.lines.size();
  for (std::size_t l = 0; l < line_edges.size(); ++l) raise(all.edge[line_edges[l]], level[lines + l]);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) raise(all.edge[e], level[polys + f]);
  for (std::size_t v = 0; v < data.verts.size(); ++v) raise(all.vertex[data.verts[v]], level[v]);
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    for (const std::uint32_t v : complex.edges[e]) raise(all.vertex[v], all.edge[e]);
  all.face.assign(level.begin() + static_cast<std::ptrdiff_t>(polys), level.end());
  return all;
}

}  // namespace

bool take_levels(MedialAxis& axis, const Record& data) {
  const CellComplex& complex = axis.complex;
  const auto outside = [&](std::uint32_t v) { return v >= complex.vertex_count; };
  if (complex.face_count() != data.poly_count() || std::ranges::any_of(data.verts, outside)) return false;
  const auto line_edges = edges_of_lines(complex, data);
  if (!line_edges) return false;
  bool taken = false;
  for (const std::string& name : measures_of(data)) {
    const DataArray* array = find_array(data.cell_data, name + "_level");
    if (!array || array->components != 1 || array->size() != data.cell_count()) continue;
    std::vector<double> level = array->numbers();
    if (!std::ranges::all_of(level, [](double x) { return x >= 0; })) continue;
    for (double& x : level)
      if (x >= kInfiniteLevelInFiles) x = std::numeric_limits<double>::infinity();
    if (!axis.find_measure(name)) axis.measures.push_back({name, {}, {}});
    axis.measure(name).level = levels_of(complex, data, *line_edges, level);
    taken = true;
  }
  return taken;
}

}  // namespace quench
