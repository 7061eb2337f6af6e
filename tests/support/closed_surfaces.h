// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/union_find.h"
#include "quench/geometry.h"

/// What is true of closed surfaces, by brute force.
namespace quench::testing_surfaces {

/// Every edge lies in one triangle that runs along it and one that runs back, around every vertex there is one fan of
/// triangles, and every vertex has one.
inline bool is_closed_manifold(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> third;  // of the triangle along an edge
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (t[i] == t[(i + 1) % 3] || !third.emplace(std::pair(t[i], t[(i + 1) % 3]), t[(i + 2) % 3]).second)
        return false;
  std::vector<std::uint32_t> triangles(mesh.points.size(), 0), first(mesh.points.size(), kNone);
  for (const auto& [edge, corner] : third) {
    if (!third.contains({edge.second, edge.first})) return false;
    ++triangles[edge.first];
    first[edge.first] = edge.second;
  }
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    if (triangles[v] == 0) return false;
    std::uint32_t around = first[v], passed = 0;
    do {
      around = third.at({v, around});
      ++passed;
    } while (around != first[v] && passed <= triangles[v]);
    if (passed != triangles[v]) return false;
  }
  return true;
}

/// Vertices - edges + faces.
inline std::int64_t euler_of(const TriangleMesh& mesh) {
  return static_cast<std::int64_t>(mesh.points.size()) - static_cast<std::int64_t>(mesh.triangles.size()) / 2;
}

inline std::int64_t components_of(const TriangleMesh& mesh) {
  base::UnionFind sets(static_cast<std::uint32_t>(mesh.points.size()));
  for (const auto& t : mesh.triangles) {
    sets.unite(t[0], t[1]);
    sets.unite(t[0], t[2]);
  }
  std::int64_t count = 0;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) count += sets.find(v) == v;
  return count;
}

/// How often the surface winds around a point, by solid angles (Van Oosterom and Strackee 1983); whole but for rounding
/// when the point is not on it.
inline double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.points[t[0]] - p, b = mesh.points[t[1]] - p, c = mesh.points[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * M_PI);
}

/// The volume it bounds.
inline double volume_of(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]]));
  return sum / 6;
}

/// The distance of a point to a triangle.
inline double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const auto beside = [&](const Vec3& from, const Vec3& to) { return normal.cross(to - from).dot(p - from) >= 0; };
  if (normal.squaredNorm() > 0 && beside(a, b) && beside(b, c) && beside(c, a))
    return std::abs(normal.normalized().dot(p - a));
  const auto to_segment = [&](const Vec3& from, const Vec3& to) {
    const Vec3 way = to - from;
    const double t = way.squaredNorm() > 0 ? std::clamp(way.dot(p - from) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    return (p - from - t * way).norm();
  };
  return std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

inline double distance_to(const TriangleMesh& mesh, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles)
    nearest = std::min(nearest, distance_to_triangle(p, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
  return nearest;
}

}  // namespace quench::testing_surfaces
