// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <limits>

#include "axis/ball_tree.h"
#include "base/parallel.h"
#include "quench/axis.h"
#include "shape/boundary_count.h"

namespace quench {
namespace {

constexpr std::size_t kRows = 1 << 14, kRowsAtOnce = 1 << 9;

// Exact distances are only found where a vertex may be above the largest so far, of all chunks.
void raise_to_distances(std::span<const LatticePoint> sites, axis::NearBalls& near, double& largest) {
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
    // A few rows at a time: all boundary vertices at once would be more than what is left of the axis.
    const std::size_t rows = shape::boundary_rows(shape), chunks = base::chunks_for(rows, kRows);
    double found = 0;
    base::for_chunks(chunks, context, "coverage", 0, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(rows, chunk, chunks);
      axis::NearBalls near(tree, shape.grid());
      for (std::size_t row = first; row < last; row += kRowsAtOnce)
        raise_to_distances(shape::boundary_vertices(shape, row, std::min(row + kRowsAtOnce, last)), near, found);
    });
    // Rounding of points and radii makes a vertex on a sphere lie outside it by this much.
    return found > 1e-9 * shape.grid().spacing.maxCoeff() ? found : 0;
  });
}

}  // namespace quench
