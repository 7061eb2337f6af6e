// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "quench/pipeline.h"

namespace quench::pipeline {

void take_recorded(BurningOptions& options, const Record& burned) {
  if (const auto omega = field_number(burned, "omega"); omega && !options.omega) options.omega = world_length(*omega);
  options.recorded = field_text(burned, "propagation").has_value();
  if (const auto name = field_text(burned, "radius_rule"); name && !options.radius)
    options.radius = radius_rule_of(*name);
}

BurnFigures figures_of(const Burning& burning) {
  return {burning.options, burning.node_count, burning.max_burn_time, burning.unburned};
}

Burning burning_of(const MedialAxis& axis, bool voxel_core, const BurningOptions& options, bool parents,
                   const Scale& scale, Context* context) {
  BurnOptions burn_options;
  burn_options.radius = options.radius.value_or(voxel_core ? RadiusRule::exact : RadiusRule::linear);
  burn_options.parents = parents;
  burn_options.omega = options.omega ? scale.resolve(*options.omega, "omega") : 0;
  require_memory(predicted_burn_bytes(axis.complex, axis.points, burn_options),
                 fmt::format("burning with omega {}", text_of(options.omega)), {"a larger omega", "a larger lambda"},
                 context);
  return burn(axis, burn_options, context);
}

}  // namespace quench::pipeline
