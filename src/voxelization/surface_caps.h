// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelization/surface_edges.h"

namespace quench::voxelization {

/// A triangle that helps to close a surface.
struct CapTriangle {
  Triangle corners;
  /// Side i, from corner i to the next one, is a boundary edge of the surface; other sides are shared by two triangles.
  std::array<bool, 3> boundary;
};

/// Triangles whose boundary is that of the faces in the opposite direction: both together are closed. The boundary is
/// cut into closed paths without repeated points, and each of these is halved again and again, so that triangles are
/// small near it. Their shape does not matter. At most one triangle per boundary edge; O(n log n).
std::vector<CapTriangle> close_boundary(std::size_t points, std::span<const Triangle> welded);

}  // namespace quench::voxelization
