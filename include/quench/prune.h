// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "quench/context.h"
#include "quench/medial_axis.h"
#include "quench/voxel_shape.h"

namespace quench {

/// Computes the level of every cell: topology-preserving thinning by simple pairs (face, free edge) or (edge, free
/// vertex) in the order (larger lambda of the pair, dimension, index); the level of a cell is the running maximum of
/// the keys when it went, infinite when it never goes. The pruning for any lambda is { level >= lambda } (Yan 2018,
/// sec. 2.6 step 3). O(n log n). Throws Error(usage) unless there is a lambda of 0 or more for every cell.
void prune_levels(MedialAxis& axis, Context* context = nullptr);

/// The pruning { level >= lambda } as a medial axis of its own (levels kept, unused sites dropped). Levels within 1e-12
/// relative below lambda count as equal, so that a length given as a multiple of the voxel size does not depend on
/// rounding. Throws Error(usage) for an axis without levels (see prune_levels()) and a lambda that is no number.
MedialAxis pruned(const MedialAxis& axis, double lambda);
/// The same in the memory of an axis that is not needed any more.
MedialAxis pruned(MedialAxis&& axis, double lambda);

/// For a sample of the voxel centres of the shape (all of them when few): up to which lambda a ball of the pruning
/// still contains the centre.
class Reconstruction {
 public:
  static constexpr std::size_t kSamples = 20000;  // a share of 98% is then known to 0.1%
  /// Deterministic; `samples` centres are taken evenly through the shape. Throws Error(usage) when a vertex of the axis
  /// has no radius or no level.
  Reconstruction(const VoxelShape& shape, const MedialAxis& axis, std::size_t samples = kSamples,
                 Context* context = nullptr);
  /// Share of the sampled centres inside the union of the balls of { level >= lambda }; in [0, 1].
  double share(double lambda) const;

 private:
  std::vector<double> covered_until_;  // sorted: largest lambda at which each centre is still covered
};

/// `--lambda auto`: the largest of 0.02*side / sqrt(2)^k not below half the smallest spacing, then 0, at which
/// share(lambda) >= 0.98. Throws Error(usage) unless the spacing is above 0 and both are finite.
double auto_lambda(const Reconstruction& reconstruction, double longest_side, double smallest_spacing);

}  // namespace quench
