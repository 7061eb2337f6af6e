// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/pipeline.h"

namespace quench::pipeline {

/// What run() says of the thickness of a shape and of the sheets of its skeleton. `axis`: the pruned one. O(samples log n).
RunThickness thickness_of(const LoadedShape& shape, const MedialAxis& axis, const Skeleton& skeleton, Context* context);

}  // namespace quench::pipeline
