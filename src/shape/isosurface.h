// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/context.h"
#include "quench/shape.h"
#include "shape/surface_layers.h"

namespace quench::shape {

/// All layers of SurfaceLayers, on all threads; the samples are read by several at once.
TriangleMesh all_layers(const VoxelShape& shape, const SignedSamples* samples, Context* context);

}  // namespace quench::shape
