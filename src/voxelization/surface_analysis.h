// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "quench/voxelize.h"

namespace quench::voxelization {

/// Combinatorics of a surface after welding its vertices by exact position (-0 equals 0).
struct SurfaceAnalysis {
  SurfaceTopology topology;
  std::int64_t boundary_edges = 0;  ///< edges with exactly one non-degenerate face
  std::int64_t odd_edges = 0;  ///< edges with an odd number of faces; 0: every scanline has an even number of crossings
  std::int64_t unbalanced_edges =
      0;  ///< edges with more faces in one direction than in the other; 0: all winding numbers return to 0
  std::int64_t degenerate_faces = 0;  ///< with two corners at the same place
};

/// Throws Error(input) when a triangle refers to a point that does not exist, Error(failed) above 2^32 corners.
SurfaceAnalysis analyze_surface(const TriangleMesh& mesh);

/// The faces with every corner replaced by the first point at the same place, without those with two equal corners.
/// Throws Error(input) when a triangle refers to a point that does not exist.
std::vector<std::array<std::uint32_t, 3>> welded_faces(const TriangleMesh& mesh);

/// Throws the Error(input) for a triangle that refers to a point which does not exist.
[[noreturn]] void refuse_corner(const TriangleMesh& mesh, std::size_t triangle, std::uint32_t point);

}  // namespace quench::voxelization
