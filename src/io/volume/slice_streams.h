// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "quench/io.h"
#include "quench/shape.h"

/// Streams of slices, one function per kind of source, behind io::open_slices. Spacing and dimension of the options are
/// applied there, not here.
namespace quench::io {

/// The PNG or TIFF files of a folder. Notes and throws as read_slices() does.
SliceStream open_slice_folder(const std::filesystem::path& folder, const VolumeReadOptions& options, Context* context);

struct TiffStream : SliceStream {
  bool colour_indices = false;  ///< the values are indices of colours
};

/// A TIFF file: its pages, the planes of its page (ImageDepth), or the pictures behind its only page as ImageJ writes
/// them beyond 4 GB. One value per voxel, unsigned, signed or floating point:
///
/// - samples of 1, 2 and 4 bits are scaled to 255, as in PNG; of 9 to 15 bits they are kept as uint16, halves as
/// float32;
/// - where 0 is white, unsigned values are inverted (note);
/// - a palette of greys gives the greys, any other the indices of its colours (note) unless the options name a channel;
/// - pictures of several colours, or of grey and alpha, give a channel as volume_of() says, of 8 bits (note where they
///   have more); several slices of them need the options to name it;
/// - pages that do not lie upright (Orientation) are turned.
///
/// Smaller copies of pages and masks are left out (note), all other pages must be alike. The spacing is that of the
/// description of ImageJ or OME; without a distance of slices it is 1 (note, unless the options give a spacing). A file
/// of one slice is a plane; it has the size of pixels of its description. Throws Error(input) where there are fewer
/// slices than the description says, but for the only page of a slice `of_a_folder`, whose description may be that of
/// the whole stack; Error(usage) where Quench was built without libtiff.
TiffStream open_tiff(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context,
                     bool of_a_folder = false);

/// A sparse voxel list (.out): 1 where it has a voxel, within their box; x y z of the list are those of the centres, in
/// voxels. A slice is made when it is asked for: memory is 12 bytes per listed voxel.
SliceStream open_out_voxels(const std::filesystem::path& file, Context* context);

/// All slices of a stream, whose file is named in errors.
Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context);

/// "... its data end in slice 3 of 40".
[[noreturn]] void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices);

}  // namespace quench::io
