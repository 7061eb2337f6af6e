// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

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

MedialAxis medial_axis(const VoxelShape& shape, const Surface& surface, std::optional<double> detail,
                       Context* context) {
  return base::in_arena(context, [&] {
    MedialAxis axis = voxel_core(shape, {}, context);
    add_detail(axis, surface, context);
    prune_levels(axis, kDetail, context);
    const double wanted = detail.value_or(auto_detail(shape.grid())),
                 first = std::min(wanted, auto_detail(shape.grid()));
    const ContactSites contacts = contact_sites(axis, first, kDetail);
    axis = pruned(std::move(axis), first, kDetail);
    fit_to_surface(axis, contacts, surface, context);
    return pruned(std::move(axis), wanted, kDetail);
  });
}

}  // namespace quench
