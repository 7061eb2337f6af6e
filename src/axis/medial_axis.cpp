// SPDX-License-Identifier: Apache-2.0
#include "base/parallel.h"
#include "quench/axis.h"

namespace quench {

MedialAxis medial_axis(const VoxelShape& shape, std::optional<double> lambda, Context* context) {
  return base::in_arena(context, [&] {
    MedialAxis axis = voxel_core(shape, {}, context);
    prune_levels(axis, context);
    if (!lambda)
      lambda = auto_lambda(Reconstruction(shape, axis, Reconstruction::kSamples, context), shape.longest_side(),
                           shape.grid().spacing.minCoeff());
    return pruned(std::move(axis), *lambda);
  });
}

}  // namespace quench
