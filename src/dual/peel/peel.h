// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dual/dual_complex.h"
#include "quench/context.h"
#include "quench/shape.h"

/// Most polytopes of the Delaunay complex inside O are small and lie along the boundary (docs/algorithms/peeling.md).
/// They are found one by one among the sites nearby, without a triangulation; what is left inside is triangulated with
/// the few sites that still have missing polytopes.
namespace quench::dual::peel {

struct Options {
  double reach = 3;         ///< largest ball that is looked for nearby, in voxels of the largest spacing; 0: unit cubes
  std::int32_t layers = 0;  ///< of a slab; 0: as suits the threads
  /// Where there are fewer polytopes of unit cubes per site the boundary is flat, and no others are looked for nearby.
  double least_cubes = 0.125;
  /// With fewer peeled polytopes per site it is not worth while, and all sites are triangulated.
  double least_polytopes = 0.25;
  /// Nor for a few sites in a huge grid, whose index would be larger than they are: blocks of 16^3 voxels of the grid
  /// beyond four per site.
  std::size_t spare_groups = std::size_t{1} << 21;

  /// `reach` in units of the integer spacing. With very different spacings a ball of a few of the largest holds too
  /// many sites to try them one by one.
  double reach_in(const std::array<std::int64_t, 3>& spacing) const {
    const auto [least, largest] = std::minmax({spacing[0], spacing[1], spacing[2]});
    return largest <= 3 * least ? reach * static_cast<double>(largest) : 0;
  }
};

/// The dual complex of the sites of a shape, whatever the options. On all threads of the arena; about 230 bytes per
/// site.
DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, const Options& options, Context* context);

}  // namespace quench::dual::peel
