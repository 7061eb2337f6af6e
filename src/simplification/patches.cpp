// SPDX-License-Identifier: Apache-2.0
#include "simplification/patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace quench::simplification {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Rims of sheets that end in an edge of the shape have no radius: there so much of the cells around counts as one.
constexpr double kLeastRim = 0.3;
// Shorter arcs are gaps between slabs that lie nearly in one plane.
constexpr double kLeastArc = 1e-3;
constexpr int kDirections = 32;

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

Patches::Patches(const MedialAxis& mesh) : mesh_(mesh), directions_(spiral_directions(kDirections)) {
  using Index = base::Csr<std::uint32_t>;
  const CellComplex& c = mesh.complex;
  faces_of_edge_ = Index::group(c.edges.size(), [&](const auto& emit) {
    for (std::uint32_t f = 0; f < c.face_count(); ++f)
      for (const std::uint32_t e : c.sides(f)) emit(e, f);
  });
  faces_of_vertex_ = Index::group(c.vertex_count, [&](const auto& emit) {
    for (std::uint32_t f = 0; f < c.face_count(); ++f)
      for (const std::uint32_t v : c.corners(f)) emit(v, f);
  });
  edges_of_vertex_ = Index::group(c.vertex_count, [&](const auto& emit) {
    for (std::uint32_t e = 0; e < c.edges.size(); ++e)
      for (const std::uint32_t v : c.edges[e]) emit(v, e);
  });
}

Patches::Slab Patches::slab(std::uint32_t f) const {
  const auto corners = mesh_.complex.corners(f);
  const Vec4 a = ball(corners[0]), b = ball(corners[1]) - a, c = ball(corners[2]) - a;
  const Vec3 u = b.head<3>(), v = c.head<3>(), normal = u.cross(v);
  const double twice = normal.norm();
  if (!(twice > 0)) return {};
  const Vec3 nu = normal / twice, slope = (b[3] * v.cross(nu) + c[3] * nu.cross(u)) / twice;  // of the radius
  const double rest = 1 - slope.squaredNorm();
  if (rest <= 0) return {};
  const double s = std::sqrt(rest);
  return {{s * nu - slope, -s * nu - slope}, twice / 2 * s};
}

// Leaves of a full turn what no arc covers.
void Patches::keep_uncovered(std::vector<Arc>& arcs) {
  std::vector<Arc> rest;
  if (arcs.empty()) rest.push_back({0, kTurn});
  double reach = 0;
  for (Arc& arc : arcs) {
    arc.from -= kTurn * std::floor(arc.from / kTurn);
    reach = std::max(reach, arc.from + arc.width - kTurn);
  }
  std::ranges::sort(arcs, {}, &Arc::from);
  // What begins before the turn is over reaches into the next; the last gap ends where the first arc begins.
  for (std::size_t i = 0; i <= arcs.size() && !arcs.empty(); ++i) {
    const double from = i < arcs.size() ? arcs[i].from : arcs[0].from + kTurn;
    if (i == 0) {
      reach = std::max(reach, arcs[0].from + arcs[0].width);
      continue;
    }
    if (from - reach > kLeastArc) rest.push_back({reach, from - reach});
    if (i < arcs.size()) reach = std::max(reach, from + arcs[i].width);
  }
  arcs = std::move(rest);
}

Patches::Cone Patches::cone(std::uint32_t e) const {
  const auto [i, j] = mesh_.complex.edges[e];
  const Vec4 a = ball(i), b = ball(j);
  Cone cone;
  cone.along = b.head<3>() - a.head<3>();
  const double length = cone.along.norm();
  if (!(length > std::abs(a[3] - b[3]))) return cone;
  cone.along /= length;
  cone.slope = (a[3] - b[3]) / length;
  cone.rest = std::sqrt(1 - cone.slope * cone.slope);
  cone.u = cone.along.unitOrthogonal();
  cone.v = cone.along.cross(cone.u);
  cone.area_of_radian = length * cone.rest;
  for (const std::uint32_t f : faces_of_edge_[e]) {
    std::uint32_t third = i;
    for (const std::uint32_t w : mesh_.complex.corners(f))
      if (w != i && w != j) third = w;
    const Vec3 to = mesh_.points[third] - mesh_.points[i];
    const double x = to.dot(cone.u), y = to.dot(cone.v), across = std::hypot(x, y);
    if (!(across > 0)) continue;
    cone.height = std::max(cone.height, across);
    // A direction is covered where the third ball reaches further along it.
    const double least = -(cone.slope * to.dot(cone.along) + mesh_.radius[third] - a[3]) / (cone.rest * across);
    if (least >= 1) continue;
    const double half = std::acos(std::max(least, -1.0));
    cone.arcs.push_back({std::atan2(y, x) - half, 2 * half});
  }
  keep_uncovered(cone.arcs);
  return cone;
}

bool Patches::is_covered(std::uint32_t v, const Vec3& direction) const {
  return std::ranges::any_of(edges_of_vertex_[v], [&](std::uint32_t e) {
    const auto [a, b] = mesh_.complex.edges[e];
    const std::uint32_t w = a == v ? b : a;
    return direction.dot(mesh_.points[w] - mesh_.points[v]) + mesh_.radius[w] - mesh_.radius[v] > 0;
  });
}

Quadric Patches::quadric(std::uint32_t v) const {
  Quadric quadric;
  const Vec4 here = ball(v);
  const auto tangent = [](const Vec3& n, double last) { return Vec4(n[0], n[1], n[2], last); };
  for (const std::uint32_t f : faces_of_vertex_[v]) {
    const Slab slab = this->slab(f);
    if (slab.area > 0)
      for (const Vec3& n : slab.normals) quadric.add_plane(tangent(n, 1), here, slab.area / 3);
  }
  double longest = 0;
  for (const std::uint32_t e : edges_of_vertex_[v]) {
    const auto [i, j] = mesh_.complex.edges[e];
    longest = std::max(longest, (mesh_.points[i] - mesh_.points[j]).norm());
    const Cone cone = this->cone(e);
    const double radius = std::max((mesh_.radius[i] + mesh_.radius[j]) / 2, kLeastRim * cone.height);
    for (const Arc& arc : cone.arcs) {
      // The integral of n n^T over the arc, by those of 1, cos, sin, cos^2, sin^2 and cos sin.
      const double p = arc.from, q = arc.from + arc.width;
      const double cos1 = std::sin(q) - std::sin(p), sin1 = std::cos(p) - std::cos(q),
                   cos2 = arc.width / 2 + (std::sin(2 * q) - std::sin(2 * p)) / 4, sin2 = arc.width - cos2,
                   both = (std::cos(2 * p) - std::cos(2 * q)) / 4;
      const Vec4 n = tangent(cone.slope * cone.along, 1), nu = tangent(cone.rest * cone.u, 0),
                 nv = tangent(cone.rest * cone.v, 0);
      const Mat4 half = cos1 * n * nu.transpose() + sin1 * n * nv.transpose() + both * nu * nv.transpose();
      const Mat4 whole = arc.width * n * n.transpose() + cos2 * nu * nu.transpose() + sin2 * nv * nv.transpose() +
                         half + half.transpose();
      quadric.add(whole, here, cone.area_of_radian * radius / 2, arc.width);
    }
  }
  const double radius = std::max(here[3], kLeastRim * longest);
  const double area = 2 * kTurn * radius * radius / kDirections;
  for (const Vec3& n : directions_)
    if (!is_covered(v, n)) quadric.add_plane(tangent(n, 1), here, area);
  return quadric;
}

template <class Take>
void Patches::for_patches(const Take& take) const {
  const CellComplex& c = mesh_.complex;
  for (std::uint32_t f = 0; f < c.face_count(); ++f) {
    const Slab slab = this->slab(f);
    if (!(slab.area > 0)) continue;
    const auto corners = c.corners(f);
    const Vec4 a = ball(corners[0]), b = ball(corners[1]) - a, d = ball(corners[2]) - a;
    for (const Vec3& n : slab.normals)
      take(slab.area, [&](double s, double t) {
        const Vec4 m = s + t > 1 ? Vec4(a + (1 - s) * b + (1 - t) * d) : Vec4(a + s * b + t * d);
        return Vec3(m.head<3>() + m[3] * n);
      });
  }
  for (std::uint32_t e = 0; e < c.edges.size(); ++e) {
    const Cone cone = this->cone(e);
    const Vec4 a = ball(c.edges[e][0]), b = ball(c.edges[e][1]);
    for (const Arc& arc : cone.arcs)
      take(cone.area_of_radian * (a[3] + b[3]) / 2 * arc.width, [&](double s, double t) {
        const Vec4 m = a + s * (b - a);
        const double angle = arc.from + t * arc.width;
        const Vec3 n = cone.slope * cone.along + cone.rest * (std::cos(angle) * cone.u + std::sin(angle) * cone.v);
        return Vec3(m.head<3>() + m[3] * n);
      });
  }
  for (std::uint32_t v = 0; v < c.vertex_count; ++v)
    for (const Vec3& n : directions_)
      if (mesh_.radius[v] > 0 && !is_covered(v, n))
        take(2 * kTurn * mesh_.radius[v] * mesh_.radius[v] / kDirections,
             [&](double, double) { return Vec3(mesh_.points[v] + mesh_.radius[v] * n); });
}

double Patches::area() const {
  double sum = 0;
  for_patches([&](double area, const auto&) { sum += area; });
  return sum;
}

std::vector<Vec3> Patches::points(double step) const {
  std::vector<Vec3> points;
  double until = 0;
  for_patches([&](double area, const auto& point_at) {
    until += area;
    while ((static_cast<double>(points.size()) + 0.5) * step < until) {
      // The sequence R2 (Roberts 2018).
      const double i = static_cast<double>(points.size() + 1), s = i * 0.7548776662466927, t = i * 0.5698402909980532;
      points.push_back(point_at(s - std::floor(s), t - std::floor(t)));
    }
  });
  return points;
}

}  // namespace quench::simplification
