// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/context.h"
#include "quench/voxelize.h"

namespace quench::voxelization {

/// Fixed point: one voxel is 2^20.
inline constexpr int kFractionBits = 20;
using FixedPoint = std::array<std::int64_t, 3>;

/// A mesh in voxel units relative to the minimum of its bounding box. Coordinates are from 0 to cells * 2^20.
struct FixedMesh {
  std::vector<FixedPoint> points;
  std::span<const std::array<std::uint32_t, 3>> triangles;
  std::array<std::int64_t, 3> cells{};  ///< voxels that cover the box; at most 16384 along each axis
};

/// Part of a stage for progress: fractions from `begin` to `end`.
struct Progress {
  Context* context = nullptr;
  double begin = 0, end = 1;
  void operator()(double fraction) const { checkpoint(context, "voxelize", begin + (end - begin) * fraction); }
};

struct Digitization {
  VoxelShape shape;
  std::int64_t scanlines = 0;            ///< of the box
  std::int64_t defective_scanlines = 0;  ///< whose crossings alone do not decide: boundary edges contribute
  std::int64_t winding_voxels = 0;       ///< foreground on these
  std::int64_t sampled = 0,
               doubtful = 0;  ///< sampled foreground; of that with |w| below 3/4, or as far from an odd number
  bool overlapping = false;   ///< some voxel has a winding number beyond -1, 0, 1
};

class WindingNumber;

/// Which winding numbers, counted from -x, are inside.
enum class Inside { nonzero, odd };

/// Signed crossings of one face on the scanline from -x to the centre of a voxel: -1, 0 or 1.
int crossings_until(const FixedPoint& a, const FixedPoint& b, const FixedPoint& c,
                    const std::array<std::int64_t, 3>& voxel);

struct CapCrossings;
/// Signed crossings of all faces with the scanlines of the slice z.
CapCrossings crossings_of_slice(const FixedMesh& mesh, std::int64_t z);

/// Gauss digitization; see the definition for how ties are decided. `grid` must be that of the result: `margin` empty
/// voxels around mesh.cells. Without `winding`, crossings must return to 0 (odd: to an even number) on every scanline:
/// the boundary of the surface must be empty (odd: mod 2). With it (that of the same faces), any surface is
/// allowed: the contribution of its boundary corrects the crossings.
Digitization scan_convert(const FixedMesh& mesh, const Grid& grid, std::int64_t margin, Inside inside,
                          const WindingNumber* winding, const Progress& progress);

}  // namespace quench::voxelization
