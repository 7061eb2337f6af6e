// SPDX-License-Identifier: Apache-2.0
#ifndef QUENCH_HAS_ITK
#include <fmt/format.h>

#include "io/slice_streams.h"
#include "io/volume_formats.h"
#include "quench/error.h"

namespace quench::io {

Volume read_itk(const std::filesystem::path& file, Context*) {
  throw Error(ErrorCode::usage,
              fmt::format("'{}' cannot be read: NRRD, MetaImage, NIfTI and MRC need a Quench built with ITK "
                          "(libinsighttoolkit5-dev); convert it to .npy or .vol, or rebuild",
                          file.string()));
}

std::optional<SliceStream> open_itk_slices(const std::filesystem::path&, Context*) { return {}; }

}  // namespace quench::io
#endif
