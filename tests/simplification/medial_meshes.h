// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "quench/axis.h"

/// Medial meshes for tests, by hand and at random (the same for the same seed).
namespace quench::testing_meshes {

inline MedialAxis mesh_of(std::vector<Vec3> points, std::vector<double> radius,
                          const std::vector<std::array<std::uint32_t, 2>>& edges,
                          const std::vector<std::vector<std::uint32_t>>& faces) {
  MedialAxis axis;
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const auto& face : faces) {
    corners.insert(corners.end(), face.begin(), face.end());
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  axis.complex = make_complex(static_cast<std::uint32_t>(points.size()), edges, offsets, corners);
  axis.points = std::move(points);
  axis.radius = std::move(radius);
  return axis;
}

/// Any simplicial complex of up to `most` vertices: edges of many triangles, pockets, lone edges and vertices.
inline MedialAxis random_mesh(std::uint64_t seed, int most = 12) {
  std::mt19937_64 random(seed);
  const auto below = [&](int n) { return static_cast<std::uint32_t>(random() % static_cast<std::uint64_t>(n)); };
  const int n = 2 + static_cast<int>(below(most - 1));
  std::vector<Vec3> points;
  std::vector<double> radius;
  for (int v = 0; v < n; ++v) {
    points.emplace_back(below(1000) / 1e3, below(1000) / 1e3, below(1000) / 1e3);
    radius.push_back(below(300) / 1e3);
  }
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t i = below(2 * n); i > 0; --i)
    if (const auto a = below(n), b = below(n); a != b) edges.push_back({a, b});
  std::set<std::set<std::uint32_t>> known;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = below(3 * n); i > 0; --i) {
    const std::vector<std::uint32_t> face{below(n), below(n), below(n)};
    const std::set<std::uint32_t> key(face.begin(), face.end());
    if (key.size() == 3 && known.insert(key).second) faces.push_back(face);
  }
  return mesh_of(std::move(points), std::move(radius), edges, faces);
}

/// The same with polygons of up to six corners, whose diagonals may be edges of others.
inline MedialAxis random_polygons(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  MedialAxis axis = random_mesh(seed, 9);
  const std::uint32_t n = axis.complex.vertex_count;
  std::set<std::set<std::uint32_t>> known;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = below(n + 1); i > 0 && n >= 3; --i) {
    std::vector<std::uint32_t> all(n), face;
    for (std::uint32_t v = 0; v < n; ++v) all[v] = v;
    std::shuffle(all.begin(), all.end(), random);
    face.assign(all.begin(), all.begin() + 3 + below(std::min(n, 6u) - 2));
    if (known.insert({face.begin(), face.end()}).second) faces.push_back(face);
  }
  return mesh_of(axis.points, axis.radius, axis.complex.edges, faces);
}

/// Each triangle in four, each lone edge in two, with linear radii.
inline MedialAxis subdivided(const MedialAxis& mesh) {
  std::vector<Vec3> points = mesh.points;
  std::vector<double> radius = mesh.radius;
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> middle;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const auto& [a, b] : mesh.complex.edges) {
    const auto m = static_cast<std::uint32_t>(points.size());
    middle[{a, b}] = m;
    points.push_back((mesh.points[a] + mesh.points[b]) / 2);
    radius.push_back((mesh.radius[a] + mesh.radius[b]) / 2);
    edges.push_back({a, m});
    edges.push_back({b, m});
  }
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::size_t f = 0; f < mesh.complex.face_count(); ++f) {
    const auto c = mesh.complex.corners(f);
    const auto at = [&](int i, int j) { return middle.at({std::min(c[i], c[j]), std::max(c[i], c[j])}); };
    const std::uint32_t ab = at(0, 1), bc = at(1, 2), ca = at(2, 0);
    faces.insert(faces.end(), {{c[0], ab, ca}, {ab, c[1], bc}, {ca, bc, c[2]}, {ab, bc, ca}});
  }
  return mesh_of(std::move(points), std::move(radius), edges, faces);
}

/// The medial axis of the box of these half sides, a > b > c: 12 vertices, 13 polygons.
inline MedialAxis axis_of_box(double a, double b, double c) {
  std::vector<Vec3> points;
  std::vector<double> radius;
  const auto vertex = [&](const Vec3& p, double r) {
    points.push_back(p);
    radius.push_back(r);
    return static_cast<std::uint32_t>(points.size() - 1);
  };
  std::array<std::array<std::uint32_t, 2>, 2> inner;
  std::array<std::array<std::array<std::uint32_t, 2>, 2>, 2> outer;
  for (std::size_t x = 0; x < 2; ++x)
    for (std::size_t y = 0; y < 2; ++y) {
      const double sx = x ? 1 : -1, sy = y ? 1 : -1;
      inner[x][y] = vertex({sx * (a - c), sy * (b - c), 0}, c);
      for (std::size_t z = 0; z < 2; ++z) outer[x][y][z] = vertex({sx * a, sy * b, (z ? 1 : -1) * c}, 0);
    }
  std::vector<std::vector<std::uint32_t>> faces{{inner[0][0], inner[1][0], inner[1][1], inner[0][1]}};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t z = 0; z < 2; ++z) {
      faces.push_back({inner[0][i], inner[1][i], outer[1][i][z], outer[0][i][z]});
      faces.push_back({inner[i][0], inner[i][1], outer[i][1][z], outer[i][0][z]});
      faces.push_back({inner[i][z], outer[i][z][0], outer[i][z][1]});
    }
  return mesh_of(std::move(points), std::move(radius), {}, faces);
}

}  // namespace quench::testing_meshes
