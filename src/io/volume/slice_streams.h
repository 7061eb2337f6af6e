// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "quench/io.h"
#include "quench/shape.h"

/// Streams of slices, one function per kind of source, behind io::open_slices. The spacing of the options is applied
/// there, not here.
namespace quench::io {

/// The PNG or TIFF files of a folder. Notes and throws as read_slices() does.
SliceStream open_slice_folder(const std::filesystem::path& folder, Context* context, bool spacing_is_given = false);

struct TiffStream : SliceStream {
  bool colour_indices = false;  ///< the values are indices of colours
};

/// A TIFF file: its pages, the planes of its page (ImageDepth), or the pictures behind its only page as ImageJ writes
/// them beyond 4 GB. One value per voxel, unsigned, signed or floating point:
///
/// - samples of 1, 2 and 4 bits are scaled to 255, as in PNG; of 9 to 15 bits they are kept as uint16, halves as
/// float32;
/// - where 0 is white, unsigned values are inverted (note);
/// - a palette of greys gives the greys, any other the indices of its colours (note);
/// - pages that do not lie upright (Orientation) are turned.
///
/// Smaller copies of pages and masks are left out (note), all other pages must be alike. The spacing is that of the
/// description of ImageJ or OME; without a distance of slices it is 1 (note, unless `spacing_is_given`). Throws
/// Error(input) where there are fewer slices than the description says, but for the only page of a slice `of_a_folder`,
/// whose description may be that of the whole stack; Error(usage) where Quench was built without libtiff.
TiffStream open_tiff(const std::filesystem::path& file, Context* context, bool spacing_is_given = false,
                     bool of_a_folder = false);

/// All slices of a stream, whose file is named in errors.
Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context);

/// "... its data end in slice 3 of 40".
[[noreturn]] void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices);

}  // namespace quench::io
