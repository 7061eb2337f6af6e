// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "quench/voxelize.h"

namespace quench::detail {

/// Combinatorics of a surface after welding its vertices by exact position (-0 equals 0).
struct SurfaceAnalysis {
  SurfaceTopology topology;
  std::int64_t boundary_edges = 0;                   ///< edges with exactly one non-degenerate face
  std::array<std::uint32_t, 2> one_boundary_edge{};  ///< the points of one of them
};

/// Throws Error(input) when a triangle refers to a point that does not exist, Error(failed) above 2^32 corners.
SurfaceAnalysis analyze_surface(const TriangleMesh& mesh);

/// Throws the Error(input) for a triangle that refers to a point which does not exist.
[[noreturn]] void refuse_corner(const TriangleMesh& mesh, std::size_t triangle, std::uint32_t point);

}  // namespace quench::detail
