// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "quench/context.h"
#include "quench/medial_axis.h"
#include "quench/voxel_shape.h"

namespace quench {

/// How lambda of edges and vertices follows from their sites (docs/algorithms/voxel_core.md).
enum class LambdaRule {
  coface,  ///< the largest lambda of the faces and edges around the cell: the rule behind the published results
  ball     ///< radius of the smallest ball enclosing the cell's own sites: the dissertation's definition
};

struct CoreOptions {
  LambdaRule rule = LambdaRule::coface;
  bool in_bricks = false;  ///< work on parts of the shape one after the other: less memory, the same result, slower
};

/// The voxel core: the part of the Voronoi diagram of the boundary vertices of O whose dual Delaunay cells meet O
/// (Yan 2018, Def. 2.4.1). Exact: maximal cospherical sets of sites are one vertex; no zero-length edges, zero-area or
/// duplicate faces. It has the topology of O (Thm. 2.4.3) and lies strictly inside O (Thm. 2.4.5).
///
/// Cells are ordered by the lattice coordinates of their sites, so the result does not depend on threads, translation
/// or padding. About 265 bytes per site at the peak, in bricks 250. Throws Error(input) for an empty shape or one whose
/// spacing has no integer proportion, Error(failed) when an index outgrows 32 bits.
MedialAxis voxel_core(const VoxelShape& shape, const CoreOptions& options = {}, Context* context = nullptr);

/// Predicted growth of memory, in bytes, from a voxel shape to its checked and pruned core (checked_core()) and its
/// file, beside what the process holds before, on the threads of the arena. Usually 0 to 15 % more than it takes for
/// shapes of more than 50,000 boundary vertices; what was measured stands in notes/robustness.md. Shapes with flat
/// walls and ones a voxel thick need less than others.
std::int64_t predicted_core_bytes(const VoxelShape& shape);
/// The most for so many boundary vertices.
std::int64_t predicted_core_bytes(std::int64_t sites);
/// The same with CoreOptions::in_bricks, which takes less for shapes with flat walls only.
std::int64_t predicted_core_bytes_in_bricks(const VoxelShape& shape);
/// The least for so many boundary vertices.
std::int64_t predicted_core_bytes_in_bricks(std::int64_t sites);

}  // namespace quench
