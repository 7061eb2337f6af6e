// SPDX-License-Identifier: Apache-2.0
#include "picture/scene.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/parallel.h"
#include "picture/mesh_scene.h"
#include "picture/tree_scene.h"
#include "quench/error.h"

namespace quench::picture {
namespace {

using Indices = std::vector<std::uint32_t>;
using Floats = std::vector<float>;

template <class T>
const std::vector<T>& values_or_none(const Page& page, const std::string& name) {
  static const std::vector<T> kEmpty;
  const std::vector<T>* const found = find_values<T>(page, name);
  return found ? *found : kEmpty;
}

std::vector<Vec3f> places(const Page& page, const Placement& placement, const Floats& coordinates) {
  std::vector<Vec3f> points(coordinates.size() / 3);
  base::for_indices(points.size(), [&](std::size_t i) {
    const Vec3 world = page.origin + Vec3(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
    points[i] = placement.to_scene(world).cast<float>();
  });
  return points;
}

[[noreturn]] void refuse(const std::string& name) {
  throw Error(ErrorCode::usage, fmt::format("the array '{}' of a page does not fit its other arrays", name));
}

/// Numbers below `count`.
void require_below(const Page& page, const std::string& name, std::size_t count) {
  for (const std::uint32_t i : values_or_none<std::uint32_t>(page, name))
    if (i >= count) refuse(name);
}

/// Offsets into `rows` rows: from 0 up to that.
void require_offsets(const Page& page, const std::string& name, std::size_t rows) {
  const Indices& offsets = values_or_none<std::uint32_t>(page, name);
  if (offsets.empty()
          ? rows > 0
          : offsets.front() != 0 || offsets.back() != rows || !std::is_sorted(offsets.begin(), offsets.end()))
    refuse(name);
}

template <class T>
void require_size(const Page& page, const std::string& name, std::size_t size) {
  if (page.find(name) && values_or_none<T>(page, name).size() != size) refuse(name);
}

/// Throws Error(usage) unless all that is drawn of a layer is there and in range.
void require_layer(const Page& page, const ViewState& state) {
  const std::string layer = state.layer + "/";
  const auto rows = [&](const char* name) { return values_or_none<std::uint32_t>(page, layer + name).size(); };
  const std::size_t points = values_or_none<float>(page, layer + "points").size() / 3,
                    corners = rows("polygon_corners");
  const std::size_t faces = std::max<std::size_t>(1, rows("polygon_offsets")) - 1;
  require_offsets(page, layer + "polygon_offsets", corners);
  for (const char* name : {"polygon_corners", "edges", "branch_points", "isolated"})
    require_below(page, layer + name, points);
  require_size<float>(page, layer + "point/" + state.color, points);
  if (state.layer == "skeleton") {
    require_offsets(page, layer + "branch_offsets", rows("branch_points"));
    require_size<std::uint32_t>(page, layer + "polygon_sheet", faces);
    return;
  }
  const std::size_t edges = rows("edges") / 2;
  if (rows("polygon_edges") != corners) refuse(layer + "polygon_edges");
  require_below(page, layer + "polygon_edges", edges);
  if (state.layer != "core") return;
  for (const PageMeasure& measure : page.measures) {
    const std::string of = &measure == &page.measures.front() ? "" : "/" + measure.name;
    require_size<float>(page, layer + "face_level" + of, faces);
    require_size<float>(page, layer + "edge_level" + of, edges);
    require_size<float>(page, layer + "vertex_level" + of, points);
  }
}

/// The cells of a layer that are there: all, or those of a level.
class LayerCells {
 public:
  LayerCells(const Page& page, const ViewState& state)
      : layer_(state.layer),
        offsets_(values_or_none<std::uint32_t>(page, layer_ + "/polygon_offsets")),
        corners_(values_or_none<std::uint32_t>(page, layer_ + "/polygon_corners")),
        edges_(values_or_none<std::uint32_t>(page, layer_ + "/edges")),
        sides_(values_or_none<std::uint32_t>(page, layer_ + "/polygon_edges")) {
    if (layer_ != "core") return;
    threshold_ = state.threshold;
    const bool first = page.measures.empty() || page.measures.front().name == state.measure;
    const std::string of = first ? "" : "/" + state.measure;
    face_level_ = find_values<float>(page, "core/face_level" + of);
    edge_level_ = find_values<float>(page, "core/edge_level" + of);
    vertex_level_ = find_values<float>(page, "core/vertex_level" + of);
  }

  void add_to(Scene& scene) const {
    std::vector<char> used(scene.points.size(), 0);
    const std::vector<std::uint8_t> faces = add_faces(scene, used);
    for (std::size_t e = 0; 2 * e < edges_.size(); ++e) {
      if (!is_there(edge_level_, e)) continue;
      const std::array<std::uint32_t, 2> ends{edges_[2 * e], edges_[2 * e + 1]};
      for (const std::uint32_t v : ends) used[v] = 1;
      if (faces[e] == 0) scene.curves.push_back(ends);
      if (faces[e] == 1) scene.boundary.push_back(ends);
      if (faces[e] > 2) scene.seams.push_back(ends);
    }
    for (std::uint32_t v = 0; v < used.size(); ++v)
      if (!used[v] && is_there(vertex_level_, v)) scene.isolated.push_back(v);
  }

 private:
  bool is_there(const Floats* level, std::size_t cell) const { return !level || (*level)[cell] >= threshold_; }

  /// Returns the number of faces around each edge, of three and more 3.
  std::vector<std::uint8_t> add_faces(Scene& scene, std::vector<char>& used) const {
    std::vector<std::uint8_t> faces(edges_.size() / 2, 0);
    for (std::size_t f = 0; f + 1 < offsets_.size(); ++f) {
      if (!is_there(face_level_, f)) continue;
      for (std::uint32_t c = offsets_[f]; c < offsets_[f + 1]; ++c) {
        used[corners_[c]] = 1;
        scene.sheets.corners.push_back(corners_[c]);
        faces[sides_[c]] = static_cast<std::uint8_t>(std::min(3, faces[sides_[c]] + 1));
      }
      scene.sheets.offsets.push_back(static_cast<std::uint32_t>(scene.sheets.corners.size()));
    }
    return faces;
  }

  std::string layer_;
  const Indices &offsets_, &corners_, &edges_, &sides_;
  const Floats *face_level_ = nullptr, *edge_level_ = nullptr, *vertex_level_ = nullptr;
  double threshold_ = 0;
};

/// Edges of one polygon, and of three or more.
void add_edges_of_sheets(Scene& scene) {
  std::vector<std::uint64_t> edges(scene.sheets.corners.size());
  base::for_indices(scene.sheets.size(), [&](std::size_t f) {
    const std::uint32_t begin = scene.sheets.offsets[f], end = scene.sheets.offsets[f + 1];
    for (std::uint32_t c = begin; c < end; ++c) {
      const auto [a, b] = std::minmax(scene.sheets.corners[c], scene.sheets.corners[c + 1 < end ? c + 1 : begin]);
      edges[c] = std::uint64_t{a} << 32 | b;
    }
  });
  tbb::parallel_sort(edges.begin(), edges.end());
  for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
    while (next < edges.size() && edges[next] == edges[i]) ++next;
    const std::array<std::uint32_t, 2> ends{static_cast<std::uint32_t>(edges[i] >> 32),
                                            static_cast<std::uint32_t>(edges[i])};
    if (next - i == 1) scene.boundary.push_back(ends);
    if (next - i > 2) scene.seams.push_back(ends);
  }
}

Vec3f area_normal(const std::vector<Vec3f>& points, std::span<const std::uint32_t> corners) {
  Vec3f sum = Vec3f::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += (points[corners[i]] - points[corners[0]]).cross(points[corners[i + 1]] - points[corners[0]]);
  return sum / 2;
}

std::span<const std::uint32_t> corners_of(const Polygons& polygons, std::size_t f) {
  return std::span(polygons.corners).subspan(polygons.offsets[f], polygons.offsets[f + 1] - polygons.offsets[f]);
}

/// By their number: the largest sheets have colours of their own, and names in the legend. Or by a column of their
/// table.
void colour_sheets(const Page& page, const ViewState& state, Scene& scene) {
  const Indices& sheet = values_or_none<std::uint32_t>(page, "skeleton/polygon_sheet");
  if (sheet_column(page, state.color)) {
    const Floats& values = values_or_none<float>(page, state.color);
    for (const std::uint32_t s : sheet) {
      if (s >= values.size()) refuse(state.color);
      const float x = values[s];
      scene.sheet_values.push_back(std::isnan(x) ? kCodeMissing : std::isfinite(x) ? x : kCodeInfinite);
    }
  }
  if (state.color != "sheet" || sheet.empty()) return;
  std::vector<double> area(*std::ranges::max_element(sheet) + std::size_t{1}, 0);
  for (std::size_t f = 0; f < sheet.size(); ++f)
    area[sheet[f]] += area_normal(scene.points, corners_of(scene.sheets, f)).norm();
  Indices order, rank(area.size());
  for (std::uint32_t s = 0; s < area.size(); ++s) order.push_back(s);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });
  for (std::uint32_t place = 0; place < order.size(); ++place) {
    rank[order[place]] = place;
    if (place < kParts.size()) scene.part_names.emplace_back(fmt::format("sheet {}", order[place]), place);
  }
  for (const std::uint32_t s : sheet) scene.sheet_parts.push_back(rank[s]);
}

/// The skeleton that was asked for: polygons, and curves as branches.
void add_skeleton_cells(const Page& page, const ViewState& state, Scene& scene) {
  scene.sheets.offsets = values_or_none<std::uint32_t>(page, "skeleton/polygon_offsets");
  scene.sheets.corners = values_or_none<std::uint32_t>(page, "skeleton/polygon_corners");
  if (scene.sheets.offsets.empty()) scene.sheets.offsets = {0};
  const Indices& offsets = values_or_none<std::uint32_t>(page, "skeleton/branch_offsets");
  const Indices& along = values_or_none<std::uint32_t>(page, "skeleton/branch_points");
  for (std::uint32_t b = 0; b + 1 < offsets.size(); ++b)
    for (std::uint32_t i = offsets[b]; i + 1 < offsets[b + 1]; ++i) {
      scene.curves.push_back({along[i], along[i + 1]});
      if (state.color == "branch") scene.curve_parts.push_back(b);
    }
  colour_sheets(page, state, scene);
  scene.isolated = values_or_none<std::uint32_t>(page, "skeleton/isolated");
  add_edges_of_sheets(scene);
}

/// The sides of triangles that are not sides of others in the other direction: around what they cover, all in the same
/// sense. Where triangles overlap these are still closed.
std::vector<std::array<std::uint32_t, 2>> outline_of(const Indices& triangles) {
  std::vector<std::array<std::uint32_t, 3>> sides(triangles.size());  // the smaller end, the larger, the direction
  base::for_indices(sides.size(), [&](std::size_t i) {
    const std::uint32_t a = triangles[i], b = triangles[i % 3 == 2 ? i - 2 : i + 1];
    sides[i] = {std::min(a, b), std::max(a, b), a < b ? 1U : 0U};
  });
  tbb::parallel_sort(sides.begin(), sides.end());
  std::vector<std::array<std::uint32_t, 2>> outline;
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    const auto [low, high, direction] = sides[i];
    std::ptrdiff_t times = 0;
    for (; next < sides.size() && sides[next][0] == low && sides[next][1] == high; ++next)
      times += sides[next][2] == 1 ? 1 : -1;
    if (times > 0) outline.insert(outline.end(), static_cast<std::size_t>(times), {low, high});
    if (times < 0) outline.insert(outline.end(), static_cast<std::size_t>(-times), {high, low});
  }
  return outline;
}

void add_shape(const Page& page, Scene& scene) {
  if (page.voxel_surface) scene.shape_crease = 90;
  scene.shape_points = places(page, scene.placement, values_or_none<float>(page, "shape/points"));
  scene.shape.corners = values_or_none<std::uint32_t>(page, "shape/triangles");
  scene.plane = page.plane;
  if (page.plane) scene.outline = outline_of(scene.shape.corners);
  const std::size_t triangles = scene.shape.corners.size() / 3;
  scene.shape.offsets.resize(triangles + 1);
  for (std::size_t t = 0; t <= triangles; ++t) scene.shape.offsets[t] = static_cast<std::uint32_t>(3 * t);
}

/// The surface in the colours of a measure, which hides all else.
void add_solid_shape(const Page& page, const ViewState& state, Scene& scene) {
  add_shape(page, scene);
  require_size<float>(page, "shape/point/" + state.surface, scene.shape_points.size());
  scene.points = std::move(scene.shape_points);
  scene.sheets = std::move(scene.shape);
  scene.shape_points.clear();
  scene.shape = {};
  scene.sheet_crease = scene.shape_crease;
  scene.values = values_or_none<float>(page, "shape/point/" + state.surface);
  for (float& x : scene.values) x = std::isnan(x) ? kCodeMissing : std::isfinite(x) ? x : kCodeInfinite;
}

void measure_cells(Scene& scene) {
  for (std::size_t f = 0; f < scene.sheets.size(); ++f)
    scene.area += area_normal(scene.points, corners_of(scene.sheets, f)).norm();
  for (const auto& [a, b] : scene.curves) scene.curve_length += (scene.points[a] - scene.points[b]).norm();
}

/// The value that a share of the values does not exceed. Of many a sample, as viewer/src/measures.ts takes it.
std::pair<double, double> central_of(const std::vector<float>& finite) {
  const std::size_t stride = std::max<std::size_t>(1, finite.size() / 50000);
  std::vector<float> sample;
  for (std::size_t i = 0; i < finite.size(); i += stride) sample.push_back(finite[i]);
  std::sort(sample.begin(), sample.end());
  const auto at = [&](double share) {
    return sample[std::min(sample.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sample.size())))];
  };
  return {at(0.005), at(0.995)};
}

/// Of a skeleton its measures of sheets count on sheets, those of curves on curves.
std::vector<char> vertices_of_measure(const Scene& scene, const ViewState& state) {
  const bool all = state.layer != "skeleton" || !state.surface.empty();
  std::vector<char> counts(scene.points.size(), all);
  if (all) return counts;
  const bool of_curves = state.color.starts_with("curve_");
  const bool of_sheets = state.color == "erosion_thickness" || state.color == "burn_time";
  if (!of_sheets || scene.sheets.size() == 0)
    for (const auto& ends : scene.curves) counts[ends[0]] = counts[ends[1]] = 1;
  if (!of_curves || scene.curves.empty())
    for (const std::uint32_t v : scene.sheets.corners) counts[v] = 1;
  return counts;
}

}  // namespace

Placement placement_of(const Page& page) {
  const double side = page.side > 0 ? page.side : std::max((page.high - page.low).maxCoeff(), 1e-30);
  return {0.5 * (page.low + page.high), 1 / side};
}

Scene scene_of(const Page& page, const ViewState& state) {
  Scene scene;
  scene.placement = placement_of(page);
  require_below(page, "shape/triangles", values_or_none<float>(page, "shape/points").size() / 3);
  if (!state.surface.empty()) {
    add_solid_shape(page, state, scene);
    return scene;
  }
  if (state.shape) add_shape(page, scene);
  if (state.layer.empty()) return scene;
  if (state.layer == "simple") {
    add_mesh_cells(page, state, scene);
    add_edges_of_sheets(scene);
    measure_cells(scene);
    return scene;
  }
  if (state.layer != "tree") require_layer(page, state);
  scene.points = places(page, scene.placement, values_or_none<float>(page, state.layer + "/points"));
  if (page.find(state.layer + "/point/" + state.color)) {
    scene.values = values_or_none<float>(page, state.layer + "/point/" + state.color);
    for (float& x : scene.values) x = std::isnan(x) ? kCodeMissing : std::isfinite(x) ? x : kCodeInfinite;
  }
  if (state.layer == "skeleton")
    add_skeleton_cells(page, state, scene);
  else if (state.layer == "tree")
    add_tree_cells(page, state, scene);
  else
    LayerCells(page, state).add_to(scene);
  measure_cells(scene);
  return scene;
}

ColourRange colour_range(const Scene& scene, const ViewState& state) {
  ColourRange range;
  std::vector<float> finite, first;
  const bool of_sheets = !scene.sheet_values.empty();
  const std::vector<float>& values = of_sheets ? scene.sheet_values : scene.values;
  const std::vector<char> counts = of_sheets ? std::vector<char>(values.size(), 1) : vertices_of_measure(scene, state);
  for (std::size_t v = 0; v < values.size(); ++v) {
    const float x = values[v];
    range.infinite |= x > kCodeLimit;
    range.missing |= x < -kCodeLimit;
    if (std::abs(x) > kCodeLimit) continue;
    finite.push_back(x);
    if (counts[v]) first.push_back(x);
  }
  range.finite = !finite.empty();
  if (!range.finite) return range;
  const auto [least, most] = std::minmax_element(finite.begin(), finite.end());
  range.least = *least;
  range.most = *most;
  std::tie(range.low, range.high) = central_of(first.empty() ? finite : first);
  if (range.low > 0 && range.low < 0.3 * range.high) range.low = 0;
  if (!(range.high > range.low)) std::tie(range.low, range.high) = std::pair(range.least, range.most);
  return range;
}

std::vector<Vec3f> crease_normals(const std::vector<Vec3f>& points, const Polygons& polygons, double crease) {
  const auto cosine = static_cast<float>(std::cos(crease * std::numbers::pi / 180));
  std::vector<Vec3f> faces(polygons.size()), normals(polygons.corners.size(), Vec3f::Zero());
  base::for_indices(faces.size(), [&](std::size_t f) { faces[f] = area_normal(points, corners_of(polygons, f)); });
  std::vector<std::uint32_t> begin(points.size() + 1, 0), around(polygons.corners.size()),
      face(polygons.corners.size());
  for (const std::uint32_t v : polygons.corners) ++begin[v + 1];
  for (std::size_t v = 0; v < points.size(); ++v) begin[v + 1] += begin[v];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t f = 0; f < polygons.size(); ++f)
    for (std::uint32_t c = polygons.offsets[f]; c < polygons.offsets[f + 1]; ++c) {
      face[c] = f;
      around[next[polygons.corners[c]]++] = c;
    }
  base::for_indices(points.size(), [&](std::size_t v) {
    for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i) {
      const Vec3f& mine = faces[face[around[i]]];
      const float size = mine.norm();
      Vec3f sum = Vec3f::Zero();
      for (std::uint32_t k = begin[v]; k < begin[v + 1]; ++k) {
        const Vec3f& other = faces[face[around[k]]];
        const float dot = mine.dot(other);
        if (std::abs(dot) >= cosine * size * other.norm()) sum += dot < 0 ? Vec3f(-other) : other;
      }
      const float length = sum.norm();
      normals[around[i]] = length > 0 ? Vec3f(sum / length) : Vec3f(Vec3f::Zero());
    }
  });
  return normals;
}

}  // namespace quench::picture
