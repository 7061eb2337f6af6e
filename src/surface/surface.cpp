// SPDX-License-Identifier: Apache-2.0
#include "quench/surface.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "quench/error.h"
#include "surface/triangle_tree.h"

namespace quench {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr std::array<std::pair<SurfaceKind, std::string_view>, 4> kKinds{{{SurfaceKind::voxels, "voxels"},
                                                                          {SurfaceKind::mesh, "mesh"},
                                                                          {SurfaceKind::grey, "grey"},
                                                                          {SurfaceKind::smooth, "smooth"}}};

// Points at one place become one; triangles without area go, and points without triangles.
TriangleMesh welded(TriangleMesh&& mesh) {
  std::vector<std::uint32_t> order(mesh.points.size()), first(mesh.points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = mesh.points[a], &q = mesh.points[b];
    for (int k = 0; k < 3; ++k)
      if (p[k] != q[k]) return p[k] < q[k];
    return a < b;
  };
  tbb::parallel_sort(order.begin(), order.end(), less);
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && mesh.points[order[i]] == mesh.points[order[i - 1]] ? first[order[i - 1]] : order[i];
  std::erase_if(mesh.triangles, [&](Triangle& t) {
    for (std::uint32_t& corner : t) corner = first[corner];
    const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    return !((b - a).cross(c - a).squaredNorm() > 0);
  });
  std::vector<std::uint32_t> row(mesh.points.size(), kNone);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t corner : t) row[corner] = 0;
  std::uint32_t count = 0;
  for (std::size_t p = 0; p < row.size(); ++p)
    if (row[p] != kNone) {
      mesh.points[count] = mesh.points[p];
      row[p] = count++;
    }
  mesh.points.resize(count);
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& corner : t) corner = row[corner];
  return std::move(mesh);
}

Vec3 normal_of(const TriangleMesh& mesh, const Triangle& t) {
  return (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).normalized();
}

// Sums of the normals around each point, weighted by the angles of the faces.
std::vector<Vec3> point_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.points.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 normal = normal_of(mesh, t);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = mesh.points[t[(k + 1) % 3]] - mesh.points[t[k]];
      const Vec3 w = mesh.points[t[(k + 2) % 3]] - mesh.points[t[k]];
      normals[t[k]] += std::atan2(u.cross(w).norm(), u.dot(w)) * normal;
    }
  }
  return normals;
}

// The triangle behind each side (the one opposite corner k); none where it has not one neighbour.
std::vector<Triangle> neighbours_of(const std::vector<Triangle>& triangles) {
  struct Side {
    std::array<std::uint32_t, 2> ends;
    std::uint32_t triangle, corner;
    bool operator<(const Side& other) const {
      return std::tie(ends, triangle, corner) < std::tie(other.ends, other.triangle, other.corner);
    }
  };
  std::vector<Side> sides(3 * triangles.size());
  base::for_indices(triangles.size(), [&](std::size_t t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
      sides[3 * t + k] = {{low, high}, static_cast<std::uint32_t>(t), k};
    }
  });
  tbb::parallel_sort(sides.begin(), sides.end());
  std::vector<Triangle> neighbours(triangles.size(), {kNone, kNone, kNone});
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    while (end < sides.size() && sides[end].ends == sides[i].ends) ++end;
    if (end - i != 2) continue;
    neighbours[sides[i].triangle][sides[i].corner] = sides[i + 1].triangle;
    neighbours[sides[i + 1].triangle][sides[i + 1].corner] = sides[i].triangle;
  }
  return neighbours;
}

}  // namespace

std::string_view name_of(SurfaceKind kind) {
  return std::ranges::find(kKinds, kind, &std::pair<SurfaceKind, std::string_view>::first)->second;
}

std::optional<SurfaceKind> surface_kind_of(std::string_view name) {
  for (const auto& [kind, its_name] : kKinds)
    if (its_name == name) return kind;
  return {};
}

struct Surface::Parts {
  SurfaceKind kind;
  TriangleMesh mesh;
  surface::TriangleTree tree;
  std::vector<Vec3> point_normals;
  std::vector<Triangle> neighbours;

  Parts(TriangleMesh&& of, SurfaceKind its_kind)
      : kind(its_kind),
        mesh(welded(std::move(of))),
        tree(mesh),
        point_normals(quench::point_normals(mesh)),
        neighbours(neighbours_of(mesh.triangles)) {}

  // The direction that tells inside from outside at a place of a triangle. At a side with more than two faces that of
  // the triangle alone.
  Vec3 normal_at(std::uint32_t triangle, surface::Feature feature) const {
    const Triangle& t = mesh.triangles[triangle];
    if (feature >= surface::kCorner) return point_normals[t[feature - surface::kCorner]];
    const Vec3 own = normal_of(mesh, t);
    if (feature == surface::kInterior) return own;
    const std::uint32_t other = neighbours[triangle][feature - surface::kSide];
    return other == kNone ? own : own + normal_of(mesh, mesh.triangles[other]);
  }
};

Surface::Surface(TriangleMesh mesh, SurfaceKind kind, Context* context) {
  parts_ = base::in_arena(context, [&] { return std::make_shared<const Parts>(std::move(mesh), kind); });
  if (parts_->mesh.triangles.empty()) throw Error(ErrorCode::input, "a surface needs a triangle with an area");
}

SurfaceKind Surface::kind() const { return parts_->kind; }

const TriangleMesh& Surface::mesh() const { return parts_->mesh; }

Surface::Foot Surface::nearest(const Vec3& p, double within) const {
  const surface::TriangleTree::Near near = parts_->tree.nearest(p, within * within);
  if (near.triangle == kNone) return {};
  const Vec3 normal = parts_->normal_at(near.triangle, near.feature);
  return {near.point, std::sqrt(near.squared), near.triangle, (p - near.point).dot(normal) < 0};
}

}  // namespace quench
