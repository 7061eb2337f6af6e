// SPDX-License-Identifier: Apache-2.0
#include "voxelization/surface_cover.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/csr.h"
#include "quench/error.h"

// The open box B of a voxel and a closed triangle T are disjoint exactly when 0 is not inside the Minkowski difference
// of the closed box and T, which is a polytope with an inner point. The normals of its facets are among the normals of
// the box, the normal of T and the products of an edge of T with an axis: T misses B exactly when along one of these 13
// directions the two do not overlap in more than a point.
//
// Bounds. Twice the coordinates relative to the centre of the voxel: < 2^36 + 2^21 (coordinates <= 2^14 voxels = 2^34);
// edges < 2^35. Products of an edge and a corner < 2^72, the sum of two < 2^73. Components of the normal < 2^71, times
// a corner < 2^107 + 2^92, the sum of three < 2^109. Where the triangle and the voxel lie within 2^8 voxels (2^28),
// corners are < 2^30 and edges <= 2^28: the products with axes are < 2^59 and fit 64 bits, components of the normal
// < 2^57 fit too, and only the three products with the normal are taken in 128 bits.

namespace quench::voxelization {
namespace {

using Wide = __int128;
using Corners = std::array<FixedPoint, 3>;

constexpr std::int64_t kSide = std::int64_t{1} << kFractionBits;
constexpr std::int64_t kNear = std::int64_t{1} << (kFractionBits + 8);

/// Whether the intervals of the corners and of (-reach, reach) have no more than a point in common.
template <class Integer>
bool apart(Integer a, Integer b, Integer c, Integer reach) {
  return std::min({a, b, c}) >= reach || std::max({a, b, c}) <= -reach;
}

template <class Integer>
Integer magnitude(Integer v) {
  return v < 0 ? -v : v;
}

template <class Integer>
bool meets_box(const Corners& triangle, const std::array<std::int64_t, 3>& voxel) {
  std::array<std::array<Integer, 3>, 3> p, edge;  // [corner][axis], twice the coordinates from the centre; [edge][axis]
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      p[i][a] = 2 * (triangle[i][a] - voxel[a] * kSide) - kSide;
      edge[i][a] = triangle[(i + 1) % 3][a] - triangle[i][a];
    }
  for (std::size_t a = 0; a < 3; ++a)
    if (apart<Integer>(p[0][a], p[1][a], p[2][a], kSide)) return false;
  for (const auto& e : edge)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t u = (a + 1) % 3, v = (a + 2) % 3;
      const auto along = [&](std::size_t i) { return e[u] * p[i][v] - e[v] * p[i][u]; };
      if (e[u] == 0 && e[v] == 0) continue;  // no direction
      if (apart<Integer>(along(0), along(1), along(2), kSide * (magnitude(e[u]) + magnitude(e[v])))) return false;
    }
  Wide height = 0, reach = 0;
  bool flat = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t u = (a + 1) % 3, v = (a + 2) % 3;
    const Integer normal = edge[0][u] * edge[1][v] - edge[0][v] * edge[1][u];
    flat = flat || normal != 0;
    height += Wide{normal} * p[0][a];
    reach += Wide{magnitude(normal)} * kSide;
  }
  return !flat || (height < reach && height > -reach);
}

bool near(const Corners& triangle, const std::array<std::int64_t, 3>& voxel) {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto [low, high] = std::minmax({triangle[0][a], triangle[1][a], triangle[2][a], voxel[a] * kSide});
    if (high - low > kNear - kSide) return false;
  }
  return true;
}

/// From 0 to the nearest point of a triangle (Ericson 2005, sec. 5.1.5).
double distance_to(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) return a.norm();
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return b.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return (a + d1 / (d1 - d3) * ab).norm();
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) return c.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return (a + d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && d4 - d3 + d5 - d6 > 0)
    return (b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b)).norm();
  const double sum = va + vb + vc;
  if (!(sum > 0)) return std::min({a.norm(), b.norm(), c.norm()});  // a degenerate triangle
  return (a + ab * (vb / sum) + ac * (vc / sum)).norm();
}

/// A convex polygon, in voxels. Of a triangle clipped four times: a clip adds at most half of the corners.
struct Polygon {
  std::array<Vec3, 16> corner;
  std::size_t count = 0;

  void add(const Vec3& p) { corner[count++] = p; }
  std::pair<double, double> range(int axis) const {
    double low = corner[0][axis], high = low;
    for (std::size_t i = 1; i < count; ++i) {
      low = std::min(low, corner[i][axis]);
      high = std::max(high, corner[i][axis]);
    }
    return {low, high};
  }
  /// What lies on the side of `at` to which `sign` points.
  Polygon clipped(int axis, double at, double sign) const {
    Polygon result;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 &p = corner[i], &q = corner[i + 1 == count ? 0 : i + 1];
      const double s = sign * (p[axis] - at), t = sign * (q[axis] - at);
      if (s >= 0) result.add(p);
      if ((s < 0) != (t < 0)) result.add(p + s / (s - t) * (q - p));
    }
    return result;
  }
  Polygon between(int axis, double low, double high) const {
    const Polygon above = clipped(axis, low, 1);
    return above.clipped(axis, high, -1);
  }
};

/// One slice of a cover: per voxel y (upper 32 bits), x (16) and distance (16), sorted.
class SliceCover {
 public:
  SliceCover(const FixedMesh& mesh, std::int64_t z) : mesh_(mesh), z_(z) {}

  void add(std::uint32_t t) {
    for (std::size_t i = 0; i < 3; ++i) {
      corners_[i] = mesh_.points[mesh_.triangles[t][i]];
      for (int a = 0; a < 3; ++a)
        places_[i][a] = static_cast<double>(corners_[i][static_cast<std::size_t>(a)]) / static_cast<double>(kSide);
    }
    std::array<std::int64_t, 3> first{}, last{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto [low, high] = std::minmax({corners_[0][a], corners_[1][a], corners_[2][a]});
      first[a] = low >> kFractionBits;
      last[a] = ((high + kSide - 1) >> kFractionBits) - 1;
    }
    if ((last[0] - first[0]) * (last[1] - first[1]) <= 2) {
      for (std::int64_t y = first[1]; y <= last[1]; ++y) add_row(y, first[0], last[0]);
    } else {
      add_clipped();
    }
  }

  /// Sorted, the nearest distance of every voxel.
  const std::vector<std::uint64_t>& finished() {
    std::sort(found_.begin(), found_.end());
    found_.erase(
        std::unique(found_.begin(), found_.end(), [](std::uint64_t a, std::uint64_t b) { return a >> 16 == b >> 16; }),
        found_.end());
    return found_;
  }

 private:
  // The polygon is clipped to rows a little wider than the slices and scanlines of voxels, by far more than rounding
  // moves it (2^-36 voxel), so that no voxel is missed; the exact test decides at both ends of what is found. Between
  // two voxels of a scanline that a convex set meets it meets all.
  void add_clipped() {
    constexpr double kWider = 0x1p-20;
    Polygon triangle;
    for (const Vec3& p : places_) triangle.add(p);
    const double z = static_cast<double>(z_);
    const Polygon slice = triangle.between(2, z - kWider, z + 1 + kWider);
    if (slice.count == 0) return;
    const auto [y_low, y_high] = slice.range(1);
    for (double y = std::floor(y_low - kWider); y < y_high + kWider; ++y) {
      const Polygon row = slice.between(1, y - kWider, y + 1 + kWider);
      if (row.count == 0) continue;
      const auto [low, high] = row.range(0);
      add_row(static_cast<std::int64_t>(y), static_cast<std::int64_t>(std::floor(low - kWider)),
              static_cast<std::int64_t>(std::ceil(high + kWider)) - 1);
    }
  }

  void add_row(std::int64_t y, std::int64_t first, std::int64_t last) {
    if (y < 0 || y >= mesh_.cells[1]) return;
    first = std::max<std::int64_t>(first, 0);
    last = std::min(last, mesh_.cells[0] - 1);
    while (first <= last && !meets(corners_, {first, y, z_})) ++first;
    while (first < last && !meets(corners_, {last, y, z_})) --last;
    for (std::int64_t x = first; x <= last; ++x) {
      const Vec3 centre = Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z_)).array() + 0.5;
      const double d = distance_to(places_[0] - centre, places_[1] - centre, places_[2] - centre);
      const auto rounded = static_cast<std::uint64_t>(d / SurfaceCover::kDistanceUnit);
      found_.push_back(static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint64_t>(x) << 16 | rounded);
    }
  }

  const FixedMesh& mesh_;
  std::int64_t z_;
  Corners corners_{};
  std::array<Vec3, 3> places_;  ///< in voxels
  std::vector<std::uint64_t> found_;
};

}  // namespace

bool meets(const std::array<FixedPoint, 3>& triangle, const std::array<std::int64_t, 3>& voxel) {
  return near(triangle, voxel) ? meets_box<std::int64_t>(triangle, voxel) : meets_box<Wide>(triangle, voxel);
}

SurfaceCover surface_cover(const FixedMesh& mesh, const Progress& progress) {
  SurfaceCover cover;
  cover.cells = mesh.cells;
  const auto slices = static_cast<std::size_t>(mesh.cells[2]), rows = static_cast<std::size_t>(mesh.cells[1]);
  const auto of_slice = base::Csr<std::uint32_t>::group(slices, [&](const auto& emit) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const auto [low, high] = std::minmax({mesh.points[a][2], mesh.points[b][2], mesh.points[c][2]});
      for (std::int64_t z = low >> kFractionBits; z * kSide < high; ++z) emit(static_cast<std::size_t>(z), t);
    }
  });
  std::vector<std::vector<std::uint64_t>> found(slices);
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t z) {
    SliceCover slice(mesh, static_cast<std::int64_t>(z));
    for (const std::uint32_t t : of_slice[z]) slice.add(t);
    found[z] = slice.finished();
  });
  progress(1);
  std::size_t count = 0;
  for (const auto& slice : found) count += slice.size();
  if (count > 0xffffffffu)
    throw Error(ErrorCode::failed, "the surface meets more than 2^32 voxels; use a lower resolution");
  cover.x.reserve(count);
  cover.distance.reserve(count);
  cover.row_begin.reserve(slices * rows + 1);
  for (auto& slice : found) {
    auto at = slice.begin();
    for (std::size_t y = 0; y < rows; ++y) {
      cover.row_begin.push_back(static_cast<std::uint32_t>(cover.x.size()));
      for (; at != slice.end() && *at >> 32 == y; ++at) {
        cover.x.push_back(static_cast<std::int32_t>(*at >> 16 & 0xffff));
        cover.distance.push_back(static_cast<std::uint8_t>(*at & 0xff));
      }
    }
    slice = {};
  }
  cover.row_begin.push_back(static_cast<std::uint32_t>(cover.x.size()));
  return cover;
}

}  // namespace quench::voxelization
