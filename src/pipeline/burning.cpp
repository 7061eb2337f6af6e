// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "quench/pipeline.h"

namespace quench::pipeline {

void take_recorded(BurningOptions& options, const Record& burned) {
  if (const auto omega = field_number(burned, "omega"); omega && !options.omega) options.omega = world_length(*omega);
  if (const auto name = field_text(burned, "propagation"); name && !options.propagation)
    options.propagation = propagation_of(*name);
  if (const auto name = field_text(burned, "radius_rule"); name && !options.radius)
    options.radius = radius_rule_of(*name);
}

BurnFigures figures_of(const Burning& burning) {
  return {burning.options, burning.node_count, burning.max_burn_time, burning.unburned};
}

static BurnOptions burn_options(bool voxel_core, const BurningOptions& options, bool parents, const Scale& scale) {
  BurnOptions result;
  result.radius = options.radius.value_or(voxel_core ? RadiusRule::exact : RadiusRule::linear);
  result.propagation = options.propagation.value_or(Propagation::segments);
  result.parents = parents;
  result.rounded = true;
  result.omega = options.omega ? scale.resolve(*options.omega, "omega") : 0;
  return result;
}

Burning burning_of(const MedialAxis& axis, bool voxel_core, const BurningOptions& options, bool parents,
                   const Scale& scale, Context* context) {
  const BurnOptions wanted = burn_options(voxel_core, options, parents, scale);
  require_memory(predicted_burn_bytes(axis.complex, axis.points, wanted),
                 fmt::format("burning with omega {}", text_of(options.omega)), {"a larger omega", "a larger lambda"},
                 context);
  return burn(axis, wanted, context);
}

std::optional<Burning> kept_burning_of(const MedialAxis& axis, const Record& file, bool voxel_core,
                                       const BurningOptions& options, const Scale& scale, Context* context) {
  const BurnOptions wanted = burn_options(voxel_core, options, true, scale);
  if (field_number(file, "omega") != wanted.omega || field_text(file, "radius_rule") != name_of(wanted.radius) ||
      field_text(file, "propagation") != name_of(wanted.propagation))
    return {};
  return kept_burning(file, axis, wanted, context);
}

}  // namespace quench::pipeline
