// SPDX-License-Identifier: Apache-2.0
#include "quench/slices.h"

#include <fmt/format.h>

#include "io/slice_streams.h"
#include "io/volume_formats.h"
#include "quench/error.h"

namespace quench::io {

void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices) {
  throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: its data end in slice {} of {}",
                                            file.string(), slice + 1, slices));
}

std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options,
                                       Context* context) {
  std::optional<SliceStream> stream;
  std::error_code error;
  const std::string extension = volume_extension(file);
  if (std::filesystem::is_directory(file, error))
    stream = open_slice_folder(file);
  else if (extension == ".tif" || extension == ".tiff")
    stream = open_tiff_pages(file, context);
  else
    stream = open_itk_slices(file, context);
  if (stream) apply_spacing(file, options, stream->grid);
  return stream;
}

}  // namespace quench::io
