// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "quench/shape.h"

/// The voxel core of a small shape straight from its definition, as an oracle: Delaunay polytopes are found one by one
/// across facets by trying all sites, all decisions are made on exact integers. O(facets * sites) and a few hundred
/// bytes per cell: milliseconds for 8^3, about a second for noise of 16^3.
namespace quench::brute_force {

__extension__ typedef __int128 Wide;
using Ids = std::vector<std::uint32_t>;

/// A core vertex: the centre of a maximal empty sphere. Its dual is the Delaunay polytope spanned by `sites`.
struct Cell {
  Ids sites;                        ///< all sites on the sphere, ascending
  std::array<Wide, 3> numerator{};  ///< exact centre in scaled lattice coordinates: numerator / denominator,
  Wide denominator = 1;             ///< positive, in lowest terms
  Vec3 position{0, 0, 0};           ///< centre, world
  double radius = 0, lambda = 0;    ///< world units; lambda by the rule `coface`
  double lambda_ball = 0;           ///< smallest ball enclosing the sites (rule `ball`)
  std::vector<Ids> facets;          ///< of the polytope, counterclockwise seen from outside
};

/// A core edge: dual of a facet shared by two polytopes inside the shape.
struct Edge {
  Ids sites;                             ///< ascending
  std::array<std::uint32_t, 2> cells{};  ///< ends, ascending
  double lambda = 0, lambda_ball = 0;
};

/// A core polygon: dual of a Delaunay edge inside the shape.
struct Face {
  std::array<std::uint32_t, 2> sites{};  ///< ascending
  Ids cells;                             ///< corners in cyclic order
  Ids edges;                             ///< edges[i] joins cells[i] and the next
  double lambda = 0;                     ///< half the distance of the sites, world units (both rules)
};

/// Cells, edges and faces are sorted by their site lists; sites are in the order of boundary_vertices().
struct Core {
  Grid grid;
  std::array<std::int64_t, 3> scale{1, 1, 1};  ///< integer_spacing
  double unit = 1;                             ///< world length of one scaled unit
  std::vector<LatticePoint> sites;
  std::vector<std::array<std::int64_t, 3>> scaled;  ///< sites times scale
  std::vector<Cell> cells;
  std::vector<Edge> edges;
  std::vector<Face> faces;
};

namespace detail {

using Point = std::array<std::int64_t, 3>;

template <class Int>
using Vector = std::array<Int, 3>;

template <class Int>
Vector<Int> difference(const Point& p, const Point& origin) {
  return {Int{p[0] - origin[0]}, Int{p[1] - origin[1]}, Int{p[2] - origin[2]}};
}
template <class Int>
Int dot(const Vector<Int>& a, const Vector<Int>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class Int>
Vector<Int> cross(const Vector<Int>& a, const Vector<Int>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Sphere through four points: with s = point - origin, `determinant` * |s|^2 - `linear` . s is negative inside, 0 on
/// the sphere. The centre is origin + linear / (2 determinant). determinant > 0 is 6 times the tetrahedron's volume.
template <class Int>
struct Sphere {
  Point origin;
  Int determinant;
  Vector<Int> linear;

  Sphere(const Point& a, const Point& b, const Point& c, const Point& d) : origin(a) {
    const auto u = difference<Int>(b, a), v = difference<Int>(c, a), w = difference<Int>(d, a);
    const auto vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
    determinant = dot(u, vw);
    for (std::size_t i = 0; i < 3; ++i) linear[i] = dot(u, u) * vw[i] + dot(v, v) * wu[i] + dot(w, w) * uv[i];
    if (determinant < 0) {
      determinant = -determinant;
      for (Int& x : linear) x = -x;
    }
  }
  Int side(const Point& p) const {
    const auto s = difference<Int>(p, origin);
    return determinant * dot(s, s) - dot(linear, s);
  }
};

/// Six times the signed volume: positive when d is on the side of the plane abc that its normal (b-a)x(c-a) points to.
inline Wide volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(cross(difference<Wide>(b, a), difference<Wide>(c, a)), difference<Wide>(d, a));
}

class Builder {
 public:
  explicit Builder(const VoxelShape& shape) : shape_(shape) {
    core_.grid = shape.grid();
    core_.scale = integer_spacing(core_.grid);
    core_.unit = core_.grid.spacing[0] / static_cast<double>(core_.scale[0]);
    core_.sites = boundary_vertices(shape);
    for (std::uint32_t i = 0; i < core_.sites.size(); ++i) {
      const LatticePoint& p = core_.sites[i];
      site_at_[p] = i;
      core_.scaled.push_back({p[0] * core_.scale[0], p[1] * core_.scale[1], p[2] * core_.scale[2]});
      for (std::int64_t x : core_.scaled.back()) extent_ = std::max(extent_, x);
    }
  }

  Core build() {
    start_at_boundary_squares();
    while (!open_.empty()) {
      const Ids facet = std::move(open_.front());
      open_.pop_front();
      cross_facet(facet);
    }
    sort_cells();
    make_edges();
    make_faces();
    compute_lambda();
    return std::move(core_);
  }

 private:
  const Point& at(std::uint32_t site) const { return core_.scaled[site]; }
  static Ids sorted(Ids ids) {
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  static void require(bool holds, const char* what) {
    if (!holds) throw std::logic_error(std::string("brute-force core: ") + what);
  }

  // Every boundary square is a Delaunay facet (Yan 2018, Thm. 2.4.1) with an inside polytope, and every inside polytope
  // is reached from one: start from all of them, with normals pointing into the shape.
  void start_at_boundary_squares() {
    const auto& d = core_.grid.dims;
    for (int axis = 0; axis < 3; ++axis)
      for (int z = 0; z <= d[2]; ++z)
        for (int y = 0; y <= d[1]; ++y)
          for (int x = 0; x <= d[0]; ++x) {
            const bool after = shape_.contains(x, y, z);
            const bool before = shape_.contains(x - (axis == 0), y - (axis == 1), z - (axis == 2));
            if (after == before) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            Ids square;
            for (int corner = 0; corner < 4; ++corner) {
              LatticePoint p{x, y, z};
              p[static_cast<std::size_t>(u)] += corner == 1 || corner == 2;
              p[static_cast<std::size_t>(v)] += corner >= 2;
              square.push_back(site_at_.at(p));
            }
            if (!after) std::reverse(square.begin(), square.end());
            boundary_squares_.insert(sorted(square));
            for (std::size_t i = 0; i < 4; ++i) boundary_edges_.insert(sorted({square[i], square[(i + 1) % 4]}));
            open_.push_back(square);
          }
  }

  // Finds the polytope on the side of the facet that its normal points to.
  void cross_facet(const Ids& facet) {
    const Ids key = sorted(facet);
    const std::size_t wanted = boundary_squares_.count(key) ? 1 : 2;
    if (facet_cells_[key].size() == wanted) return;
    // The determinants below are less than 64 * extent^5.
    const Ids sites = extent_ <= 2000 ? empty_sphere<std::int64_t>(facet) : empty_sphere<Wide>(facet);
    const auto [position, is_new] = cell_at_.try_emplace(sites, static_cast<std::uint32_t>(core_.cells.size()));
    require(is_new, "a facet does not belong to the polytope behind it");
    Cell cell;
    cell.sites = sites;
    cell.facets = hull(sites, facet);
    core_.cells.push_back(cell);
    for (const Ids& f : cell.facets) {
      const Ids k = sorted(f);
      auto& sides = facet_cells_[k];
      sides.push_back(position->second);
      require(sides.size() <= (boundary_squares_.count(k) ? 1u : 2u), "a facet has too many polytopes");
      if (!boundary_squares_.count(k)) open_.push_back(f);
    }
    require(facet_cells_[key].size() == wanted, "a polytope misses the facet it was found through");
  }

  // Among the spheres through the facet's circle and one more site in front of it, the one without sites inside; all
  // sites on it. A sphere's part in front of the facet grows with its centre, so the sites can be tried one by one.
  template <class Int>
  Ids empty_sphere(const Ids& facet) const {
    const Point &a = at(facet[0]), &b = at(facet[1]), &c = at(facet[2]);
    const auto normal = cross(difference<Int>(b, a), difference<Int>(c, a));
    std::uint32_t best = 0;
    bool found = false;
    const auto in_front = [&](const Point& p) { return dot(normal, difference<Int>(p, a)) > 0; };
    for (std::uint32_t s = 0; s < core_.scaled.size() && !found; ++s)
      if (in_front(at(s))) {
        best = s;
        found = true;
      }
    require(found, "no site in front of a facet");
    Sphere<Int> sphere(a, b, c, at(best));
    for (std::uint32_t s = best + 1; s < core_.scaled.size(); ++s)
      if (sphere.side(at(s)) < 0 && in_front(at(s))) sphere = Sphere<Int>(a, b, c, at(s));
    Ids on_sphere;
    for (std::uint32_t s = 0; s < core_.scaled.size(); ++s) {
      const Int side = sphere.side(at(s));
      require(side >= 0, "a facet is not Delaunay");
      if (side == 0) on_sphere.push_back(s);
    }
    return on_sphere;
  }

  // The facets of the convex hull of cospherical sites by gift wrapping, from a facet whose normal points inwards.
  std::vector<Ids> hull(const Ids& sites, const Ids& inward) const {
    std::vector<Ids> facets{Ids(inward.rbegin(), inward.rend())};
    std::set<std::pair<std::uint32_t, std::uint32_t>> sides;  // directed, of the facets found
    const auto add_sides = [&](const Ids& f) {
      for (std::size_t i = 0; i < f.size(); ++i)
        require(sides.insert({f[i], f[(i + 1) % f.size()]}).second, "two facets on one side of a hull edge");
    };
    add_sides(facets[0]);
    for (std::size_t next = 0; next < facets.size(); ++next)
      for (std::size_t i = 0; i < facets[next].size(); ++i) {
        const std::uint32_t q = facets[next][i], p = facets[next][(i + 1) % facets[next].size()];
        if (sides.count({p, q})) continue;
        // Turn the plane around the edge pq until no site is in front of it.
        std::uint32_t c = p;
        for (std::uint32_t s : sites)
          if (s != p && s != q && (c == p || volume(at(p), at(q), at(c), at(s)) > 0)) c = s;
        Ids plane;
        for (std::uint32_t s : sites) {
          const Wide v = volume(at(p), at(q), at(c), at(s));
          require(v <= 0, "a hull facet has a site in front");
          if (v == 0) plane.push_back(s);
        }
        facets.push_back(convex_cycle(plane, p, q, c));
        add_sides(facets.back());
      }
    return facets;
  }

  // Orders cocircular sites counterclockwise around the normal of (p, q, c), where pq is a side of their polygon.
  Ids convex_cycle(const Ids& plane, std::uint32_t p, std::uint32_t q, std::uint32_t c) const {
    const auto normal = cross(difference<Wide>(at(q), at(p)), difference<Wide>(at(c), at(p)));
    Ids cycle{p, q};
    while (true) {
      const std::uint32_t last = cycle.back();
      std::uint32_t next = last;
      for (std::uint32_t s : plane) {
        if (s == last) continue;
        if (next == last ||
            dot(normal, cross(difference<Wide>(at(next), at(last)), difference<Wide>(at(s), at(last)))) < 0)
          next = s;
      }
      if (next == p) break;
      cycle.push_back(next);
      require(cycle.size() <= plane.size(), "a facet's sites are not in convex position");
    }
    require(cycle.size() == plane.size(), "a facet's sites are not in convex position");
    return cycle;
  }

  void sort_cells() {
    std::sort(core_.cells.begin(), core_.cells.end(), [](const Cell& a, const Cell& b) { return a.sites < b.sites; });
    facet_cells_.clear();
    for (std::uint32_t i = 0; i < core_.cells.size(); ++i) {
      Cell& cell = core_.cells[i];
      for (const Ids& f : cell.facets) facet_cells_[sorted(f)].push_back(i);
      set_centre(cell);
    }
  }

  void set_centre(Cell& cell) const {
    std::size_t d = 3;
    const Ids& f = cell.facets[0];
    for (d = 0; volume(at(f[0]), at(f[1]), at(f[2]), at(cell.sites[d])) == 0;) ++d;
    const Sphere<Wide> sphere(at(f[0]), at(f[1]), at(f[2]), at(cell.sites[d]));
    cell.denominator = 2 * sphere.determinant;
    Wide common = cell.denominator;
    for (std::size_t i = 0; i < 3; ++i) {
      cell.numerator[i] = sphere.linear[i] + cell.denominator * sphere.origin[i];
      for (Wide x = cell.numerator[i] < 0 ? -cell.numerator[i] : cell.numerator[i]; x != 0;)
        common = std::exchange(x, common % x);
    }
    cell.denominator /= common;
    Vec3 lattice, from_site;
    double squared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      cell.numerator[i] /= common;
      const double divisor = static_cast<double>(cell.denominator);
      lattice[static_cast<int>(i)] =
          static_cast<double>(cell.numerator[i]) / divisor / static_cast<double>(core_.scale[i]);
      const double offset =
          static_cast<double>(cell.numerator[i] - cell.denominator * sphere.origin[i]) / divisor;  // exact difference
      squared += offset * offset;
    }
    cell.position = core_.grid.world(lattice);
    cell.radius = core_.unit * std::sqrt(squared);
  }

  void make_edges() {
    for (const auto& [key, cells] : facet_cells_) {
      const bool boundary = boundary_squares_.count(key) > 0;
      require(cells.size() == (boundary ? 1u : 2u), "a facet misses a polytope");
      if (!boundary) core_.edges.push_back({key, {cells[0], cells[1]}, 0, 0});
    }
    require(boundary_squares_.empty() || facet_cells_.size() == core_.edges.size() + boundary_squares_.size(),
            "a boundary square without polytope");
  }

  void make_faces() {
    std::map<Ids, std::uint32_t> edge_at;
    for (std::uint32_t e = 0; e < core_.edges.size(); ++e) edge_at[core_.edges[e].sites] = e;
    std::map<std::array<std::uint32_t, 2>, std::set<std::uint32_t>> around;  // hull edge: core edges around it
    for (const Cell& cell : core_.cells)
      for (const Ids& f : cell.facets) {
        const auto e = edge_at.find(sorted(f));
        for (std::size_t i = 0; i < f.size(); ++i) {
          const std::uint32_t p = f[i], q = f[(i + 1) % f.size()];
          if (boundary_edges_.count(sorted({p, q}))) continue;
          require(e != edge_at.end(), "a boundary square has an inner side");
          around[{std::min(p, q), std::max(p, q)}].insert(e->second);
        }
      }
    for (const auto& [pair, ring] : around) {
      Face face;
      face.sites = pair;
      // Walk from cell to cell through the ring of edges.
      std::uint32_t edge = *ring.begin(), cell = core_.edges[edge].cells[0];
      do {
        face.cells.push_back(cell);
        face.edges.push_back(edge);
        const auto& ends = core_.edges[edge].cells;
        cell = ends[0] == cell ? ends[1] : ends[0];
        const auto next = std::find_if(ring.begin(), ring.end(), [&](std::uint32_t e) {
          return e != edge && (core_.edges[e].cells[0] == cell || core_.edges[e].cells[1] == cell);
        });
        require(next != ring.end(), "a face is not closed");
        edge = *next;
      } while (edge != *ring.begin());
      require(face.cells.size() == ring.size() && ring.size() >= 3, "a face is not one polygon");
      face.lambda = 0.5 * core_.unit * distance(pair[0], pair[1]);
      core_.faces.push_back(std::move(face));
    }
  }

  double distance(std::uint32_t a, std::uint32_t b) const {
    const auto d = difference<std::int64_t>(at(a), at(b));
    return std::sqrt(static_cast<double>(dot(d, d)));
  }

  // The largest lambda of the cells around it; the smallest enclosing ball where there are none.
  void compute_lambda() {
    for (Edge& e : core_.edges) e.lambda_ball = smallest_ball(e.sites);
    for (Cell& c : core_.cells) c.lambda_ball = std::min(smallest_ball(c.sites), c.radius);
    for (const Face& f : core_.faces)
      for (std::uint32_t e : f.edges) core_.edges[e].lambda = std::max(core_.edges[e].lambda, f.lambda);
    for (Edge& e : core_.edges)
      if (e.lambda == 0) e.lambda = e.lambda_ball;
    for (const Face& f : core_.faces)
      for (std::uint32_t c : f.cells) core_.cells[c].lambda = std::max(core_.cells[c].lambda, f.lambda);
    for (const Edge& e : core_.edges)
      for (std::uint32_t c : e.cells) core_.cells[c].lambda = std::max(core_.cells[c].lambda, e.lambda);
    for (Cell& c : core_.cells)
      if (c.lambda == 0) c.lambda = c.lambda_ball;
  }

  // World radius of the smallest ball that encloses the sites and has two or three of them on its equator; infinite
  // when there is none (then four sites fix it: their common sphere).
  double smallest_ball(const Ids& sites) const {
    double best = INFINITY;
    const auto vec = [&](std::uint32_t s) {
      return Vec3(static_cast<double>(at(s)[0]), static_cast<double>(at(s)[1]), static_cast<double>(at(s)[2]));
    };
    const auto offer = [&](const Vec3& centre, double squared) {
      if (squared >= best) return;
      for (std::uint32_t s : sites)
        if ((vec(s) - centre).squaredNorm() > squared * (1 + 1e-12)) return;
      best = squared;
    };
    for (std::size_t i = 0; i < sites.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Vec3 p = vec(sites[i]), u = vec(sites[j]) - p;
        offer(p + u / 2, u.squaredNorm() / 4);
        for (std::size_t k = 0; k < j; ++k) {
          const Vec3 v = vec(sites[k]) - p, n = u.cross(v);
          const Vec3 centre = (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
          offer(p + centre, centre.squaredNorm());
        }
      }
    return core_.unit * std::sqrt(best);
  }

  const VoxelShape& shape_;
  Core core_;
  std::int64_t extent_ = 0;
  std::map<LatticePoint, std::uint32_t> site_at_;
  std::set<Ids> boundary_squares_;  // as sorted sites
  std::set<Ids> boundary_edges_;    // the sides of these
  std::map<Ids, std::uint32_t> cell_at_;
  std::map<Ids, Ids> facet_cells_;  // sorted sites of a facet: polytopes on its inner sides
  std::deque<Ids> open_;            // facets with their normals towards a side not yet looked at
};

}  // namespace detail

/// Throws std::logic_error when a fact the construction rests on does not hold.
inline Core voxel_core(const VoxelShape& shape) { return detail::Builder(shape).build(); }

}  // namespace quench::brute_force
