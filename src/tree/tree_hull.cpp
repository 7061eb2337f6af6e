// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

using Lattice = std::array<std::int64_t, 3>;
__extension__ using Wide = __int128;

constexpr double kHullSteps = 0x1p26;  // the longest side of the points in steps of the lattice

Lattice minus(const Lattice& a, const Lattice& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
// Of differences of lattice points: below 2^27 each, so products are below 2^54 and their differences below 2^55.
Lattice cross(const Lattice& a, const Lattice& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// Of a cross product and a difference: below 3 * 2^55 * 2^27 < 2^84.
Wide dot(const Lattice& a, const Lattice& b) { return Wide{a[0]} * b[0] + Wide{a[1]} * b[1] + Wide{a[2]} * b[2]; }

// Convex hull by Quickhull (Barber et al. 1996): every point outside is kept by one facet that sees it; the farthest
// point of a facet is added, what it sees of the hull goes, and a cone from the point to the rim of that comes. The
// points are rounded to a lattice, and all decisions on it are exact, so the facets always bound a convex body. A point
// in the plane of a facet does not see it: then it is on no line through a side of the rim, as the facet seen there
// would hold it, and no facet without area comes up. Points of facets that go see a new facet or are inside: on the way
// from such a point into the facet that went, the new hull is entered outside of the old one. O(n log n) as a rule.
class GrowingHull {
 public:
  explicit GrowingHull(const std::vector<Vec3>& points) : given_(points) {
    if (points.empty()) return;
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double step = (high - low).maxCoeff() / kHullSteps;
    if (!(step > 0)) return;
    for (const Vec3& p : points) {
      const Vec3 x = (p - low) / step;
      points_.push_back({std::llround(x[0]), std::llround(x[1]), std::llround(x[2])});
    }
  }

  double volume() {
    if (!start()) return 0;
    for (std::uint32_t p = 0; p < points_.size(); ++p) give(p, 0);
    for (std::size_t f = 0; f < facets_.size(); ++f)  // adding appends facets
      if (!facets_[f].gone && !facets_[f].outside.empty()) add(farthest(facets_[f]), f);
    double six = 0;  // of the points as they are: the lattice decides on the facets only
    const auto at = [&](std::uint32_t p) -> Vec3 { return given_[p] - given_[0]; };
    for (const Facet& f : facets_)
      if (!f.gone) six += at(f.corner[0]).dot(at(f.corner[1]).cross(at(f.corner[2])));
    return six / 6;
  }

 private:
  struct Facet {
    std::array<std::uint32_t, 3> corner;  // counter-clockwise seen from outside
    Lattice normal;                       // outward
    std::vector<std::uint32_t> outside = {};
    bool gone = false;
  };

  // Four points that do not lie in a plane: the first that is another, off the line, and off the plane.
  bool start() {
    const auto first = [&](const auto& fits) {
      const auto found = std::ranges::find_if(points_, fits);
      return static_cast<std::uint32_t>(found - points_.begin());
    };
    const auto from = [&](std::uint32_t p) { return minus(points_[p], points_[0]); };
    const auto count = static_cast<std::uint32_t>(points_.size());
    const std::uint32_t b = first([&](const Lattice& x) { return x != points_[0]; });
    if (b == count) return false;
    const std::uint32_t c = first([&](const Lattice& x) { return cross(from(b), minus(x, points_[0])) != Lattice{}; });
    if (c == count) return false;
    const Lattice normal = cross(from(b), from(c));
    const std::uint32_t d = first([&](const Lattice& x) { return dot(normal, minus(x, points_[0])) != 0; });
    if (d == count) return false;
    std::array<std::uint32_t, 4> corner{0, b, c, d};
    if (dot(normal, from(d)) > 0) std::swap(corner[1], corner[2]);
    for (const auto [i, j, k] : {std::array{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}})
      append(corner[static_cast<std::size_t>(i)], corner[static_cast<std::size_t>(j)],
             corner[static_cast<std::size_t>(k)]);
    return true;
  }

  static std::uint64_t side(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }
  void append(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto f = static_cast<std::uint32_t>(facets_.size());
    facets_.push_back({{a, b, c}, cross(minus(points_[b], points_[a]), minus(points_[c], points_[a]))});
    for (const std::uint64_t s : {side(a, b), side(b, c), side(c, a)}) facet_at_[s] = f;
  }
  Wide height(std::uint32_t p, const Facet& f) const { return dot(f.normal, minus(points_[p], points_[f.corner[0]])); }
  std::uint32_t farthest(const Facet& f) const {
    return *std::ranges::max_element(f.outside, {}, [&](std::uint32_t p) { return height(p, f); });
  }
  // To the first facet from some one on that sees it.
  void give(std::uint32_t p, std::size_t first) {
    for (std::size_t f = first; f < facets_.size(); ++f)
      if (height(p, facets_[f]) > 0) return facets_[f].outside.push_back(p);
  }
  // `start`: a facet that p sees. What it sees hangs together.
  void add(std::uint32_t p, std::size_t start) {
    std::vector<std::size_t> seen{start};
    facets_[start].gone = true;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> rim;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const std::array<std::uint32_t, 3> corner = facets_[seen[i]].corner;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = corner[k], b = corner[(k + 1) % 3], beyond = facet_at_.at(side(b, a));
        if (facets_[beyond].gone) continue;
        if (height(p, facets_[beyond]) > 0) {
          facets_[beyond].gone = true;
          seen.push_back(beyond);
        } else {
          rim.emplace_back(a, b);
        }
      }
    }
    const std::size_t first = facets_.size();
    for (const auto& [a, b] : rim) append(a, b, p);
    for (const std::size_t f : seen) {
      const std::vector<std::uint32_t> left = std::exchange(facets_[f].outside, {});
      for (const std::uint32_t other : left)
        if (other != p) give(other, first);
    }
  }

  const std::vector<Vec3>& given_;
  std::vector<Lattice> points_;
  std::vector<Facet> facets_;                                  // in the order in which they came
  std::unordered_map<std::uint64_t, std::uint32_t> facet_at_;  // by a side: the last facet that had it
};

// The corners of the convex hull of points of a plane (Andrew 1979), without the third coordinate.
std::vector<Vec3> corners_in_plane(std::vector<Vec3> points) {
  const auto before = [](const Vec3& a, const Vec3& b) { return std::tie(a[0], a[1]) < std::tie(b[0], b[1]); };
  std::sort(points.begin(), points.end(), before);
  std::vector<Vec3> corners;
  for (const bool back : {false, true}) {
    const std::size_t first = corners.size();
    for (const Vec3& p : points) {
      while (corners.size() >= first + 2) {
        const Vec3 a = corners.back() - corners[corners.size() - 2], b = p - corners.back();
        if (a[0] * b[1] - a[1] * b[0] > 0) break;
        corners.pop_back();
      }
      corners.push_back(p);
    }
    if (!back) std::reverse(points.begin(), points.end());
  }
  return corners;
}

}  // namespace

double hull_volume(const std::vector<Vec3>& points) { return GrowingHull(points).volume(); }

double widest(std::vector<Vec3> points) {
  const std::vector<Vec3> corners = corners_in_plane(std::move(points));
  double most = 0;
  for (const Vec3& a : corners)
    for (const Vec3& b : corners) most = std::max(most, std::hypot(a[0] - b[0], a[1] - b[1]));
  return most;
}

double box_dimension(std::span<const Course> courses) {
  std::vector<Vec3> all;
  for (const Course& course : courses) all.insert(all.end(), course.points().begin(), course.points().end());
  const double whole = longest_side_of(all);
  if (!(whole > 0)) return kNotDefined;
  Vec3 low = all[0];
  for (const Vec3& p : all) low = low.cwiseMin(p);
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int parts = 8; parts <= 256; parts *= 2) {
    const double side = whole / parts;
    std::unordered_set<std::uint64_t> boxes;
    for (const Course& course : courses)
      for (std::size_t i = 0; i < course.size(); ++i) {
        const Vec3 a = course.points()[i], b = course.points()[std::min(i + 1, course.size() - 1)];
        const int steps = 1 + static_cast<int>((b - a).norm() / side * 4);
        for (int s = 0; s <= steps; ++s) {
          const Vec3 x = (a + (b - a) * s / steps - low) / side;
          std::uint64_t box = 0;
          for (int k = 0; k < 3; ++k)
            box = box * 512 + static_cast<std::uint64_t>(std::clamp(static_cast<int>(x[k]), 0, parts - 1));
          boxes.insert(box);
        }
      }
    const double x = std::log(parts), y = std::log(static_cast<double>(boxes.size()));
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace quench::tree
