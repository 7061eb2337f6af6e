// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace quench {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// No vertex, edge, face or other element, where an index of one stands.
inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A point of the voxel lattice. Voxel (i,j,k) is the box [i,i+1] x [j,j+1] x [k,k+1] in lattice coordinates, so its
/// centre is at (i+1/2, j+1/2, k+1/2). Of a plane: pixel (i,j) is the square [i,i+1] x [j,j+1], and z is 0 everywhere.
using LatticePoint = std::array<std::int32_t, 3>;

/// A closed or open triangle surface. No vertex needs to be used; triangles may repeat corners.
struct TriangleMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A box of voxels in the world: x = origin + direction * (spacing o (lattice - 1/2)). `origin` is the centre of voxel
/// 0, as in NRRD, NIfTI, MetaImage and MRC; `direction` is orthonormal (reflections allowed).
///
/// Of dimension 2: a rectangle of pixels in a plane. Then dims[2] is 1, lattice coordinates have z = 0 (no half is
/// taken off it), and spacing[2] is the smaller of the other two, so that the smallest of the three is the smallest
/// step; make_plane() sets both.
struct Grid {
  std::array<std::int64_t, 3> dims{0, 0, 0};  ///< voxels along x, y, z; x runs fastest in arrays
  Vec3 spacing{1, 1, 1};
  Vec3 origin{0, 0, 0};
  Mat3 direction = Mat3::Identity();
  int dimension = 3;  ///< 2: pixels

  bool is_plane() const { return dimension == 2; }
  /// The centre of voxel or pixel 0 in lattice coordinates.
  Vec3 first_centre() const { return {0.5, 0.5, is_plane() ? 0 : 0.5}; }
  /// Of a voxel or a pixel, in world units.
  double diagonal() const { return is_plane() ? spacing.head<2>().norm() : spacing.norm(); }
  /// Makes a grid of one slice that of a plane.
  void make_plane() {
    dimension = 2;
    spacing[2] = spacing[0] < spacing[1] ? spacing[0] : spacing[1];
  }

  Vec3 world(const Vec3& lattice) const { return origin + direction * spacing.cwiseProduct(lattice - first_centre()); }
  Vec3 world_of(const LatticePoint& p) const { return world(Vec3(p[0], p[1], p[2])); }
  Vec3 lattice(const Vec3& world) const {
    return (direction.transpose() * (world - origin)).cwiseQuotient(spacing) + first_centre();
  }
};

/// What a file says of its world coordinates beside the numbers; empty: nothing.
struct Coordinates {
  std::string units;  ///< of lengths, e.g. "mm"
  std::string
      space;  ///< "LPS" where x, y, z are known to grow to the left, back and head of a body; other spaces of NRRD
              ///< ("scanner-xyz", "3D-right-handed", "3D-left-handed") by their names
  bool y_down = false;  ///< of a plane: y grows downwards, as in pictures; else upwards, as on maps
  std::optional<bool> y_recorded = std::nullopt;  ///< y_down as a file of a plane says it itself (`y_axis` of NRRD)
};

/// The smallest integers proportional to `spacing` to 1e-6 relative, such that dims[i] * result[i] <= 2^20: the
/// coordinates in which all combinatorial decisions are exact (e.g. 0.782 x 0.782 x 5 gives 391 : 391 : 2500).
/// Throws Error(input), field `spacing`, when there are none.
std::array<std::int64_t, 3> integer_spacing(const Grid& grid);

/// The spacing of `grid`, or a near one that integer_spacing() takes: the smallest integers within the noise of single
/// precision (1e-5 of every step, or 1e-4 voxel over the whole grid), as in files of scanners, else the integers that
/// move the farthest voxel least, if by less than a twentieth of its size. Where there are none the spacing stays, and
/// integer_spacing() says so. `moved`: how far the farthest voxel moves, in voxels.
Vec3 nearest_integer_spacing(const Grid& grid, double* moved = nullptr);

/// The largest coordinate or radius of a medial axis: squares and sums of squares of larger numbers may overflow.
inline constexpr double kLargestLength = 1e150;

/// The longest side of the box around the points; 0 for none.
inline double longest_side_of(std::span<const Vec3> points) {
  if (points.empty()) return 0;
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).maxCoeff();
}

}  // namespace quench
