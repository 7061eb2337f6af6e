// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "verification/nearest_sites.h"

namespace quench::verification {

/// Ways on the boundary of a voxel shape along sides and diagonals of its squares, as seen from inside: from a boundary
/// vertex only through the voxels around it that faces connect there.
///
/// A shortest way on the surface consists of straight ones between vertices. In the plane of the squares it passes, it
/// can be followed along sides and diagonals of these. With equal steps that is at most 1.0824 times as long, the
/// largest of (1 - t + t sqrt 2) / sqrt(1 + t^2); with any steps sides alone are at most sqrt 2 times as long.
class SurfaceWays {
 public:
  SurfaceWays(const VoxelShape& shape, const Sites& sites);

  /// World units; infinite where there is no way, negative where the segment between the two does not begin inside of
  /// the shape. O(n log n) for n vertices that are nearer.
  double shortest(const LatticePoint& from, const LatticePoint& to) const;
  /// What it may be longer than the shortest way on the surface, as a factor.
  double most() const { return most_; }

 private:
  struct Place {
    std::uint32_t site, voxel;  ///< around it, as bits of larger x, y and z
  };
  std::uint32_t find(const LatticePoint& p) const;
  std::uint32_t part(std::uint32_t site, std::uint32_t voxel) const;  ///< its smallest voxel
  std::int64_t place(const LatticePoint& from, const LatticePoint& to) const;
  template <class Visit>
  void for_neighbours(std::int64_t place, const Visit& visit) const;

  const Sites& sites_;
  Vec3 step_;
  double most_;
  std::vector<std::uint8_t> mask_;                    // per site
  std::array<std::vector<std::uint32_t>, 6> beside_;  // per axis and direction
};

/// The arrays `mgf` of a core in space: of sampled polygons against these ways, of all against the straight distance,
/// of lines and points against the polygons around.
Check check_mgf_of_surface(const Result& result, const Sites& sites, std::size_t samples, Context* context);

}  // namespace quench::verification
