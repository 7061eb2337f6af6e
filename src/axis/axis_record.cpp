// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/union_find.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/geometry.h"

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

// One of the two sites of each face, -1 for other cells. 32 bits, unless that makes an index negative.
DataArray site_array(const char* name, const WrittenCells& cells, const MedialAxis& axis, std::size_t which) {
  const std::size_t others = cells.vertices.size() + cells.edges.size(), faces = axis.complex.face_count();
  const bool known = axis.face_sites.size() == faces && !axis.sites.empty();
  const auto array = [&](auto none) -> DataArray {
    std::vector<decltype(none)> values(others + faces, none);
    for (std::size_t f = 0; known && f < faces; ++f)
      values[others + f] = static_cast<decltype(none)>(axis.face_sites[f][which]);
    return {name, 1, std::move(values)};
  };
  constexpr auto kMost = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
  const bool fits = std::ranges::all_of(axis.face_sites, [&](const auto& sites) { return sites[which] <= kMost; });
  return fits ? array(std::int32_t{-1}) : array(std::int64_t{-1});
}

// Angle at a point of radius r between nearest boundary points that are 2 lambda apart, in degrees.
double object_angle(double lambda, double r) {
  return r > 0 ? 2 * std::asin(std::min(1.0, lambda / r)) * (180 / std::numbers::pi) : 180;
}
// At the centre of a cell: the squared distance to a point is that of the corners, on average, less their spread.
double object_angle(const MedialAxis& axis, std::span<const std::uint32_t> corners, double lambda) {
  Vec3 centre = Vec3::Zero();
  for (const std::uint32_t v : corners) centre += axis.points[v];
  centre /= static_cast<double>(corners.size());
  double squared = 0;
  for (const std::uint32_t v : corners)
    squared += axis.radius[v] * axis.radius[v] - (axis.points[v] - centre).squaredNorm();
  return object_angle(lambda, std::sqrt(std::max(0.0, squared / static_cast<double>(corners.size()))));
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

// Values per cell are there for all cells or for none.
void check_sizes(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  const auto whole = [&](const std::vector<double>& vertex, const std::vector<double>& edge,
                         const std::vector<double>& face) {
    return (vertex.empty() && edge.empty() && face.empty()) ||
           (vertex.size() == complex.vertex_count && edge.size() == complex.edges.size() &&
            face.size() == complex.face_count());
  };
  if (axis.points.size() != complex.vertex_count || axis.radius.size() != complex.vertex_count ||
      !whole(axis.vertex_lambda, axis.edge_lambda, axis.face_lambda) ||
      !whole(axis.vertex_level, axis.edge_level, axis.face_level))
    throw Error(ErrorCode::usage,
                "a medial axis needs a point and a radius for each vertex, and a lambda and a level "
                "for all cells or for none");
}

// What may be taken from an axis that is not needed any more is moved, after what is computed from it.
template <class Axis>
Record record_of(Axis&& axis) {
  check_sizes(axis);
  const CellComplex& complex = axis.complex;
  const WrittenCells cells = cells_to_write(axis);
  Record data;
  data.verts = cells.vertices;
  for (std::uint32_t e : cells.edges) data.lines.push_back(complex.edges[e]);

  const bool measured = !axis.vertex_lambda.empty();
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
  if (!axis.face_lambda.empty() || !axis.vertex_lambda.empty())
    data.cell_data.push_back(cell_array("lambda", cells, axis.vertex_lambda, axis.edge_lambda, axis.face_lambda));
  if (!axis.vertex_level.empty())
    data.cell_data.push_back(cell_array("lambda_level", cells, axis.vertex_level, axis.edge_level, axis.face_level));
  if (measured) {  // a core of ours
    std::vector<float> angle;
    angle.reserve(cells.vertices.size() + cells.edges.size() + complex.face_count());
    const auto add_angle = [&](std::span<const std::uint32_t> corners, double lambda) {
      angle.push_back(static_cast<float>(object_angle(axis, corners, lambda)));
    };
    for (const std::uint32_t v : cells.vertices) add_angle({&v, 1}, axis.vertex_lambda[v]);
    for (const std::uint32_t e : cells.edges) add_angle(complex.edges[e], axis.edge_lambda[e]);
    for (std::size_t f = 0; f < complex.face_count(); ++f) add_angle(complex.corners(f), axis.face_lambda[f]);
    data.cell_data.push_back({"object_angle", 1, std::move(angle)});
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
  }
  std::vector<float> angle;
  if (measured) {
    angle.resize(complex.vertex_count);
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
      angle[v] = static_cast<float>(object_angle(axis.vertex_lambda[v], axis.radius[v]));
  }
  data.points = std::forward<Axis>(axis).points;
  data.poly_offsets = std::forward<Axis>(axis).complex.face_offsets;
  data.poly_corners = std::forward<Axis>(axis).complex.face_vertices;
  data.point_data.push_back({"radius", 1, std::forward<Axis>(axis).radius});
  if (measured) {
    data.point_data.push_back({"lambda", 1, std::forward<Axis>(axis).vertex_lambda});
    data.point_data.push_back({"object_angle", 1, std::move(angle)});
  }
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

}  // namespace

namespace {

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
  check_lengths(axis);
  std::vector<std::array<std::uint32_t, 2>> lines;
  for (const auto& line : data.lines)
    if (line[0] != line[1])
      lines.push_back(line);
    else
      ++mended.degenerate;
  // A polygon that repeats a corner: without the repetitions it is a smaller polygon, a line or a point. One that comes
  // back to a corner later is taken apart into its sides: nothing tells where its area is.
  std::vector<std::uint32_t> offsets{0}, corners, own;
  for (std::size_t f = 0; f < data.poly_count(); ++f) {
    own.assign(data.poly_corners.begin() + data.poly_offsets[f], data.poly_corners.begin() + data.poly_offsets[f + 1]);
    const std::size_t given = own.size();
    own.erase(std::unique(own.begin(), own.end()), own.end());
    while (own.size() > 1 && own.front() == own.back()) own.pop_back();
    std::vector<std::uint32_t> distinct = own;
    std::sort(distinct.begin(), distinct.end());
    const bool returns = std::adjacent_find(distinct.begin(), distinct.end()) != distinct.end();
    if (own.size() != given || own.size() < 3 || returns) ++mended.degenerate;
    if (own.size() >= 3 && !returns) {
      corners.insert(corners.end(), own.begin(), own.end());
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    } else {
      for (std::size_t i = 0; i < own.size(); ++i)
        if (const std::uint32_t a = own[i], b = own[(i + 1) % own.size()]; a != b) lines.push_back({a, b});
    }
  }
  mended.duplicate = drop_duplicates(offsets, corners);
  axis.complex =
      make_complex(static_cast<std::uint32_t>(data.points.size()), lines, std::move(offsets), std::move(corners));
  if (repair) *repair = mended;
  return axis;
}

}  // namespace quench
