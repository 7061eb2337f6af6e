// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "quench/context.h"
#include "quench/shape.h"

/// Volumes in chunks of one size, as Zarr, N5 and HDF5 store them.
namespace quench::io {

/// Which chunk along x, y, z.
using ChunkIndex = std::array<std::int64_t, 3>;

struct ChunkedVolume {
  Grid grid;
  Coordinates coordinates;
  std::string spacing_source;  ///< as of a Volume
  SampleType type = SampleType::uint8;
  std::array<std::int64_t, 3> chunk{1, 1, 1};  ///< samples of a chunk along x, y, z; those at the far sides of the grid
                                               ///< have as many, and what is beyond the grid is not looked at
  std::array<std::byte, 8> fill{};             ///< the sample where no chunk is, in the byte order of the machine
  /// Whether a chunk is there. Asked once per chunk, layer after layer (z ascending).
  std::function<bool(const ChunkIndex&)> exists;
  /// Fills in all samples of a chunk that is there: x fastest, in the byte order of the machine. Throws Error.
  std::function<void(const ChunkIndex&, std::span<std::byte>)> read;
};

/// The slices. Memory: the chunks of one layer that are there, and a slice, which the caller has. Throws Error(input)
/// for sides that cannot be, Error(failed) where memory is short, also later, from layer to layer. `file` is named in
/// errors.
SliceStream open_chunks(const std::filesystem::path& file, const ChunkedVolume& volume, Context* context);

}  // namespace quench::io
