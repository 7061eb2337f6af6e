// SPDX-License-Identifier: Apache-2.0
#include "base/parallel.h"
#include "quench/axis.h"

namespace quench {

MedialAxis medial_axis(const VoxelShape& shape, std::optional<double> detail, Context* context) {
  return base::in_arena(context, [&] {
    MedialAxis axis = voxel_core(shape, {}, context);
    add_detail(axis, context);
    prune_levels(axis, kDetail, context);
    return pruned(std::move(axis), detail.value_or(auto_detail(shape.grid())), kDetail);
  });
}

}  // namespace quench
