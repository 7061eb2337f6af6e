// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/shape.h"
#include "voxelization/scan_conversion.h"
#include "voxelization/voxel_graph.h"

namespace quench::voxelization {

struct MatchedShape {
  VoxelShape shape;
  Topology topology;
  std::int64_t added = 0, removed = 0;  ///< voxels
  std::vector<Voxel> places;            ///< where the topology was not reached: of pieces that could not be used
};

/// The shape with as few voxels of the surface's cover put in or taken out as brings its Betti numbers to those wanted,
/// or as near as is found: docs/algorithms/digitization_topology.md. `shape` is the Gauss digitization of the mesh,
/// `margin` voxels inside its grid, with the topology `before`, which is not the one wanted.
MatchedShape match_topology(const FixedMesh& mesh, const VoxelShape& shape, std::int64_t margin, const Topology& before,
                            const Betti& wanted, const Progress& progress);

}  // namespace quench::voxelization
