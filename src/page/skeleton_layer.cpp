// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "page/layer.h"

namespace quench {
namespace {

/// The vertices of the layer: first those of the skeleton that are on sheets or isolated, then those of the curves.
class Vertices {
 public:
  explicit Vertices(const Skeleton& skeleton) : skeleton_(skeleton), row_(skeleton.points.size(), kNone) {
    at_.reserve(skeleton.points.size());
    for (std::uint32_t v = 0; v < skeleton.points.size(); ++v) at_.emplace(key(skeleton.points[v]), v);
  }

  /// A vertex of the skeleton.
  std::uint32_t row(std::uint32_t v) {
    if (row_[v] == kNone) {
      row_[v] = static_cast<std::uint32_t>(points.size());
      points.push_back(skeleton_.points[v]);
      of.push_back(v);
      radius.push_back(skeleton_.radius[v]);
    }
    return row_[v];
  }
  /// A point of a branch: a vertex of the skeleton where there is one.
  std::uint32_t row(const Vec3& point, double radius_there) {
    if (const auto found = at_.find(key(point)); found != at_.end()) return row(found->second);
    points.push_back(point);
    of.push_back(kNone);
    radius.push_back(radius_there);
    return static_cast<std::uint32_t>(points.size() - 1);
  }

  std::vector<Vec3> points;
  std::vector<std::uint32_t> of;  ///< per row: the vertex of the skeleton, or kNone
  std::vector<double> radius;

 private:
  using Key = std::array<std::uint64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const {
      return static_cast<std::size_t>((k[0] * 0x9E3779B97F4A7C15U ^ k[1]) * 0xC2B2AE3D27D4EB4FU ^
                                      k[2] * 0x165667B19E3779F9U);
    }
  };
  static Key key(const Vec3& p) {
    return {std::bit_cast<std::uint64_t>(p[0] + 0.0), std::bit_cast<std::uint64_t>(p[1] + 0.0),
            std::bit_cast<std::uint64_t>(p[2] + 0.0)};
  }
  const Skeleton& skeleton_;
  std::vector<std::uint32_t> row_;
  std::unordered_map<Key, std::uint32_t, Hash> at_;
};

/// Values of the vertices of a skeleton; between them along a branch in proportion to the length.
class Measured {
 public:
  Measured(const Vertices& vertices, const std::vector<std::uint32_t>& offsets, const std::vector<std::uint32_t>& rows)
      : vertices_(vertices), offsets_(offsets), rows_(rows) {}

  template <class Value>
  std::vector<float> operator()(const Value& value) const {
    std::vector<double> values(vertices_.of.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t row = 0; row < values.size(); ++row)
      if (vertices_.of[row] != kNone) values[row] = value(vertices_.of[row]);
    for (std::size_t b = 0; b + 1 < offsets_.size(); ++b) fill(offsets_[b], offsets_[b + 1], values);
    std::vector<float> rounded(values.size());
    for (std::size_t row = 0; row < values.size(); ++row) rounded[row] = page::measure_of(values[row]);
    return rounded;
  }

 private:
  void fill(std::size_t begin, std::size_t end, std::vector<double>& values) const {
    const auto known = [&](std::size_t i) { return vertices_.of[rows_[i]] != kNone; };
    std::vector<double> along(end - begin, 0);
    for (std::size_t i = begin + 1; i < end; ++i)
      along[i - begin] = along[i - begin - 1] + (vertices_.points[rows_[i]] - vertices_.points[rows_[i - 1]]).norm();
    std::size_t before = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (known(i)) {
        before = i;
        continue;
      }
      std::size_t after = i + 1;
      while (after < end && !known(after)) ++after;
      if (before == end && after == end) return;
      for (; i < after; ++i) {
        const double a = values[rows_[before == end ? after : before]],
                     b = values[rows_[after == end ? before : after]];
        const double from = before == end ? 0 : along[before - begin],
                     to = after == end ? along.back() : along[after - begin];
        const double t = to > from ? (along[i - begin] - from) / (to - from) : 0;
        values[rows_[i]] = a == b ? a : (1 - t) * a + t * b;
      }
      --i;
    }
  }
  const Vertices& vertices_;
  const std::vector<std::uint32_t>& offsets_;
  const std::vector<std::uint32_t>& rows_;
};

void add_polygons(Page& page, const Skeleton& skeleton, Vertices& vertices) {
  const CellComplex& c = skeleton.complex;
  std::vector<std::uint32_t> corners, sheet;
  std::vector<float> thickness;
  for (const std::uint32_t v : c.face_vertices) corners.push_back(vertices.row(v));
  for (std::size_t f = 0; f < c.face_count(); ++f) thickness.push_back(page::measure_of(skeleton.face_thickness[f]));
  page.arrays.push_back({"skeleton/polygon_offsets", 1, c.face_offsets});
  page.arrays.push_back({"skeleton/polygon_corners", 1, std::move(corners)});
  page.arrays.push_back({"skeleton/polygon_sheet", 1,
                         std::vector<std::uint32_t>(skeleton.face_sheet.begin(), skeleton.face_sheet.end())});
  page.arrays.push_back({"skeleton/polygon_thickness", 1, std::move(thickness)});
}

void add_branches(Page& page, const CurveGraph& graph) {
  const auto add = [&](const char* name, double CurveGraph::Branch::*of) {
    std::vector<float> values;
    for (const CurveGraph::Branch& branch : graph.branches) values.push_back(static_cast<float>(branch.*of));
    page.arrays.push_back({std::string("skeleton/branch/") + name, 1, std::move(values)});
  };
  add("length", &CurveGraph::Branch::length);
  add("mean_radius", &CurveGraph::Branch::mean_radius);
  add("min_radius", &CurveGraph::Branch::min_radius);
  add("max_radius", &CurveGraph::Branch::max_radius);
  add("thickness", &CurveGraph::Branch::thickness);
  add("tortuosity", &CurveGraph::Branch::tortuosity);
  std::vector<std::uint32_t> ends;
  for (const CurveGraph::Branch& branch : graph.branches) ends.insert(ends.end(), {branch.from, branch.to});
  page.arrays.push_back({"skeleton/branch_nodes", 2, std::move(ends)});
}

}  // namespace

std::size_t add_skeleton(Page& page, const Skeleton& skeleton, const CurveGraph& graph) {
  page.theta1_radii = skeleton.theta1_radii;
  Vertices vertices(skeleton);
  add_polygons(page, skeleton, vertices);
  std::vector<std::uint32_t> offsets{0}, rows, node_rows, isolated;
  std::vector<std::uint8_t> kinds;
  for (const CurveGraph::Node& node : graph.nodes) {
    node_rows.push_back(vertices.row(node.point, node.radius));
    kinds.push_back(static_cast<std::uint8_t>(node.kind));
    if (node.kind == CurveGraph::NodeKind::isolated) isolated.push_back(node_rows.back());
  }
  for (const CurveGraph::Branch& branch : graph.branches) {
    rows.push_back(node_rows[branch.from]);
    for (std::size_t i = 1; i + 1 < branch.points.size(); ++i)
      rows.push_back(vertices.row(branch.points[i], branch.radius[i]));
    rows.push_back(node_rows[branch.to]);
    offsets.push_back(static_cast<std::uint32_t>(rows.size()));
  }
  page::widen(page, vertices.points);
  page.arrays.push_back({"skeleton/points", 3, page::places_of(page, vertices.points)});

  const Measured measured(vertices, offsets, rows);
  std::vector<float> radius;
  for (const double r : vertices.radius) radius.push_back(page::measure_of(r));
  page.arrays.push_back({"skeleton/point/radius", 1, std::move(radius)});
  const auto add = [&](const char* name, const auto& value) {
    page.arrays.push_back({std::string("skeleton/point/") + name, 1, measured(value)});
  };
  page::each_fire_measure(skeleton, skeleton.on_curve, add);

  page.arrays.push_back({"skeleton/branch_offsets", 1, std::move(offsets)});
  page.arrays.push_back({"skeleton/branch_points", 1, std::move(rows)});
  add_branches(page, graph);
  page.arrays.push_back({"skeleton/node_points", 1, std::move(node_rows)});
  page.arrays.push_back({"skeleton/node_kind", 1, std::move(kinds)});
  page.arrays.push_back({"skeleton/isolated", 1, std::move(isolated)});
  return skeleton.complex.face_vertices.size() - 2 * skeleton.complex.face_count();
}

}  // namespace quench
