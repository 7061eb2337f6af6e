// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "quench/geometry.h"

/// Small closed meshes with integer coordinates: their digitization can be checked exactly.
namespace quench::testing_meshes {

using Point = std::array<std::int64_t, 3>;

inline void add_point(TriangleMesh& mesh, const Point& p) {
  mesh.points.emplace_back(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
}

inline std::uint32_t next_index(const TriangleMesh& mesh) { return static_cast<std::uint32_t>(mesh.points.size()); }

inline void add_faces(TriangleMesh& mesh, std::uint32_t base, std::initializer_list<std::array<std::uint32_t, 3>> faces,
                      bool inward) {
  for (const auto& f : faces) {
    mesh.triangles.push_back({base + f[0], base + f[1], base + f[2]});
    if (inward) std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
  }
}

/// Outward when det(b-a, c-a, d-a) > 0.
inline void add_tetrahedron(TriangleMesh& mesh, const std::array<Point, 4>& corners, bool inward = false) {
  const std::uint32_t base = next_index(mesh);
  for (const Point& p : corners) add_point(mesh, p);
  add_faces(mesh, base, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, inward);
}

inline void add_box(TriangleMesh& mesh, const Point& low, const Point& high, bool inward = false) {
  const std::uint32_t base = next_index(mesh);
  for (unsigned c = 0; c < 8; ++c)
    add_point(mesh, {c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 4 ? high[2] : low[2]});
  add_faces(mesh, base,
            {{0, 2, 1},
             {1, 2, 3},
             {4, 5, 6},
             {6, 5, 7},
             {0, 1, 4},
             {4, 1, 5},
             {2, 6, 3},
             {3, 6, 7},
             {0, 4, 2},
             {2, 4, 6},
             {1, 3, 5},
             {5, 3, 7}},
            inward);
}

inline void add_octahedron(TriangleMesh& mesh, const Point& c, const Point& radius, bool inward = false) {
  const std::uint32_t base = next_index(mesh);
  for (std::size_t a = 0; a < 3; ++a)
    for (const int sign : {-1, 1}) {
      Point p = c;
      p[a] += sign * radius[a];
      add_point(mesh, p);
    }
  for (std::uint32_t o = 0; o < 8; ++o) {  // odd numbers of negative corners turn the face around
    const bool flip = ((o & 1) + (o >> 1 & 1) + (o >> 2)) % 2 == 0;
    add_faces(mesh, base, {{o & 1, 2 + (o >> 1 & 1), 4 + (o >> 2)}}, inward != flip);
  }
}

/// A triangle and its reverse: closed, encloses nothing, and spans the box [0, side]^3, so that meshes which contain
/// it have the same voxel lattice.
inline void add_frame(TriangleMesh& mesh, std::int64_t side) {
  const std::uint32_t base = next_index(mesh);
  add_point(mesh, {0, 0, 0});
  add_point(mesh, {side, side, side});
  add_point(mesh, {side, 0, side});
  add_faces(mesh, base, {{0, 1, 2}, {0, 2, 1}}, false);
}

/// One to four parts of any kind, orientation and relative position, with corners on integers from 0 to side.
inline TriangleMesh random_mesh(std::mt19937_64& random, std::int64_t side) {
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  const auto point = [&] { return Point{below(side + 1), below(side + 1), below(side + 1)}; };
  TriangleMesh mesh;
  const std::int64_t parts = 1 + below(4);
  for (std::int64_t part = 0; part < parts; ++part) {
    const bool inward = below(2) == 0;
    const std::int64_t kind = below(3);
    if (kind == 0) {
      add_tetrahedron(mesh, {point(), point(), point(), point()}, inward);
    } else if (kind == 1) {
      Point low = point(), high = point();
      for (std::size_t a = 0; a < 3; ++a) {
        if (low[a] > high[a]) std::swap(low[a], high[a]);
        if (low[a] == high[a]) ++high[a];
      }
      add_box(mesh, low, high, inward);
    } else {
      add_octahedron(mesh, {below(side), below(side), below(side)},
                     {1 + below(side / 2), 1 + below(side / 2), 1 + below(side / 2)}, inward);
    }
  }
  return mesh;
}

}  // namespace quench::testing_meshes
