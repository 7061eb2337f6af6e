// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <unordered_map>

#include "page/layer.h"

namespace quench::page {
namespace {

/// Per vertex the first vertex in the same cube of side `side`.
std::vector<std::uint32_t> leaders(const std::vector<Vec3>& points, const Vec3& low, double side) {
  std::unordered_map<std::uint64_t, std::uint32_t> first;
  first.reserve(points.size());
  std::vector<std::uint32_t> leader(points.size());
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    std::uint64_t key = 0;
    for (int a = 0; a < 3; ++a) {
      const double cell = (points[v][a] - low[a]) / side;  // NaN where all points are equal, or a point is not finite
      key = key << 21 | static_cast<std::uint64_t>(cell > 0 ? std::min(cell, 2097151.0) : 0);
    }
    leader[v] = first.emplace(key, v).first->second;
  }
  return leader;
}

/// The triangles that keep three distinct corners when vertices are replaced by their leaders, each once.
std::vector<std::array<std::uint32_t, 3>> triangles_left(const Record& data, const std::vector<std::uint32_t>& leader) {
  std::vector<std::array<std::uint32_t, 3>> left;
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    const std::uint32_t begin = data.poly_offsets[p], end = data.poly_offsets[p + 1];
    for (std::uint32_t i = begin + 2; i < end; ++i) {
      std::array<std::uint32_t, 3> t{leader[data.poly_corners[begin]], leader[data.poly_corners[i - 1]],
                                     leader[data.poly_corners[i]]};
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      left.push_back(t);
    }
  }
  std::sort(left.begin(), left.end());
  left.erase(std::unique(left.begin(), left.end()), left.end());
  return left;
}

}  // namespace

Record clustered(const Record& data, std::size_t max_triangles, std::vector<std::uint32_t>& kept, double finest) {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!data.points.empty()) low = high = data.points[0];
  for (const Vec3& p : data.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  double area = 0;
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    const std::uint32_t begin = data.poly_offsets[p];
    for (std::uint32_t i = begin + 2; i < data.poly_offsets[p + 1]; ++i) {
      const Vec3 &a = data.points[data.poly_corners[begin]], &b = data.points[data.poly_corners[i - 1]],
                 &c = data.points[data.poly_corners[i]];
      area += 0.5 * (b - a).cross(c - a).norm();
    }
  }
  // A surface passes through about area / side^2 cubes, with two triangles each. If there are more, the side grows with
  // the excess.
  const double budget = static_cast<double>(std::max<std::size_t>(max_triangles, 1)), box = (high - low).maxCoeff();
  double side = std::max(finest > 0 ? finest : std::sqrt(2 * area / budget), box * 1e-6);
  std::vector<std::uint32_t> leader;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (;;) {
    leader = leaders(data.points, low, side);
    triangles = triangles_left(data, leader);
    if (triangles.size() <= max_triangles || !(side < 2 * box)) break;
    side *= std::max(1.03, std::sqrt(static_cast<double>(triangles.size()) / budget));
  }
  if (triangles.size() > max_triangles) triangles.clear();  // boxes that are not numbers

  Record result;
  std::vector<std::uint32_t> number(data.points.size(), kNone);
  kept.clear();
  for (std::uint32_t v = 0; v < leader.size(); ++v)
    if (leader[v] == v) {
      number[v] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(v);
    }
  // Drawn in the middle of the vertices that are merged, which keeps surfaces smooth.
  std::vector<double> count(kept.size(), 0);
  result.points.assign(kept.size(), Vec3::Zero());
  for (std::uint32_t v = 0; v < leader.size(); ++v) {
    result.points[number[leader[v]]] += data.points[v];
    ++count[number[leader[v]]];
  }
  for (std::size_t n = 0; n < kept.size(); ++n) result.points[n] /= count[n];
  for (const std::uint32_t v : data.verts) result.verts.push_back(number[leader[v]]);
  for (const auto& [a, b] : data.lines)
    if (leader[a] != leader[b]) result.lines.push_back({number[leader[a]], number[leader[b]]});
  for (const auto& t : triangles) {
    for (const std::uint32_t v : t) result.poly_corners.push_back(number[v]);
    result.poly_offsets.push_back(static_cast<std::uint32_t>(result.poly_corners.size()));
  }
  return result;
}

}  // namespace quench::page
