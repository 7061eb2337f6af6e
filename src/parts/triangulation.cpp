// SPDX-License-Identifier: Apache-2.0
#include "parts/triangulation.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/csr.h"
#include "base/parallel.h"

namespace quench::parts {
namespace {

using Corner3 = std::array<std::uint32_t, 3>;

// Vertices that an edge joins with each.
class Neighbours {
 public:
  explicit Neighbours(const CellComplex& complex)
      : of_(base::Csr<std::uint32_t>::group(complex.vertex_count, [&](const auto& emit) {
          for (const auto& [a, b] : complex.edges) emit(a, b), emit(b, a);
        })) {}
  bool joined(std::uint32_t a, std::uint32_t b) const {
    if (of_[a].size() > of_[b].size()) std::swap(a, b);
    return std::ranges::find(of_[a], b) != of_[a].end();
  }

 private:
  base::Csr<std::uint32_t> of_;
};

class EarCutter {
 public:
  EarCutter(std::span<const Vec3> points, const Neighbours& neighbours) : points_(points), neighbours_(neighbours) {}

  /// The triangles of a polygon; false where no ears are left whose diagonals are free.
  bool cut(std::span<const std::uint32_t> corners, std::vector<Corner3>& triangles) {
    triangles.clear();
    left_.assign(corners.begin(), corners.end());
    if (left_.size() == 3) {
      triangles.push_back({left_[0], left_[1], left_[2]});
      return true;
    }
    project();
    while (left_.size() > 3) {
      const std::size_t ear = best_ear();
      if (ear == left_.size()) return false;
      triangles.push_back({left_[before(ear)], left_[ear], left_[after(ear)]});
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
      at_.erase(at_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({left_[0], left_[1], left_[2]});
    return twice_area(at_[0], at_[1], at_[2]) > 0;
  }

 private:
  using Vec2 = Eigen::Vector2d;
  std::size_t before(std::size_t i) const { return i == 0 ? left_.size() - 1 : i - 1; }
  std::size_t after(std::size_t i) const { return i + 1 == left_.size() ? 0 : i + 1; }
  static double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }

  // Onto the plane across its area vector.
  void project() {
    const Vec3& origin = points_[left_[0]];
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 2; i < left_.size(); ++i)
      area += (points_[left_[i - 1]] - origin).cross(points_[left_[i]] - origin);
    const Vec3 across = area.norm() > 0 ? Vec3(area.normalized()) : Vec3(Vec3::UnitZ());
    const Vec3 u = across.unitOrthogonal(), v = across.cross(u);
    at_.clear();
    for (const std::uint32_t c : left_) at_.emplace_back(u.dot(points_[c] - origin), v.dot(points_[c] - origin));
  }

  // That with the largest of the least angles, by twice the area over the square of the longest side.
  std::size_t best_ear() const {
    constexpr double kFlat = 1e-9;
    std::size_t best = left_.size();
    double most = kFlat;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const Vec2 &a = at_[before(i)], &b = at_[i], &c = at_[after(i)];
      const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
      const double shape = twice_area(a, b, c) / longest;
      if (!(shape > most) || neighbours_.joined(left_[before(i)], left_[after(i)]) || holds_corner(i)) continue;
      best = i;
      most = shape;
    }
    return best;
  }
  bool holds_corner(std::size_t ear) const {
    const std::size_t p = before(ear), n = after(ear);
    const Vec2 &a = at_[p], &b = at_[ear], &c = at_[n];
    const double room = 1e-9 * (c - a).squaredNorm();
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (i == p || i == ear || i == n) continue;
      if (twice_area(c, a, at_[i]) > -room && twice_area(a, b, at_[i]) >= 0 && twice_area(b, c, at_[i]) >= 0)
        return true;
    }
    return false;
  }

  std::span<const Vec3> points_;
  const Neighbours& neighbours_;
  std::vector<std::uint32_t> left_;
  std::vector<Vec2> at_;
};

struct FaceDiagonal {
  std::uint32_t a, b, face;
  auto operator<=>(const FaceDiagonal&) const = default;
};

}  // namespace

Triangulation triangulated(const CellComplex& complex, std::span<const Vec3> points) {
  const std::size_t faces = complex.face_count();
  // A face of k corners has k - 2 triangles, or k around a middle.
  const auto place = [&](std::size_t f) { return std::size_t{complex.face_offsets[f]} - 2 * f; };
  std::vector<Corner3> ears(faces > 0 ? place(faces) : 0);
  std::vector<char> around_middle(faces, 0);
  const Neighbours neighbours(complex);
  const std::size_t chunks = base::chunks_for(faces, 4096);
  std::vector<std::vector<FaceDiagonal>> found(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    EarCutter cutter(points, neighbours);
    std::vector<Corner3> triangles;
    const auto [first, last] = base::part_of(faces, chunk, chunks);
    for (std::size_t f = first; f < last; ++f) {
      if (!cutter.cut(complex.corners(f), triangles)) {
        around_middle[f] = 1;
        continue;
      }
      std::ranges::copy(triangles, ears.begin() + static_cast<std::ptrdiff_t>(place(f)));
      // The diagonal of every ear is between its first and last corner.
      for (std::size_t t = 0; t + 1 < triangles.size(); ++t) {
        const auto [a, b] = std::minmax(triangles[t][0], triangles[t][2]);
        found[chunk].push_back({a, b, static_cast<std::uint32_t>(f)});
      }
    }
  });
  std::vector<FaceDiagonal> diagonals;
  for (const auto& part : found) diagonals.insert(diagonals.end(), part.begin(), part.end());
  tbb::parallel_sort(diagonals);
  for (std::size_t i = 1; i < diagonals.size(); ++i)
    if (diagonals[i].a == diagonals[i - 1].a && diagonals[i].b == diagonals[i - 1].b)
      around_middle[diagonals[i].face] = 1;

  Triangulation result;
  result.triangles.reserve(ears.size());
  result.face.reserve(ears.size());
  for (std::uint32_t f = 0; f < faces; ++f) {
    const auto corners = complex.corners(f);
    if (!around_middle[f]) {
      result.triangles.insert(result.triangles.end(), ears.begin() + static_cast<std::ptrdiff_t>(place(f)),
                              ears.begin() + static_cast<std::ptrdiff_t>(place(f + 1)));
    } else {
      const auto middle = static_cast<std::uint32_t>(complex.vertex_count + result.middle_of.size());
      result.middle_of.push_back(f);
      for (std::size_t i = 0; i < corners.size(); ++i)
        result.triangles.push_back({corners[i], corners[i + 1 == corners.size() ? 0 : i + 1], middle});
    }
    result.face.resize(result.triangles.size(), f);
  }
  return result;
}

}  // namespace quench::parts
