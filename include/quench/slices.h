// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "quench/image.h"
#include "quench/io.h"

namespace quench {

/// An image one slice at a time, so that it is never in memory as a whole.
struct SliceStream {
  Grid grid;
  SampleType type = SampleType::uint8;
  Coordinates coordinates;
  std::string spacing_source;  ///< as of a Volume
  /// Fills in the next slice, z ascending: dims[0] * dims[1] samples, x fastest, in the byte order of the machine.
  /// Throws Error(input) when the data end early.
  std::function<void(std::span<std::byte> slice)> next;
};

/// As foreground() of a volume. Reads the stream once; memory beyond the shape: one slice.
VoxelShape foreground(const SliceStream& image, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr);

namespace io {

/// A volume as slices where its format allows it: NRRD with its samples in the same file, raw or gzip; uncompressed
/// MetaImage and MRC; TIFF; folders of PNG or TIFF slices. Nothing for other files: read_volume() reads
/// them whole. Throws as read_volume() does.
std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options = {},
                                       Context* context = nullptr);

}  // namespace io
}  // namespace quench
