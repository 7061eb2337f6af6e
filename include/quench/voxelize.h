// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/voxel_shape.h"

namespace quench {

/// How the winding number w of a scanline decides inside (SPEC 2).
enum class FillRule { nonzero, evenodd };

struct VoxelizeOptions {
  std::int64_t resolution = 256;  ///< voxels along the longest side of the mesh's box; 1 to 16384
  FillRule fill = FillRule::nonzero;
  std::int64_t margin = 1;  ///< empty voxels around the box on every side
};

/// Topology that the solid of a closed mesh must have. Always: euler = euler(surface) / 2. When the surface is an
/// oriented 2-manifold: b1 = total genus and b0 + b2 = number of surface components, unless surfaces intersect. Where
/// parts touch in a vertex or an edge, the surface counts as separate sheets, as the open solid is separate there.
struct SurfaceTopology {
  std::int64_t euler = 0;          ///< of the solid: half that of the surface
  std::int64_t components = 0;     ///< of the surface
  bool manifold = false;           ///< every edge in exactly two faces of opposite orientation, one fan at every vertex
  std::int64_t surface_euler = 0;  ///< of the surface itself, odd ones included: open surfaces have no solid
  std::int64_t boundary_edges = 0;  ///< edges with one face only; 0 when closed
};

/// Welds by position, leaves out degenerate faces and unreferenced vertices. O(n log n).
SurfaceTopology surface_topology(const TriangleMesh& mesh);

struct Voxelization {
  VoxelShape shape;
  double longest_side = 0;  ///< of the mesh's bounding box, world units: what plain-number lengths refer to
  SurfaceTopology surface;
  bool topology_known = true;       ///< false when several parts overlap and the surfaces do not tell their union's
  bool topology_changed = false;    ///< shape and surface disagree
  std::string topology_difference;  ///< a sentence, empty when they agree
};

/// Gauss digitization of a closed mesh (Yan 2018, sec. 2.5): a voxel is foreground exactly when its centre is inside,
/// that is, when the winding number along its scanline is not 0 (or odd). Exact: coordinates are rounded once to
/// 2^-20 voxel, from there integers with a symbolic shift of the centre. Voxel edge h = longest side / resolution,
/// lattice 0 lies `margin` voxels below the minimum of the bounding box. O(triangles + crossings), memory O(surface).
///
/// Throws Error(input): no triangle, non-finite or flat box, a defective mesh (an edge with one face only, or a
/// scanline whose winding number does not return to 0; under evenodd, which ignores orientation, to an even number), or
/// a mesh that encloses no voxel centre. Error(usage): resolution or margin out of range.
Voxelization voxelize(const TriangleMesh& mesh, const VoxelizeOptions& options = {}, Context* context = nullptr);

/// `--resolution auto`: the smallest of 128, 256 ... 2048 at which the topology agrees; 2048 (with the difference
/// reported) when it never does. Where parts overlap, the first resolution with the topology of the one before it.
Voxelization voxelize_auto(const TriangleMesh& mesh, VoxelizeOptions options = {}, Context* context = nullptr);

}  // namespace quench
