// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kSamePlace = 1e-9;  // of the smallest spacing
constexpr double kFlatness = 1e-6;   // of the size of a polygon

// The first two indices with equal keys.
template <class Key>
std::optional<std::array<std::size_t, 2>> first_equal(const std::vector<Key>& keys) {
  std::vector<std::uint32_t> order(keys.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return std::tie(keys[i], i) < std::tie(keys[j], j); });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (keys[order[i]] == keys[order[i - 1]]) return std::array<std::size_t, 2>{order[i - 1], order[i]};
  return std::nullopt;
}

// Two vertices nearer than `distance`: points go into every cell of a coarser grid that their ball touches.
std::optional<std::array<std::uint32_t, 2>> first_close(const std::vector<Vec3>& points, double distance) {
  const double cell = 1000 * distance;
  std::vector<std::pair<std::array<double, 3>, std::uint32_t>> entries;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vec3 low = ((points[i].array() - distance) / cell).floor(),
               high = ((points[i].array() + distance) / cell).floor();
    for (double x : {low[0], high[0]})
      for (double y : {low[1], high[1]})
        for (double z : {low[2], high[2]}) entries.push_back({{x, y, z}, i});
  }
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  for (std::size_t i = 0; i < entries.size(); ++i)
    for (std::size_t j = i + 1; j < entries.size() && entries[j].first == entries[i].first; ++j)
      if ((points[entries[i].second] - points[entries[j].second]).norm() <= distance)
        return std::array{entries[i].second, entries[j].second};
  return std::nullopt;
}

// What is wrong with the polygon's geometry; empty when nothing is. Cells of Voronoi diagrams are convex; what is left
// of one in a skeleton need not be, but its boundary goes around it once.
//
// A coordinate may be off by `rounding`, a corner by less than twice that, and one that is left out because it is next
// to another moves by up to 16 times that. Twice the area is the length of the sum of c[i] x c[i + 1]; moving c[i] by d
// changes it by d x (c[i + 1] - c[i - 1]), and so by at most |d| times the size. A polygon counts as a defect only if
// it is one for all positions that the corners can have had before rounding.
std::string polygon_defect(std::vector<Vec3> corners, double tiny, double rounding, bool convex) {
  const double unsure = 16 * rounding;
  const auto given = static_cast<double>(corners.size());
  corners.erase(std::unique(corners.begin(), corners.end(),
                            [&](const Vec3& p, const Vec3& q) { return (p - q).norm() <= unsure; }),
                corners.end());
  while (corners.size() > 1 && (corners.front() - corners.back()).norm() <= unsure) corners.pop_back();
  const std::size_t n = corners.size();
  if (n < 3) return {};
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : corners) centre += p / static_cast<double>(n);
  double size = 0;
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    size = std::max(size, 2 * (corners[i] - centre).norm());
    normal += (corners[i] - centre).cross(corners[(i + 1) % n] - centre);
  }
  const double twice_area = normal.norm();
  const double left_out = given - static_cast<double>(n),
               off = 2 * static_cast<double>(n) * rounding + left_out * unsure;
  if (twice_area + off * size <= tiny * size) return "has no area";
  if (twice_area <= given * unsure * size) return {};  // not even which way it turns at a thin end
  normal /= twice_area;
  double turned = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double height = std::abs(normal.dot(corners[i] - centre));
    if (height > kFlatness * size + tiny + unsure)
      return fmt::format("is not plane: off by {:.3g} at size {:.3g}", height, size);
    const Vec3 in = corners[i] - corners[(i + n - 1) % n], out = corners[(i + 1) % n] - corners[i];
    const double turn = normal.dot(in.cross(out));
    if (convex && turn < -(kFlatness * in.norm() * out.norm() + (tiny + unsure) * (in.norm() + out.norm())))
      return "is not convex";
    turned += std::atan2(turn, in.dot(out));
  }
  if (turned > 3 * std::numbers::pi || turned < std::numbers::pi) return "winds around itself";
  return {};
}

}  // namespace

Check check_cells(const Result& result) {
  Check check{"no duplicate or degenerate cell", false, {}, {}};
  const CellComplex& complex = result.complex;
  if (result.rows.size() != result.data.points.size()) {
    std::size_t skipped = 0;
    while (skipped < result.rows.size() && result.rows[skipped] == skipped) ++skipped;
    check.detail = fmt::format("point {} belongs to no cell", skipped);
    return check;
  }
  const double tiny = kSamePlace * static_cast<double>(*std::min_element(result.scale.begin(), result.scale.end()));
  // The distance is below what rounding can add: each point may be off by less than twice `rounding`.
  const double surely_tiny = tiny - 4 * result.rounding;

  for (std::uint32_t f = 0; f < complex.face_count(); ++f) {
    std::vector<std::uint32_t> corners(complex.corners(f).begin(), complex.corners(f).end());
    std::sort(corners.begin(), corners.end());
    if (std::adjacent_find(corners.begin(), corners.end()) == corners.end()) continue;
    check.detail = result.describe_face(f) + " repeats a corner";
    return check;
  }
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if ((result.scaled[complex.edges[e][0]] - result.scaled[complex.edges[e][1]]).norm() <= surely_tiny) {
      check.detail = result.describe_edge(e) + " has length 0";
      return check;
    }
  if (const auto twice = first_equal(result.vert_vertices)) {
    check.detail = fmt::format("vertex cells {} and {} are the same: {}", (*twice)[0], (*twice)[1],
                               result.describe_vertex(result.vert_vertices[(*twice)[0]]));
    return check;
  }
  if (const auto twice = first_equal(result.line_edges)) {
    check.detail = fmt::format("lines {} and {} are the same: {}", (*twice)[0], (*twice)[1],
                               result.describe_edge(result.line_edges[(*twice)[0]]));
    return check;
  }
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    faces.emplace_back(complex.corners(f).begin(), complex.corners(f).end());
    std::sort(faces.back().begin(), faces.back().end());
  }
  if (const auto twice = first_equal(faces)) {
    check.detail = fmt::format("polygons {} and {} have the same corners: {}", (*twice)[0], (*twice)[1],
                               result.describe_face((*twice)[0]));
    return check;
  }
  if (const auto close = surely_tiny > 0 ? first_close(result.scaled, surely_tiny) : std::nullopt) {
    check.detail = fmt::format("{} and {} are at the same place", result.describe_vertex((*close)[0]),
                               result.describe_vertex((*close)[1]));
    return check;
  }
  std::vector<Vec3> corners;
  const std::vector<char> smoothed = smoothed_vertices(result);
  for (std::size_t f = 0; f < complex.face_count() && result.has_voxel_geometry; ++f) {  // fitted ones are warped
    corners.clear();
    bool warped = false;
    for (std::uint32_t v : complex.corners(f)) {
      corners.push_back(result.scaled[v]);
      warped |= smoothed[v] != 0;
    }
    if (warped) continue;
    const std::string defect = polygon_defect(corners, tiny, result.rounding, result.stage == "core");
    if (defect.empty()) continue;
    check.detail = fmt::format("{} {}", result.describe_face(f), defect);
    return check;
  }
  check.passed = true;
  check.detail = fmt::format("{} vertices, {} edges", result.rows.size(), complex.edges.size());
  if (!result.plane) check.detail += fmt::format(", {} polygons", complex.face_count());
  return check;
}

}  // namespace quench::verification
