// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/shape.h"

namespace quench {

/// How the winding number w decides inside. Of a surface with a boundary (holes, parts that face the wrong
/// way), w is the generalized winding number (Jacobson 2013), a real number.
enum class FillRule {
  nonzero,   ///< |w| > 1/2; faces are taken as they are when the surface is closed and oriented, else repaired first
  evenodd,   ///< w rounded is odd; faces may point either way as long as every edge has an even number of them
  winding,   ///< |w| > 1/2; faces are always repaired first
  automatic  ///< one of these; fill_reason says why
};

/// Which voxels are foreground beside those whose centres are inside.
enum class TopologyRule {
  mesh,   ///< a few at the surface are put in or taken out where that gives the shape the topology of the mesh's solid
  voxels  ///< none: Gauss digitization, whatever its topology
};

struct VoxelizeOptions {
  std::int64_t resolution = 256;  ///< voxels along the longest side of the mesh's box; 1 to 16384
  FillRule fill = FillRule::nonzero;
  TopologyRule topology = TopologyRule::mesh;
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

/// Defects of a mesh, and what the repair did.
struct SurfaceDefects {
  std::int64_t open_edges = 0;           ///< with one face only
  std::int64_t unbalanced_edges = 0;     ///< with more faces along it in one direction than in the other; 0 when sound
  std::int64_t degenerate_faces = 0;     ///< two corners at one place; left out
  std::int64_t duplicate_faces = 0;      ///< left out by the repair
  std::int64_t flipped_faces = 0;        ///< turned by the repair
  std::int64_t filled_holes = 0;         ///< small ones, closed by the repair
  std::int64_t flipped_components = 0;   ///< closed parts turned as a whole
  std::int64_t scanlines = 0;            ///< of the mesh's box
  std::int64_t defective_scanlines = 0;  ///< decided by the generalized winding number, not by crossings alone
  double winding_share = 0;              ///< share of the shape's voxels on these
  double doubtful_share = 0;  ///< share of the shape's voxels with |w| below 3/4 (of some thousand samples): guesses
};

/// What TopologyRule::mesh did where the topology of the Gauss digitization is not that of the mesh's solid.
struct TopologyRepair {
  Topology before, after;               ///< of the Gauss digitization, and of the shape
  std::int64_t added = 0, removed = 0;  ///< voxels
  std::vector<Vec3> places = {};        ///< where the topology was not reached: in the world, some of what is wrong
  std::int64_t working_resolution = 0;  ///< then the smallest found at which it is; 0: none was found
};

struct Voxelization {
  VoxelShape shape;
  double longest_side = 0;  ///< of the mesh's bounding box, world units: what plain-number lengths refer to
  SurfaceTopology surface;
  /// Betti numbers of the mesh's solid. Nothing where they do not follow from its surface: it is not a closed, oriented
  /// 2-manifold, or its parts meet; and where TopologyRule::voxels does not ask for them.
  std::optional<std::array<std::int64_t, 3>> solid_betti;
  TopologyRule topology = TopologyRule::mesh;  ///< the rule asked for
  std::optional<TopologyRepair> repair;
  bool topology_known = true;         ///< false when parts overlap or the mesh is defective
  bool topology_changed = false;      ///< shape and surface disagree
  std::string topology_difference;    ///< a sentence, empty when they agree
  FillRule fill = FillRule::nonzero;  ///< the rule used: what `automatic` chose
  std::string fill_reason;            ///< why, when it was `automatic`: a clause
  bool sound = true;                  ///< crossings decided everything: the digitization is exact
  SurfaceDefects defects;
};

/// A sentence on the defects of the mesh and how they were handled; empty when it was sound.
std::string defects_text(const Voxelization& voxelization);

/// A sentence on what was put in and taken out; empty where nothing was.
std::string repair_text(const TopologyRepair& repair);

/// "mesh" or "voxels".
std::string_view topology_name(TopologyRule rule);
/// Nothing when there is no such rule.
std::optional<TopologyRule> topology_of(std::string_view name);

/// "nonzero", "evenodd", "winding" or "auto".
std::string_view fill_name(FillRule rule);
/// Nothing when there is no such rule.
std::optional<FillRule> fill_of(std::string_view name);

/// Gauss digitization of a mesh (Yan 2018, sec. 2.5): a voxel is foreground exactly when its centre is inside,
/// that is, when the winding number along its scanline is not 0 (or odd). Exact: coordinates are rounded once to
/// 2^-20 voxel, from there integers with a symbolic shift of the centre. Voxel edge h = longest side / resolution,
/// lattice 0 lies `margin` voxels below the minimum of the bounding box. O(triangles + crossings), memory O(surface).
///
/// A defective mesh (edges with one face, or faces of both directions that do not balance) is repaired: duplicates left
/// out, faces turned to agree. What its crossings then do not decide, the generalized winding number does, inside the
/// box of the mesh; see `defects` and docs/user/defective_meshes.md.
///
/// TopologyRule::mesh looks at what the Gauss digitization breaks or joins (docs/algorithms/digitization_topology.md).
/// It puts in only voxels whose open boxes the surface meets, and takes out only such.
///
/// Throws Error(input): no triangle, non-finite or flat box, or a mesh that encloses no voxel centre. Error(usage):
/// resolution or margin out of range.
Voxelization voxelize(const TriangleMesh& mesh, const VoxelizeOptions& options = {}, Context* context = nullptr);

/// The automatic resolution: the smallest of 128, 256 ... 2048 at which the topology agrees; 2048 (with the difference
/// reported) when it never does. Where parts overlap, the first resolution with the topology of the one before it.
Voxelization voxelize_auto(const TriangleMesh& mesh, VoxelizeOptions options = {}, Context* context = nullptr);

}  // namespace quench
