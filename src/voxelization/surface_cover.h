// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelization/scan_conversion.h"

namespace quench::voxelization {

/// Whether the open box of a voxel meets a closed triangle, which may be degenerate. Exact.
bool meets(const std::array<FixedPoint, 3>& triangle, const std::array<std::int64_t, 3>& voxel);

/// The voxels of the box of a mesh whose open boxes its surface meets, in order of z, y, x. A
/// surface that runs between voxels meets none of the two. 5 bytes per voxel and 4 per scanline.
struct SurfaceCover {
  std::array<std::int64_t, 3> cells{};
  std::vector<std::uint32_t> row_begin;  ///< per scanline y + cells[1] * z, and one more: offsets
  std::vector<std::int32_t> x;
  /// From the voxel's centre to the nearest of the triangles that meet it, in units of kDistanceUnit voxels.
  std::vector<std::uint8_t> distance;
  static constexpr double kDistanceUnit = 1.0 / 16;

  std::span<const std::int32_t> row(std::int64_t y, std::int64_t z) const {
    if (y < 0 || z < 0 || y >= cells[1] || z >= cells[2]) return {};
    const auto r = static_cast<std::size_t>(y + cells[1] * z);
    return {x.data() + row_begin[r], x.data() + row_begin[r + 1]};
  }
};

/// O(voxels met, once per triangle that meets them), in parallel. Throws Error(failed) for 2^32 voxels or more.
SurfaceCover surface_cover(const FixedMesh& mesh, const Progress& progress);

}  // namespace quench::voxelization
