// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "quench/pipeline.h"

namespace quench::pipeline {

/// What follows from the voxels of an input and, of a volume, their isosurface: cleaning, the surface that is asked
/// for, splitting of voxels, topology.
LoadedShape finished(LoadedShape&& loaded, const ShapeOptions& options, Context* context,
                     std::optional<TriangleMesh>&& isosurface = {});

}  // namespace quench::pipeline
