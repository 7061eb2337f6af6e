// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "io/volume/slice_streams.h"
#include "quench/error.h"

#ifdef QUENCH_HAS_GDCM
namespace quench::io {
SliceStream open_dicom(const std::filesystem::path&, const VolumeReadOptions&, Context*) { return {}; }
}
#else
namespace quench::io {

SliceStream open_dicom(const std::filesystem::path& path, const VolumeReadOptions&, Context*) {
  throw Error(ErrorCode::usage, fmt::format("'{}' cannot be read: DICOM needs a Quench built with GDCM (libgdcm-dev); "
                                            "convert it to NRRD or NIfTI, or rebuild",
                                            path.string()));
}

}  // namespace quench::io
#endif
