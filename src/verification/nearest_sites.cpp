// SPDX-License-Identifier: Apache-2.0
#include "verification/nearest_sites.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace quench::verification {

namespace {

std::vector<Box> boxes(const std::vector<Point>& points) {
  std::vector<Box> result;
  result.reserve(points.size());
  for (const Point& p : points) {
    const std::array<std::int32_t, 3> q{static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]),
                                        static_cast<std::int32_t>(p[2])};
    result.push_back({q, q});
  }
  return result;
}

std::vector<Point> scale(const std::vector<LatticePoint>& lattice, const std::array<std::int64_t, 3>& factor) {
  std::vector<Point> result;
  result.reserve(lattice.size());
  for (const LatticePoint& p : lattice) result.push_back({p[0] * factor[0], p[1] * factor[1], p[2] * factor[2]});
  return result;
}

std::array<Wide, 3> difference(const Point& p, const Point& o) { return {p[0] - o[0], p[1] - o[1], p[2] - o[2]}; }
Wide dot(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
std::array<Wide, 3> cross(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

bool empty_of(const Sphere& sphere, const Ids& candidates, const Sites& sites) {
  return std::none_of(candidates.begin(), candidates.end(),
                      [&](std::uint32_t s) { return sphere.side(sites.scaled()[s]) < 0; });
}

// The sphere through the four nearest candidates that are affinely independent.
Sphere sphere_of_nearest(const Ids& candidates, const Sites& sites) {
  const auto& at = sites.scaled();
  const auto line = difference(at[candidates[1]], at[candidates[0]]);
  for (std::size_t k = 2; k < candidates.size(); ++k) {
    const auto normal = cross(line, difference(at[candidates[k]], at[candidates[0]]));
    if (dot(normal, normal) == 0) continue;
    for (std::size_t l = k + 1; l < candidates.size(); ++l) {
      const Sphere sphere(at[candidates[0]], at[candidates[1]], at[candidates[k]], at[candidates[l]]);
      if (sphere.determinant != 0) return sphere;
    }
    break;
  }
  return {};
}

// Several Voronoi vertices may be closer to each other than the tolerance: of all empty spheres through four of the
// nearest candidates the one whose centre is nearest to x.
Sphere nearest_empty_sphere(const Ids& candidates, const Sites& sites, const Vec3& x) {
  const auto& at = sites.scaled();
  const std::size_t n = std::min<std::size_t>(candidates.size(), 14);
  Sphere best;
  double best_distance = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k)
        for (std::size_t l = k + 1; l < n; ++l) {
          const Sphere sphere(at[candidates[i]], at[candidates[j]], at[candidates[k]], at[candidates[l]]);
          if (sphere.determinant == 0) continue;
          const double distance = (sphere.centre() - x).squaredNorm();
          if (best.determinant != 0 && distance >= best_distance) continue;
          if (!empty_of(sphere, candidates, sites)) continue;
          best = sphere;
          best_distance = distance;
        }
  return best;
}

}  // namespace

Sites::Sites(const VoxelShape& shape)
    : lattice_(boundary_vertices(shape)),
      scaled_(scale(lattice_, integer_spacing(shape.grid()))),
      tree_(boxes(scaled_)),
      plane_(shape.grid().is_plane()) {}

Sphere::Sphere(const Point& a, const Point& b, const Point& c, const Point& d) : origin(a) {
  const auto u = difference(b, a), v = difference(c, a), w = difference(d, a);
  const auto vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
  determinant = dot(u, vw);
  for (std::size_t i = 0; i < 3; ++i) linear[i] = dot(u, u) * vw[i] + dot(v, v) * wu[i] + dot(w, w) * uv[i];
  if (determinant >= 0) return;
  determinant = -determinant;
  for (Wide& x : linear) x = -x;
}

Wide Sphere::side(const Point& p) const {
  const auto s = difference(p, origin);
  return determinant * dot(s, s) - dot(linear, s);
}

Vec3 Sphere::centre() const {
  const double twice = 2 * static_cast<double>(determinant);
  Vec3 c;
  for (std::size_t i = 0; i < 3; ++i)
    c[static_cast<int>(i)] = static_cast<double>(origin[i]) + static_cast<double>(linear[i]) / twice;
  return c;
}

Ids voronoi_vertex(const Sites& sites, const Vec3& x, double rounding) {
  const double squared = sites.tree().nearest_squared(x), radius = std::sqrt(squared);
  const double off =
      1e-7 * radius + 2 * rounding;  // of the centre; of the distances no more, of a difference twice that
  std::vector<std::pair<double, std::uint32_t>> near;
  sites.tree().visit_within(x, squared + 5 * radius * off + 1e-9, [&](std::uint32_t s, const Box& box) {
    near.push_back({box.squared_distance(x), s});
    return true;
  });
  if (near.size() < 4) return {};
  std::sort(near.begin(), near.end());
  Ids candidates;
  for (const auto& [distance, s] : near) candidates.push_back(s);

  Sphere sphere = sphere_of_nearest(candidates, sites);
  if (sphere.determinant == 0) return {};
  if (!empty_of(sphere, candidates, sites)) sphere = nearest_empty_sphere(candidates, sites, x);
  if (sphere.determinant == 0) return {};
  if ((sphere.centre() - x).norm() > off + 1e-9) return {};
  Ids on_sphere;
  for (std::uint32_t s : candidates)
    if (sphere.side(sites.scaled()[s]) == 0) on_sphere.push_back(s);
  std::sort(on_sphere.begin(), on_sphere.end());
  return on_sphere;
}

void VertexSites::prepare(const std::vector<std::uint32_t>& vertices, Context* context) {
  Ids missing;
  for (std::uint32_t v : vertices)
    if (!known_[v]) {
      known_[v] = 1;
      missing.push_back(v);
    }
  for_indices(missing.size(), context, "verify: nearest sites", [&](std::size_t i) {
    const auto find = sites_.plane() ? voronoi_vertex_of_plane : voronoi_vertex;
    sets_[missing[i]] = find(sites_, result_.scaled[missing[i]], result_.rounding);
  });
}

Ids edge_sites(const Result& result, const VertexSites& vertex_sites, std::uint32_t edge) {
  const Ids &a = vertex_sites.at(result.complex.edges[edge][0]), &b = vertex_sites.at(result.complex.edges[edge][1]);
  Ids common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common;
}

std::vector<Ids> sites_of_edges_at(const Result& result, const VertexSites& vertex_sites, std::uint32_t vertex) {
  std::vector<Ids> sets;
  for (const std::uint32_t e : result.vertex_edges[vertex]) sets.push_back(edge_sites(result, vertex_sites, e));
  return sets;
}

Ids face_sites(const Result& result, const VertexSites& vertex_sites, std::size_t face) {
  const auto corners = result.complex.corners(face);
  Ids common = vertex_sites.at(corners[0]), next;
  for (std::uint32_t v : corners.subspan(1)) {
    const Ids& set = vertex_sites.at(v);
    next.clear();
    std::set_intersection(common.begin(), common.end(), set.begin(), set.end(), std::back_inserter(next));
    common.swap(next);
  }
  return common;
}

}  // namespace quench::verification
