// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "quench/io.h"

/// Zarr (version 2 and 3), OME-Zarr and N5.
namespace quench::io {

/// Whether it names a volume in such a folder: it, or what is before `:c=1` in its name, has the files that say so.
bool is_zarr(const std::filesystem::path& file);

/// An array: the one of the folder; the finest level of a multiscale image; of another group the only array in it, or
/// the one that N5 calls `s0`. Its place is that of the multiscale image that it is a level of. Chunks that are not
/// there have the fill value. Throws Error(input) where it is not clear which array is meant, or which section of one
/// of more than three axes: `:c=1,t=0` behind the name of the folder says it.
SliceStream open_zarr(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context);

}  // namespace quench::io
