// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "quench/burn.h"
#include "quench/complex.h"
#include "quench/geometry.h"

/// Small mixed-dimensional complexes of convex polygons in space with a radius per vertex, by hand or at random (the
/// same for the same seed).
namespace quench::testing_complexes {

/// A complex with what `burn` needs.
struct BurnInput {
  CellComplex complex;
  std::vector<Vec3> points;
  std::vector<double> radius;
  RadiusRule rule = RadiusRule::linear;
  bool consistent = false;  ///< the radius at inserted nodes is that of the place, too: no fire comes before it
};

/// Parallel edges, faces that meet an edge twice, edges of many faces and lone ones: what bounds what is at random, and
/// need not be anything in space. `in_order`: edges by their ends.
inline CellComplex any_complex(std::mt19937_64& random, bool in_order = false) {
  const auto below = [&random](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  CellComplex complex;
  complex.vertex_count = 2 + below(30);
  complex.edges.resize(1 + below(60));
  for (auto& ends : complex.edges) {
    ends[0] = below(complex.vertex_count - 1);
    ends[1] = ends[0] + 1 + below(complex.vertex_count - ends[0] - 1);
  }
  if (in_order) std::ranges::sort(complex.edges);
  for (std::uint32_t faces = below(40); faces > 0; --faces) {
    for (std::uint32_t sides = 3 + below(4); sides > 0; --sides) {
      complex.face_edges.push_back(below(complex.edges.size()));
      complex.face_vertices.push_back(complex.edges[complex.face_edges.back()][0]);
    }
    complex.face_offsets.push_back(static_cast<std::uint32_t>(complex.face_edges.size()));
  }
  return complex;
}

/// Collects cells; points by their coordinates, so that parts can be glued by naming the same point twice.
class Builder {
 public:
  std::uint32_t vertex(const Vec3& p) {
    const auto key = [](double x) { return std::llround(x * 1e7); };
    const auto [it, added] = index_.emplace(std::array{key(p[0]), key(p[1]), key(p[2])}, points.size());
    if (added) points.push_back(p);
    return static_cast<std::uint32_t>(it->second);
  }
  /// A polygon, unless there is one with these corners already or corners coincide.
  void face(std::vector<std::uint32_t> corners) {
    const std::set<std::uint32_t> key(corners.begin(), corners.end());
    if (key.size() == corners.size() && known_.insert(key).second) faces.push_back(std::move(corners));
  }
  void face(const std::vector<Vec3>& corners) {
    std::vector<std::uint32_t> c;
    for (const Vec3& p : corners) c.push_back(vertex(p));
    face(std::move(c));
  }
  void edge(std::uint32_t a, std::uint32_t b) {
    if (a != b) edges.push_back({a, b});
  }
  void polyline(const std::vector<Vec3>& line) {
    for (std::size_t i = 1; i < line.size(); ++i) edge(vertex(line[i - 1]), vertex(line[i]));
  }
  /// The parallelogram at `origin`, `nu` by `nv` cells of two triangles each, or of one polygon.
  void sheet(const Vec3& origin, const Vec3& u, const Vec3& v, int nu, int nv, bool triangles = true) {
    const auto at = [&](int i, int j) { return vertex(origin + u * (double(i) / nu) + v * (double(j) / nv)); };
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nv; ++j) {
        if (!triangles) {
          face({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        } else if ((i + j) % 2) {
          face({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          face({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        } else {
          face({at(i, j), at(i + 1, j), at(i, j + 1)});
          face({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
      }
  }
  /// Triangles from `apex` to a cycle of points, or to a path.
  void cone(std::uint32_t apex, const std::vector<std::uint32_t>& base, bool closed = true) {
    for (std::size_t i = 0; i + (closed ? 0 : 1) < base.size(); ++i) face({apex, base[i], base[(i + 1) % base.size()]});
  }
  CellComplex complex() const {
    std::vector<std::uint32_t> offsets{0}, corners;
    for (const auto& f : faces) {
      corners.insert(corners.end(), f.begin(), f.end());
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    }
    return make_complex(static_cast<std::uint32_t>(points.size()), edges, std::move(offsets), std::move(corners));
  }
  /// With a radius that is a function of the place.
  template <class Radius>
  BurnInput input(Radius&& radius, RadiusRule rule = RadiusRule::linear) const {
    BurnInput result{complex(), points, {}, rule, false};
    for (const Vec3& p : points) result.radius.push_back(radius(p));
    return result;
  }

  std::vector<Vec3> points;
  std::vector<std::vector<std::uint32_t>> faces;
  std::vector<std::array<std::uint32_t, 2>> edges;

 private:
  std::map<std::array<long long, 3>, std::size_t> index_;
  std::set<std::set<std::uint32_t>> known_;
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15ull + 7) {}
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Vec3 point(double side) {
    const double x = unit(), y = unit(), z = unit();
    return side * Vec3(x, y, z);
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 p = point(2) - Vec3::Ones();
      if (p.norm() > 0.1 && p.norm() < 1) return p.normalized();
    }
  }

 private:
  std::mt19937_64 engine_;
};

namespace parts {

// `count` triangles on few points: every link is a random graph.
inline void triangles(Builder& b, Random& random) {
  std::vector<std::uint32_t> v;
  const std::uint32_t n = 4 + random.below(6), count = 1 + random.below(3 * n / 2 + 2);
  for (std::uint32_t i = 0; i < n; ++i) v.push_back(b.vertex(random.point(4)));
  for (std::uint32_t i = 0; i < count; ++i) b.face({v[random.below(n)], v[random.below(n)], v[random.below(n)]});
}

// Sheets around a common seam, some joined at their far side, ends bent.
inline void book(Builder& b, Random& random) {
  const std::uint32_t pages = 1 + random.below(5);
  const int along = 1 + static_cast<int>(random.below(3));
  const Vec3 origin = random.point(1), seam = 3 * random.direction();
  for (std::uint32_t p = 0; p < pages; ++p)
    b.sheet(origin, seam, (1 + 2 * random.unit()) * random.direction(), along, 1 + static_cast<int>(random.below(2)));
}

// Closed fans tip to tip, some sharing rays, some joined by a bridge.
inline void cones(Builder& b, Random& random) {
  const std::uint32_t tip = b.vertex(random.point(1)), count = 1 + random.below(3);
  std::vector<std::uint32_t> all;
  for (std::uint32_t c = 0; c < count; ++c) {
    std::vector<std::uint32_t> base;
    const std::uint32_t n = 3 + random.below(3);
    for (std::uint32_t i = 0; i < n; ++i)
      base.push_back(!all.empty() && random.below(4) == 0 ? all[random.below(all.size())]
                                                          : b.vertex(b.points[tip] + 2 * random.direction()));
    b.cone(tip, base, random.below(5) > 0);
    all.insert(all.end(), base.begin(), base.end());
  }
  for (std::uint32_t i = random.below(3); i > 0; --i)
    b.face({tip, all[random.below(all.size())], all[random.below(all.size())]});
}

// Around each tip several loops of the link are joined to a tree by bridges; outer triangles delay the fire at random.
inline void bridges(Builder& b, Random& random) {
  const std::uint32_t tip = b.vertex(random.point(1)), loops = 2 + random.below(2);
  std::vector<std::vector<std::uint32_t>> base(loops);
  for (auto& ring : base) {
    for (int i = 0; i < 3; ++i) ring.push_back(b.vertex(b.points[tip] + (1 + random.unit()) * random.direction()));
    b.cone(tip, ring);
    if (random.below(2)) {
      const Vec3 middle = (b.points[ring[0]] + b.points[ring[1]] + b.points[ring[2]]) / 3;
      const std::uint32_t outer = b.vertex(middle + (middle - b.points[tip]) * (1 + random.unit()));
      b.cone(outer, ring, random.below(4) > 0);
      if (random.below(2) && b.faces.size() > 2) b.faces.erase(b.faces.end() - 1);
    }
  }
  for (std::uint32_t i = 1; i < loops; ++i) {
    const std::uint32_t from = base[random.below(i)][random.below(3)], to = base[i][random.below(3)];
    if (random.below(2)) {
      b.face({tip, from, to});
    } else {
      const std::uint32_t between = b.vertex(b.points[tip] + 2 * random.direction());
      b.face({tip, from, between});
      b.face({tip, between, to});
    }
  }
}

// Boundary of a tetrahedron or octahedron with flaps and hairs.
inline void pockets(Builder& b, Random& random) {
  const Vec3 centre = random.point(2);
  std::vector<std::uint32_t> v;
  if (random.below(2)) {
    for (int i = 0; i < 4; ++i) v.push_back(b.vertex(centre + random.point(3)));
    for (int i = 0; i < 4; ++i) b.face({v[i], v[(i + 1) % 4], v[(i + 2) % 4]});
  } else {
    for (int i = 0; i < 6; ++i)
      v.push_back(b.vertex(centre + (i % 2 ? 1.0 : -1.0) * Vec3::Unit(i / 2) + random.point(0.3)));
    for (int i = 0; i < 8; ++i) b.face({v[i & 1], v[2 + (i >> 1 & 1)], v[4 + (i >> 2)]});
  }
  const std::size_t corners = v.size();
  for (std::uint32_t i = random.below(5); i > 0; --i) {
    const std::uint32_t new_one = random.below(3) ? b.vertex(random.point(4)) : v[random.below(v.size())];
    b.face({v[random.below(corners)], v[random.below(v.size())], new_one});
    v.push_back(new_one);
  }
  for (std::uint32_t i = random.below(3); i > 0; --i) b.edge(v[random.below(v.size())], b.vertex(random.point(5)));
}

// Unit squares and a few pentagons of a small cubic grid.
inline void squares(Builder& b, Random& random) {
  const double share = 0.2 + 0.5 * random.unit();
  const std::array<int, 3> n{1 + static_cast<int>(random.below(3)), 1 + static_cast<int>(random.below(2)), 1};
  const Vec3 origin = random.point(1);
  for (int x = 0; x <= n[0]; ++x)
    for (int y = 0; y <= n[1]; ++y)
      for (int z = 0; z <= n[2]; ++z)
        for (int a = 0; a < 3; ++a) {
          const int p = (a + 1) % 3, q = (a + 2) % 3;
          const std::array<int, 3> at{x, y, z};
          if (at[p] == n[p] || at[q] == n[q] || random.unit() > share) continue;
          const Vec3 c = origin + Vec3(x, y, z), u = Vec3::Unit(p), v = Vec3::Unit(q);
          if (random.below(6) == 0) {
            b.face({c, c + u, c + 1.2 * u + 0.6 * v, c + 0.5 * u + 1.5 * v, c - 0.2 * u + 0.6 * v});
          } else {
            b.face({c, c + u, c + u + v, c + v});
          }
        }
}

// A convex polygon with 4 to 7 corners and triangles on its sides and diagonals' ends.
inline void polygon(Builder& b, Random& random) {
  const Vec3 u = random.direction(), v = u.cross(random.direction()).normalized(), centre = random.point(2);
  const std::uint32_t n = 4 + random.below(4);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.6 * random.unit()) / n;
    ring.push_back(b.vertex(centre + 2 * std::cos(angle) * u + 1.3 * std::sin(angle) * v));
  }
  b.face(ring);
  const std::uint32_t above = b.vertex(centre + u.cross(v)), below = b.vertex(centre - 0.7 * u.cross(v));
  for (std::uint32_t i = 0; i < n; ++i) {
    if (random.below(2)) b.face({above, ring[i], ring[(i + 1) % n]});
    if (random.below(3) == 0) b.face({below, ring[i], ring[(i + 1) % n]});
  }
}

}  // namespace parts

/// At least one vertex. Some are connected, some not; parts are glued at vertices that are drawn at random.
inline Builder random_cells(Random& random) {
  using Part = void (*)(Builder&, Random&);
  constexpr std::array<Part, 7> kinds{parts::triangles, parts::book,    parts::cones,  parts::bridges,
                                      parts::pockets,   parts::squares, parts::polygon};
  Builder b;
  kinds[random.below(kinds.size())](b, random);
  if (random.below(3) == 0) kinds[random.below(kinds.size())](b, random);
  if (b.points.empty()) b.vertex(random.point(6));
  for (std::uint32_t glued = random.below(4); glued > 0 && random.below(2); --glued) {
    const std::uint32_t keep = random.below(b.points.size()), drop = random.below(b.points.size());
    Builder next;  // the same cells with one vertex less
    for (const Vec3& p : b.points) next.vertex(p);
    for (auto f : b.faces) {
      std::vector<std::uint32_t> corners = f;
      // A corner of a larger polygon stays: moved, the polygon would not be planar.
      if (f.size() == 3) std::replace(corners.begin(), corners.end(), drop, keep);
      next.face(std::move(corners));
    }
    next.edges = b.edges;
    b = std::move(next);
  }
  for (std::uint32_t lone = random.below(4); lone > 0; --lone) {
    const std::uint32_t from = random.below(b.points.size());
    b.edge(from, random.below(2) ? b.vertex(random.point(6)) : random.below(b.points.size()));
  }
  if (random.below(8) == 0) b.vertex(random.point(6));
  return b;
}

/// Radii: constant; distance to one site (exact between nodes); distance to random sites, some flattened.
inline BurnInput random_input(std::uint64_t seed) {
  Random random(seed);
  const Builder b = random_cells(random);
  const std::uint32_t kind = random.below(4);
  std::vector<Vec3> sites;
  for (std::uint32_t i = kind == 1 ? 1 : 2 + random.below(4); i > 0; --i)
    sites.push_back(random.point(8) - Vec3::Constant(2));
  const double level = 0.2 + 2 * random.unit(), slope = kind == 3 ? 1 : 0.5;
  BurnInput input = b.input(
      [&](const Vec3& p) {
        if (kind == 0) return level;
        double nearest = 1e9;
        for (const Vec3& site : sites) nearest = std::min(nearest, (p - site).norm());
        return kind == 1 ? nearest : slope * nearest;
      },
      kind == 1 ? RadiusRule::exact : RadiusRule::linear);
  input.consistent = kind < 2;
  return input;
}

}  // namespace quench::testing_complexes
