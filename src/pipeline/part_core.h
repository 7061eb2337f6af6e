// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dual/bricks/part.h"
#include "quench/pipeline.h"

namespace quench::pipeline {

/// What core_of() makes of a shape, from the complex inside it: a part in which all is complete, pruned below the
/// threshold (by detail below the automatic one) or not at all. `from`: the shape, whose surface the pruning has seen,
/// too. CoreResult::plan is that of no work. Frees the part on the way. Throws what core_of() does, but for memory.
CoreResult core_of_part(dual::bricks::Part&& part, const dual::Hulls& hulls, const LoadedShape& from,
                        const AxisOptions& options, Context* context);

}  // namespace quench::pipeline
