// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_set>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

// Convex hull by Quickhull (Barber et al. 1996): of the points that a facet does not hold the farthest one is added,
// what it sees of the hull goes, and facets to the rim of that come. In doubles, with a margin: points that stick out
// by less than it are taken to be inside.
class GrowingHull {
 public:
  explicit GrowingHull(const std::vector<Vec3>& points) : points_(points) {}

  double volume() {
    if (!start()) return 0;
    for (std::uint32_t p = 0; p < points_.size(); ++p) give(p, 0);
    while (true) {
      const auto open = std::ranges::find_if(facets_, [](const Facet& f) { return !f.outside.empty(); });
      if (open == facets_.end()) break;
      add(*std::ranges::max_element(open->outside, {}, [&](std::uint32_t p) { return open->distance(points_[p]); }));
    }
    double six = 0;
    const Vec3 origin = points_[facets_[0].corner[0]];
    for (const Facet& f : facets_)
      six += (points_[f.corner[0]] - origin).dot((points_[f.corner[1]] - origin).cross(points_[f.corner[2]] - origin));
    return std::max(0.0, six / 6);
  }

 private:
  struct Facet {
    std::array<std::uint32_t, 3> corner;  // counter-clockwise seen from outside
    Vec3 normal;
    double offset;
    std::vector<std::uint32_t> outside = {};  // points that it does not hold; each has one facet

    double distance(const Vec3& x) const { return normal.dot(x) - offset; }
  };

  // Four points that do not lie in a plane: the farthest from the first, from the line, and from the plane.
  bool start() {
    if (points_.size() < 4) return false;
    const Vec3& a = points_[0];
    const auto farthest = [&](const auto& away) {
      std::uint32_t best = 0;
      for (std::uint32_t p = 1; p < points_.size(); ++p)
        if (away(points_[p]) > away(points_[best])) best = p;
      return best;
    };
    const std::uint32_t b = farthest([&](const Vec3& x) { return (x - a).norm(); });
    const Vec3 ab = points_[b] - a;
    margin_ = 1e-10 * ab.norm();
    if (!(ab.norm() > 0)) return false;
    const Vec3 along = ab.normalized();
    const std::uint32_t c = farthest([&](const Vec3& x) { return along.cross(x - a).norm(); });
    const Vec3 normal = along.cross(points_[c] - a);
    if (normal.norm() <= margin_) return false;
    const Vec3 up = normal.normalized();
    const std::uint32_t d = farthest([&](const Vec3& x) { return std::abs(up.dot(x - a)); });
    const double height = up.dot(points_[d] - a);
    if (std::abs(height) <= margin_) return false;
    std::array<std::uint32_t, 4> corner{0, b, c, d};
    if (height > 0) std::swap(corner[1], corner[2]);
    facets_ = {facet(corner[0], corner[1], corner[2]), facet(corner[0], corner[3], corner[1]),
               facet(corner[1], corner[3], corner[2]), facet(corner[2], corner[3], corner[0])};
    return true;
  }
  Facet facet(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3 normal = (points_[b] - points_[a]).cross(points_[c] - points_[a]).normalized();
    return {{a, b, c}, normal, normal.dot(points_[a])};
  }
  // To the first facet from some one on that does not hold it.
  void give(std::uint32_t p, std::size_t first) {
    for (std::size_t f = first; f < facets_.size(); ++f)
      if (facets_[f].distance(points_[p]) > margin_) return facets_[f].outside.push_back(p);
  }
  void add(std::uint32_t p) {
    const auto hidden = [&](const Facet& f) { return f.distance(points_[p]) <= margin_; };
    const auto seen = std::partition(facets_.begin(), facets_.end(), hidden);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;
    std::vector<std::uint32_t> left;
    for (auto f = seen; f != facets_.end(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) sides.emplace_back(f->corner[k], f->corner[(k + 1) % 3]);
      left.insert(left.end(), f->outside.begin(), f->outside.end());
    }
    std::sort(sides.begin(), sides.end());
    facets_.erase(seen, facets_.end());
    const std::size_t first = facets_.size();
    for (const auto& [a, b] : sides)
      if (!std::binary_search(sides.begin(), sides.end(), std::pair(b, a))) facets_.push_back(facet(a, b, p));
    for (const std::uint32_t other : left)
      if (other != p) give(other, first);
  }

  const std::vector<Vec3>& points_;
  std::vector<Facet> facets_;
  double margin_ = 0;
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
