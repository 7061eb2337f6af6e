// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "voxelization/scan_conversion.h"
#include "voxelization/surface_analysis.h"

namespace quench::voxelization {

/// The Betti numbers of the solid of a closed, oriented 2-manifold, where surface components do not meet: each of them
/// bounds a component of the solid or a cavity, or lies within the solid, which the winding number outside it says; the
/// tunnels are the handles of those that bound. A single component is taken at its word, small intersections with
/// itself or not. Nothing where the surface is no 2-manifold or components meet. Exact on the rounded coordinates of
/// `fixed`. O(n log n) for evenly sized triangles.
std::optional<std::array<std::int64_t, 3>> solid_betti(const TriangleMesh& mesh, const FixedMesh& fixed,
                                                       const SurfaceAnalysis& analysis, Inside inside);

/// Whether two closed triangles, which may be degenerate, have a point in common. Exact.
bool triangles_meet(const std::array<FixedPoint, 3>& a, const std::array<FixedPoint, 3>& b);

}  // namespace quench::voxelization
