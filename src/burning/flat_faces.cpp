// SPDX-License-Identifier: Apache-2.0
#include "burning/flat_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "burning/network.h"

namespace quench::burning {
namespace {

// A polygon from which ears are cut. A corner is an ear when it is convex, seen along the polygon's mean normal, and no
// other corner lies in its triangle.
class Ears {
 public:
  Ears(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> sides, std::span<const Vec3> points)
      : corners_(corners.begin(), corners.end()), sides_(sides.begin(), sides.end()), points_(points) {
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
      normal_ += (point(i) - point(0)).cross(point(i + 1) - point(0));
  }

  std::size_t size() const { return corners_.size(); }
  std::uint32_t corner(std::size_t i) const { return corners_[i % size()]; }
  std::uint32_t side(std::size_t i) const { return sides_[i % size()]; }

  /// The corner whose ear has the shortest diagonal; where there is no ear, of all corners.
  std::size_t next() const {
    std::size_t best = 0;
    std::array<double, 2> least{2, 0};
    for (std::size_t i = 0; i < size(); ++i) {
      const std::array<double, 2> key{is_ear(i) ? 0.0 : 1.0, (point(i + size() - 1) - point(i + 1)).squaredNorm()};
      if (key < least) {
        least = key;
        best = i;
      }
    }
    return best;
  }
  /// Takes the corner away; its two sides become the diagonal.
  void cut(std::size_t i, std::uint32_t diagonal) {
    sides_[(i + size() - 1) % size()] = diagonal;
    corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(i));
    sides_.erase(sides_.begin() + static_cast<std::ptrdiff_t>(i));
  }

 private:
  Vec3 point(std::size_t i) const { return points_[corner(i)]; }
  double turn(const Vec3& a, const Vec3& b, const Vec3& c) const { return (b - a).cross(c - b).dot(normal_); }
  bool is_ear(std::size_t i) const {
    const Vec3 a = point(i + size() - 1), b = point(i), c = point(i + 1);
    if (!(turn(a, b, c) > 0)) return false;
    for (std::size_t k = i + 2; k < i + size() - 1; ++k) {
      const Vec3 p = point(k);
      if (turn(a, b, p) > 0 && turn(b, c, p) > 0 && turn(c, a, p) > 0) return false;
    }
    return true;
  }

  std::vector<std::uint32_t> corners_, sides_;  // sides_[i] joins corners i and i + 1
  std::span<const Vec3> points_;
  Vec3 normal_ = Vec3::Zero();
};

}  // namespace

CellComplex with_flat_faces(const CellComplex& complex, std::span<const Vec3> points, std::span<const char> cut) {
  CellComplex result;
  result.vertex_count = complex.vertex_count;
  result.edges = complex.edges;
  const auto add = [&result](std::array<std::uint32_t, 3> corners, std::array<std::uint32_t, 3> sides) {
    result.face_vertices.insert(result.face_vertices.end(), corners.begin(), corners.end());
    result.face_edges.insert(result.face_edges.end(), sides.begin(), sides.end());
    result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
  };
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f), sides = complex.sides(f);
    if (!cut[f] || corners.size() < 4) {
      result.face_vertices.insert(result.face_vertices.end(), corners.begin(), corners.end());
      result.face_edges.insert(result.face_edges.end(), sides.begin(), sides.end());
      result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
      continue;
    }
    Ears ears(corners, sides, points);
    while (ears.size() > 3) {
      const std::size_t i = ears.next(), before = i + ears.size() - 1;
      const std::uint32_t a = ears.corner(before), b = ears.corner(i), c = ears.corner(i + 1);
      const auto diagonal = static_cast<std::uint32_t>(result.edges.size());
      result.edges.push_back({std::min(a, c), std::max(a, c)});
      add({a, b, c}, {ears.side(before), ears.side(i), diagonal});
      ears.cut(i, diagonal);
    }
    add({ears.corner(0), ears.corner(1), ears.corner(2)}, {ears.side(0), ears.side(1), ears.side(2)});
  }
  return result;
}

std::vector<char> faces_to_cut(const CellComplex& complex, std::span<const Vec3> points) {
  if (complex.face_vertices.size() == 3 * complex.face_count()) return {};
  std::vector<char> cut = flat_faces(complex, points);
  bool any = false;
  for (std::size_t f = 0; f < cut.size(); ++f) {
    cut[f] = !cut[f] && complex.corners(f).size() > 3;
    any |= cut[f] != 0;
  }
  if (!any) cut.clear();
  return cut;
}

}  // namespace quench::burning
