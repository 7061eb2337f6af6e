// SPDX-License-Identifier: Apache-2.0
#include "verification/polytope.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace quench::verification {

namespace {

// Differences of scaled coordinates are below 2^20, so that volumes (below 6 * 2^60) fit 64 bits.
using Vector = std::array<std::int64_t, 3>;

Vector operator-(const Point& p, const Point& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 real(const Vector& a) { return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])}; }

// Orders points of a plane with the given normal by wrapping around them; the plane is projected along its steepest
// axis, so that the turns are 2 x 2 determinants.
Ids wrap(const std::vector<Point>& at, const Ids& plane, const Vector& normal) {
  std::size_t steep = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (std::abs(normal[a]) > std::abs(normal[steep])) steep = a;
  const std::size_t u = (steep + 1) % 3, v = (steep + 2) % 3;
  const std::int64_t sign = normal[steep] > 0 ? 1 : -1;
  Ids cycle{plane[0]};
  while (cycle.size() <= plane.size()) {
    const Point& last = at[cycle.back()];
    std::uint32_t next = cycle.back();
    for (std::uint32_t s : plane) {
      if (s == cycle.back()) continue;
      const Vector to = at[s] - last, known = at[next] - last;
      if (next == cycle.back() || sign * (known[u] * to[v] - known[v] * to[u]) < 0) next = s;
    }
    if (next == plane[0]) break;
    cycle.push_back(next);
  }
  return cycle;
}

}  // namespace

Ids convex_cycle(const Sites& sites, const Ids& cocircular) {
  const auto& at = sites.scaled();
  return wrap(at, cocircular, cross(at[cocircular[1]] - at[cocircular[0]], at[cocircular[2]] - at[cocircular[0]]));
}

std::vector<Ids> sides_of_polygon(const Sites& sites, const Ids& cocircular) {
  if (cocircular.size() < 3) return {};
  const Ids cycle = convex_cycle(sites, cocircular);
  std::vector<Ids> sides;
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const std::uint32_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
    sides.push_back({std::min(a, b), std::max(a, b)});
  }
  return sides;
}

std::vector<Ids> hull_facets(const Sites& sites, const Ids& cospherical) {
  if (cospherical.size() < 4) return {};
  const auto& at = sites.scaled();
  // The nearest other site of a site on a sphere is a neighbour on the hull: the cap around the first that reaches to
  // the second is empty.
  const std::uint32_t start = cospherical[0];
  std::uint32_t neighbour = cospherical[1];
  for (std::uint32_t s : cospherical)
    if (s != start &&
        dot(at[s] - at[start], at[s] - at[start]) < dot(at[neighbour] - at[start], at[neighbour] - at[start]))
      neighbour = s;

  std::vector<Ids> facets;
  std::vector<std::array<std::uint32_t, 2>> done, open{{start, neighbour}};  // directed sides of facets
  while (!open.empty()) {
    const auto [p, q] = open.back();
    open.pop_back();
    if (std::find(done.begin(), done.end(), std::array{p, q}) != done.end()) continue;
    // Turn a plane around pq until no site is in front of it.
    const Vector pq = at[q] - at[p];
    std::uint32_t c = p;
    Vector normal{};
    for (std::uint32_t s : cospherical)
      if (s != p && s != q && (c == p || dot(normal, at[s] - at[p]) > 0)) {
        c = s;
        normal = cross(pq, at[s] - at[p]);
      }
    Ids plane;
    for (std::uint32_t s : cospherical)
      if (dot(normal, at[s] - at[p]) == 0) plane.push_back(s);
    if (plane.size() == cospherical.size()) return {};
    facets.push_back(wrap(at, plane, normal));
    const Ids& cycle = facets.back();
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const std::uint32_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
      done.push_back({a, b});
      open.push_back({b, a});
    }
    if (facets.size() > 2 * cospherical.size()) return {};  // more than Euler's formula allows: not cospherical
  }
  return facets;
}

bool LambdaOfSites::is_boundary_edge(std::uint32_t a, std::uint32_t b) const {
  const LatticePoint &p = sites_.lattice()[a], &q = sites_.lattice()[b];
  int steps = 0;
  std::size_t axis = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    steps += std::abs(p[i] - q[i]);
    if (p[i] != q[i]) axis = i;
  }
  if (steps != 1) return false;
  const bool plane = sites_.plane();
  const int around = plane ? 2 : 4;
  int inside = 0;
  for (int c = 0; c < around; ++c) {
    LatticePoint voxel{std::min(p[0], q[0]), std::min(p[1], q[1]), std::min(p[2], q[2])};
    voxel[plane ? 1 - axis : (axis + 1) % 3] -= c & 1;
    voxel[(axis + 2) % 3] -= c >> 1;
    inside += shape_.contains(voxel[0], voxel[1], voxel[2]);
  }
  return inside != 0 && inside != around;
}

bool LambdaOfSites::is_boundary_square(const Ids& cycle) const {
  if (cycle.size() != 4) return false;
  LatticePoint low = sites_.lattice()[cycle[0]], high = low;
  for (std::uint32_t s : cycle)
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], sites_.lattice()[s][a]);
      high[a] = std::max(high[a], sites_.lattice()[s][a]);
    }
  int flat_axes = 0;
  LatticePoint before = low;
  for (std::size_t a = 0; a < 3; ++a) {
    if (high[a] - low[a] > 1) return false;
    if (high[a] != low[a]) continue;
    ++flat_axes;
    --before[a];
  }
  return flat_axes == 1 && shape_.contains(low[0], low[1], low[2]) != shape_.contains(before[0], before[1], before[2]);
}

bool LambdaOfSites::has_only_boundary_edges(const Ids& cycle) const {
  for (std::size_t i = 0; i < cycle.size(); ++i)
    if (!is_boundary_edge(cycle[i], cycle[(i + 1) % cycle.size()])) return false;
  return true;
}

double LambdaOfSites::face(std::uint32_t a, std::uint32_t b) const {
  return 0.5 * unit_ * real(sites_.scaled()[a] - sites_.scaled()[b]).norm();
}

double LambdaOfSites::edge(const Ids& cycle) const {
  if (ball_rule_) return ball_of_circle(cycle);
  double largest = 0;
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const std::uint32_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
    if (!is_boundary_edge(a, b)) largest = std::max(largest, face(a, b));
  }
  return largest > 0 ? largest : ball_of_circle(cycle);
}

// The largest value of the faces and edges around the vertex; an edge around it with only boundary sides counts with
// its ball.
double LambdaOfSites::vertex(const Ids& cospherical, const std::vector<Ids>& facets) const {
  if (ball_rule_) return ball_of_sphere(cospherical, facets);
  double largest = 0;
  for (const Ids& facet : facets)
    if (!is_boundary_square(facet)) largest = std::max(largest, edge(facet));
  return largest > 0 ? largest : ball_of_sphere(cospherical, facets);
}

// The smallest ball around points of a sphere is centred at the point of their hull nearest to the sphere's centre:
// for points of a circle this is its centre, or the middle of the longest side when the centre is beyond that side.
double LambdaOfSites::ball_of_circle(const Ids& cycle) const {
  const auto& at = sites_.scaled();
  std::size_t longest = 0;
  const auto side = [&](std::size_t i) { return at[cycle[(i + 1) % cycle.size()]] - at[cycle[i]]; };
  for (std::size_t i = 1; i < cycle.size(); ++i)
    if (dot(side(i), side(i)) > dot(side(longest), side(longest))) longest = i;
  const Point &p = at[cycle[longest]], &q = at[cycle[(longest + 1) % cycle.size()]],
              &r = at[cycle[(longest + 2) % cycle.size()]];
  const Vec3 u = real(p - r), v = real(q - r);
  if (dot(p - r, q - r) <= 0) return 0.5 * unit_ * (u - v).norm();
  return unit_ * u.norm() * v.norm() * (u - v).norm() / (2 * u.cross(v).norm());
}

// For a polytope: the centre of its sphere or, outside of the hull, the nearest point of the facets. The nearer a facet
// is to the centre of the sphere, the larger is its ball.
double LambdaOfSites::ball_of_sphere(const Ids& cospherical, const std::vector<Ids>& facets) const {
  const auto& at = sites_.scaled();
  Sphere sphere;
  for (std::size_t i = 0; i < cospherical.size() && sphere.determinant == 0; ++i)
    sphere = Sphere(at[facets[0][0]], at[facets[0][1]], at[facets[0][2]], at[cospherical[i]]);
  double largest = 0;
  bool outside = false;
  for (const Ids& facet : facets) {
    const Vector normal = cross(at[facet[1]] - at[facet[0]], at[facet[2]] - at[facet[0]]),
                 to = at[facet[0]] - sphere.origin;
    Wide height = 0;  // of the centre above the facet, times 2 determinant |normal|
    for (std::size_t a = 0; a < 3; ++a) height += normal[a] * (sphere.linear[a] - 2 * sphere.determinant * to[a]);
    outside = outside || height > 0;
    largest = std::max(largest, ball_of_circle(facet));
  }
  const Vec3 from_origin(static_cast<double>(sphere.linear[0]), static_cast<double>(sphere.linear[1]),
                         static_cast<double>(sphere.linear[2]));
  return outside ? largest : unit_ * from_origin.norm() / (2 * static_cast<double>(sphere.determinant));
}

}  // namespace quench::verification
