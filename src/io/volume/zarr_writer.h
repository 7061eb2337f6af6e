// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "quench/io.h"

namespace quench::io {

/// A voxel shape as write_zarr() writes volumes: 1 inside, 0 outside.
void write_shape_zarr(const std::filesystem::path& folder, const VoxelShape& shape, const Coordinates& coordinates,
                      Context* context);

}  // namespace quench::io
