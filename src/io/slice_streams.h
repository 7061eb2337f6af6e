// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "quench/slices.h"

/// Streams of slices, one function per kind of source, behind io::open_slices. The spacing of the options is applied
/// there, not here.
namespace quench::io {

/// The PNG or TIFF files of a folder. Throws as read_slices() does.
SliceStream open_slice_folder(const std::filesystem::path& folder);

/// The pages of a TIFF file: grey, 8 to 64 bits, in strips, all pages alike. Nothing for other files (read_itk() reads
/// some of them) and where Quench was built without libtiff.
std::optional<SliceStream> open_tiff_pages(const std::filesystem::path& file, Context* context);

/// All slices of a stream as a volume.
Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context);

/// "... its data end in slice 3 of 40".
[[noreturn]] void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices);

}  // namespace quench::io
