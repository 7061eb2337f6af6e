// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "quench/complex.h"
#include "quench/skeleton.h"

/// Skeletons without a shape: cells put together by hand, or at random.
namespace quench::testing_skeletons {

struct Cells {
  std::vector<Vec3> points;
  std::vector<double> radius;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::vector<std::uint32_t>> faces;

  std::uint32_t add(double x, double y, double z, double r = 1) {
    points.push_back({x, y, z});
    radius.push_back(r);
    return static_cast<std::uint32_t>(points.size() - 1);
  }
  /// Vertices joined one after the other.
  void path(const std::vector<std::uint32_t>& vertices) {
    for (std::size_t i = 1; i < vertices.size(); ++i) edges.push_back({vertices[i - 1], vertices[i]});
  }
  /// A square of side 2 in z = height around (x, y); its first corner is at (x - 1, y - 1).
  std::uint32_t square(double x, double y, double height, double r = 1) {
    const std::uint32_t a = add(x - 1, y - 1, height, r), b = add(x + 1, y - 1, height, r),
                        c = add(x + 1, y + 1, height, r), d = add(x - 1, y + 1, height, r);
    faces.push_back({a, b, c, d});
    return a;
  }
};

/// ET_MC of an edge is a number of its place, NaN where it is no curve.
inline Skeleton skeleton_of(const Cells& cells) {
  Skeleton skeleton;
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const auto& face : cells.faces) {
    corners.insert(corners.end(), face.begin(), face.end());
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  skeleton.complex =
      make_complex(static_cast<std::uint32_t>(cells.points.size()), cells.edges, std::move(offsets), corners);
  skeleton.points = cells.points;
  skeleton.radius = cells.radius;
  skeleton.burn_time = cells.radius;
  skeleton.curve_burn_time = cells.radius;
  skeleton.on_curve.assign(cells.points.size(), 0);
  for (const auto& [u, v] : skeleton.complex.edges)
    skeleton.edge_thickness.push_back(std::abs(cells.points[u].sum() + cells.points[v].sum()));
  for (std::uint32_t e : skeleton.complex.face_edges)
    skeleton.edge_thickness[e] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t e = 0; e < skeleton.complex.edges.size(); ++e)
    if (!std::isnan(skeleton.edge_thickness[e]))
      for (std::uint32_t v : skeleton.complex.edges[e]) skeleton.on_curve[v] = 1;
  skeleton.edge_level = skeleton.edge_thickness;
  skeleton.face_thickness.assign(skeleton.complex.face_count(), 1);
  skeleton.face_level = skeleton.face_thickness;
  return skeleton;
}

/// Random lone edges and triangles between random points: all kinds of nodes, loops, patches and components.
inline Cells random_cells(std::uint64_t seed) {
  std::mt19937_64 random(seed * 0x9E3779B97F4A7C15ull + 7);
  const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Cells cells;
  const std::uint32_t n = 3 + below(seed % 5 == 1 ? 4 : 30);  // few vertices: closed curves
  // Coarse radii, so that there are ties.
  for (std::uint32_t v = 0; v < n; ++v) cells.add(10 * unit(), 10 * unit(), 10 * unit(), 1 + below(4));
  std::set<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t e = below(2 * n); e > 0; --e) {
    const std::uint32_t u = below(n), v = seed % 2 ? (u + 1) % n : below(n);  // odd seeds: long branches
    if (u != v) edges.insert({std::min(u, v), std::max(u, v)});
  }
  cells.edges.assign(edges.begin(), edges.end());
  std::set<std::set<std::uint32_t>> faces;
  for (std::uint32_t f = seed % 3 ? below(4) : 0; f > 0; --f) {
    const std::set<std::uint32_t> face{below(n), below(n), below(n)};
    if (face.size() == 3 && faces.insert(face).second) cells.faces.push_back({face.begin(), face.end()});
  }
  return cells;
}

}  // namespace quench::testing_skeletons
