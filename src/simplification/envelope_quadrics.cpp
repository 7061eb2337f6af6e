// SPDX-License-Identifier: Apache-2.0
#include "simplification/envelope_quadrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/csr.h"
#include "base/parallel.h"

namespace quench::simplification {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Rims of sheets that end in an edge of the shape have no radius: there so much of the cells around counts as one.
constexpr double kLeastRim = 0.1;

/// An arc of directions around an edge: from an angle on, so far.
struct Arc {
  double from, width;
};

/// What arcs leave of a full turn.
void uncovered(std::vector<Arc>& arcs, std::vector<Arc>& rest) {
  rest.clear();
  if (arcs.empty()) {
    rest.push_back({0, kTurn});
    return;
  }
  for (Arc& arc : arcs) {
    if (arc.width >= kTurn) return;
    arc.from -= kTurn * std::floor(arc.from / kTurn);
  }
  std::ranges::sort(arcs, {}, &Arc::from);
  double reach = arcs.back().from + arcs.back().width - kTurn;
  for (const Arc& arc : arcs) reach = std::max(reach, arc.from + arc.width - kTurn);
  for (const Arc& arc : arcs) {
    if (arc.from > reach) rest.push_back({reach, arc.from - reach});
    reach = std::max(reach, arc.from + arc.width);
  }
}

class Patches {
 public:
  explicit Patches(const MedialAxis& mesh) : mesh_(mesh) {
    const CellComplex& c = mesh.complex;
    std::vector<std::uint32_t> count(c.edges.size() + 1, 0);
    for (const std::uint32_t e : c.face_edges) ++count[e + 1];
    for (std::size_t e = 0; e < c.edges.size(); ++e) count[e + 1] += count[e];
    first_ = count;
    faces_.resize(c.face_edges.size());
    for (std::uint32_t f = 0; f < c.face_count(); ++f)
      for (const std::uint32_t e : c.sides(f)) faces_[count[e]++] = f;
  }

  Vec4 ball(std::uint32_t v) const { return ball_of(mesh_.points[v], mesh_.radius[v]); }

  /// The two planes of a slab, with a third of its area; none where one ball covers the others.
  void add_slab(std::uint32_t f, Quadric& quadric) const {
    const auto corners = mesh_.complex.corners(f);
    const Vec4 a = ball(corners[0]), d1 = ball(corners[1]) - a, d2 = ball(corners[2]) - a;
    const Vec3 u = d1.head<3>(), v = d2.head<3>(), normal = u.cross(v);
    const double twice = normal.norm();
    if (!(twice > 0)) return;
    const Vec3 nu = normal / twice;
    const Vec3 slope = (d1[3] * v.cross(nu) + d2[3] * nu.cross(u)) / twice;  // of the radius
    const double rest = 1 - slope.squaredNorm();
    if (rest <= 0) return;
    const double area = twice / 2 * std::sqrt(rest);
    for (const double side : {-1.0, 1.0}) {
      const Vec3 n = side * std::sqrt(rest) * nu - slope;
      quadric.add_plane({n[0], n[1], n[2], 1}, a, area / 3);
    }
  }

  /// What the slabs beside an edge leave of its cone, with half its area.
  void add_cone(std::uint32_t e, Quadric& quadric, std::vector<Arc>& arcs, std::vector<Arc>& rest) const {
    const auto [i, j] = mesh_.complex.edges[e];
    const Vec4 a = ball(i), b = ball(j);
    const Vec3 along = b.head<3>() - a.head<3>();
    const double length = along.norm();
    if (!(length > 0)) return;
    const Vec3 axis = along / length;
    const double k = (a[3] - b[3]) / length;
    if (std::abs(k) >= 1) return;
    const double s = std::sqrt(1 - k * k);
    const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
    arcs.clear();
    double height = 0;
    for (std::uint32_t at = first_[e]; at < first_[e + 1]; ++at) {
      std::uint32_t third = kNone;
      for (const std::uint32_t w : mesh_.complex.corners(faces_[at]))
        if (w != i && w != j) third = w;
      const Vec3 to = mesh_.points[third] - mesh_.points[i];
      const double x = to.dot(u), y = to.dot(v), across = std::hypot(x, y);
      height = std::max(height, across);
      if (!(across > 0)) continue;
      const double least = -(k * to.dot(axis) + mesh_.radius[third] - a[3]) / (s * across);
      if (least >= 1) continue;
      const double half = std::acos(std::max(least, -1.0));
      arcs.push_back({std::atan2(y, x) - half, 2 * half});
    }
    uncovered(arcs, rest);
    const double radius = std::max((a[3] + b[3]) / 2, kLeastRim * height);
    for (const Arc& arc : rest) {
      if (arc.width < 1e-3) continue;
      const double w = length * radius * s / 2, p = arc.from, q = arc.from + arc.width;
      // Integrals of 1, cos, sin, cos^2, sin^2 and cos sin over the arc.
      const double one = arc.width, c1 = std::sin(q) - std::sin(p), s1 = std::cos(p) - std::cos(q),
                   c2 = one / 2 + (std::sin(2 * q) - std::sin(2 * p)) / 4, s2 = one - c2,
                   cs = (std::cos(2 * p) - std::cos(2 * q)) / 4;
      Vec4 n0{k * axis[0], k * axis[1], k * axis[2], 1}, nu{s * u[0], s * u[1], s * u[2], 0},
          nv{s * v[0], s * v[1], s * v[2], 0};
      const Mat4 m = one * n0 * n0.transpose() + c1 * (n0 * nu.transpose() + nu * n0.transpose()) +
                     s1 * (n0 * nv.transpose() + nv * n0.transpose()) + c2 * nu * nu.transpose() +
                     s2 * nv * nv.transpose() + cs * (nu * nv.transpose() + nv * nu.transpose());
      quadric.a += w * m;
      quadric.b += w * (m * a);
      quadric.c += w * a.dot(m * a);
      quadric.weight += w * one;
    }
  }

  /// What its neighbours leave of a ball, in so many directions.
  void add_cap(std::uint32_t v, std::span<const std::uint32_t> neighbours, std::span<const Vec3> directions,
               Quadric& quadric) const {
    const Vec4 a = ball(v);
    double length = 0;
    for (const std::uint32_t w : neighbours) length = std::max(length, (mesh_.points[w] - mesh_.points[v]).norm());
    const double radius = std::max(a[3], kLeastRim * length);
    const double area = 2 * kTurn * radius * radius / static_cast<double>(directions.size());
    for (const Vec3& n : directions) {
      const bool covered = std::ranges::any_of(neighbours, [&](std::uint32_t w) {
        return n.dot(mesh_.points[w] - mesh_.points[v]) + mesh_.radius[w] - a[3] > 0;
      });
      if (!covered) quadric.add_plane({n[0], n[1], n[2], 1}, a, area);
    }
  }

 private:
  const MedialAxis& mesh_;
  std::vector<std::uint32_t> first_, faces_;  // around each edge
};

/// Evenly over the sphere, along a spiral.
std::vector<Vec3> spiral_directions(int count) {
  std::vector<Vec3> list;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, angle = i * kTurn * (std::numbers::phi - 1), s = std::sqrt(1 - z * z);
    list.emplace_back(s * std::cos(angle), s * std::sin(angle), z);
  }
  return list;
}

}  // namespace

std::vector<Quadric> envelope_quadrics(const MedialAxis& mesh, Context*) {
  const CellComplex& c = mesh.complex;
  const Patches patches(mesh);
  std::vector<Quadric> of_face(c.face_count()), of_edge(c.edges.size()), of_vertex(c.vertex_count);
  base::for_indices(c.face_count(), [&](std::size_t f) { patches.add_slab(static_cast<std::uint32_t>(f), of_face[f]); });
  base::for_indices(c.edges.size(), [&](std::size_t e) {
    thread_local std::vector<Arc> arcs, rest;
    patches.add_cone(static_cast<std::uint32_t>(e), of_edge[e], arcs, rest);
  });
  // Cells around each vertex.
  std::vector<std::uint32_t> first(c.vertex_count + 1, 0), at;
  for (const auto& [a, b] : c.edges) ++first[a + 1], ++first[b + 1];
  for (std::uint32_t v = 0; v < c.vertex_count; ++v) first[v + 1] += first[v];
  at = first;
  std::vector<std::uint32_t> neighbours(2 * c.edges.size());
  for (const auto& [a, b] : c.edges) neighbours[at[a]++] = b, neighbours[at[b]++] = a;
  const std::vector<Vec3> directions = spiral_directions(32);
  base::for_indices(c.vertex_count, [&](std::size_t v) {
    const std::span around(neighbours.data() + first[v], neighbours.data() + first[v + 1]);
    patches.add_cap(static_cast<std::uint32_t>(v), around, directions, of_vertex[v]);
  });
  for (std::size_t e = 0; e < c.edges.size(); ++e)
    if (of_edge[e].weight > 0)
      for (const std::uint32_t v : c.edges[e]) of_vertex[v] += of_edge[e];
  for (std::size_t f = 0; f < c.face_count(); ++f)
    if (of_face[f].weight > 0)
      for (const std::uint32_t v : c.corners(f)) of_vertex[v] += of_face[f];
  return of_vertex;
}

}  // namespace quench::simplification
