// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <limits>

#include "axis/ball_tree.h"
#include "base/parallel.h"
#include "quench/axis.h"

namespace quench {
namespace {

// Of the boundary vertices of a chunk. Exact distances are only found where a vertex may be above the largest so far,
// of all chunks.
void raise_to_distances(std::span<const LatticePoint> sites, const Grid& grid, const axis::BallTree& tree,
                        double& largest) {
  axis::NearBalls near(tree, grid);
  for (const LatticePoint& site : sites) {
    double away = std::numeric_limits<double>::infinity();
    const double so_far = std::atomic_ref<double>(largest).load(std::memory_order_relaxed);
    if (near.find(site, so_far, away) && away > so_far) base::raise(largest, away);
  }
}

}  // namespace

double coverage(const VoxelShape& shape, const MedialAxis& axis, Context* context) {
  if (axis.points.empty()) return std::numeric_limits<double>::infinity();
  return base::in_arena(context, [&] {
    const axis::BallTree tree(axis);
    const std::vector<LatticePoint> sites = boundary_vertices(shape);
    const std::size_t chunks = base::chunks_for(sites.size(), std::size_t{1} << 17);
    double found = 0;
    base::for_chunks(chunks, context, "coverage", 0, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(sites.size(), chunk, chunks);
      raise_to_distances({sites.data() + first, sites.data() + last}, shape.grid(), tree, found);
    });
    // Rounding of points and radii makes a vertex on a sphere lie outside it by this much.
    return found > 1e-9 * shape.grid().spacing.maxCoeff() ? found : 0;
  });
}

}  // namespace quench
