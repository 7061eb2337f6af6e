// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/pipeline.h"

namespace quench::pipeline {

/// What run() says of the thickness of a shape and of the sheets of its skeleton. `axis`: the pruned one. O(samples log
/// n).
RunThickness thickness_of(const LoadedShape& shape, const MedialAxis& axis, const Skeleton& skeleton, Context* context);

/// Medial meshes of the axis of a shape, with their errors. Nothing of the plane.
void add_meshes_of(const LoadedShape& shape, const MedialAxis& axis, PageBuilder& builder, Context* context);

}  // namespace quench::pipeline
