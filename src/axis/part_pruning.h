// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "dual/bricks/part.h"
#include "quench/axis.h"
#include "quench/surface.h"

namespace quench::axis {

struct PartPruning {
  Grid grid;  ///< of the whole shape
  LambdaRule rule;
  std::string_view measure;  ///< kLambda or kDetail
  double cutoff;             ///< cells of this level and more must stay; for the detail not above the automatic one
  const Surface* surface;    ///< that heights are lowered to (axis/caps_on_surface.h); null: none
};

/// Takes out of a part what the pruning of the whole core certainly removes below the cutoff, but for what may be
/// needed to cover the boundary: what is left of the whole, pruned in any further parts or at once, has the levels of
/// the whole (docs/algorithms/pruning_in_parts.md). `region`: that the balls it knows lie in; `around_pending`:
/// Part::pending of all others in the region, in order. Near-linear; 500 bytes per vertex.
void prune_part(dual::bricks::Part& part, const dual::Hulls& hulls, const PartPruning& how,
                const dual::bricks::Box& region, std::span<const LatticePoint> around_pending, Context* context);

}  // namespace quench::axis
