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

/// A dataset of HDF5, "v.h5" or "v.h5:/path/to/dataset"; without a path the only one with three axes or, where there is
/// none, with two. As in NPY the last axis is x, more than three need length 1, and one of two axes is a plane.
/// Integers of up to 8 bytes, halves (float32), floats, doubles, and enumerations of integers (Booleans of h5py). The
/// spacing is that of the attribute element_size_um, or of others by which programs give it (see the source). Memory: a
/// layer of chunks, fewer slices of it where that is more than half of what is allowed. Throws Error(input) with the
/// datasets there are where it is not clear which; Error(usage) where Quench was built without libhdf5.
SliceStream open_hdf5(const std::filesystem::path& name, Context* context);

/// A series of DICOM: of a folder, which must hold one, or of a file; where that has one slice, it is one of the series
/// in its folder (note), unless the options want an image. Slices are sorted by their positions along the normal of
/// their plane and must have equal distances; without positions by their numbers (note). The values are rescaled:
/// integers where slope and intercept are, else float32. One slice is a plane. World coordinates are LPS in mm. Memory:
/// a file of the series. Throws Error(input) for what is not one such volume; Error(usage) where Quench was built
/// without GDCM.
SliceStream open_dicom(const std::filesystem::path& path, const VolumeReadOptions& options, Context* context);

/// All slices of a stream, whose file is named in errors.
Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context);

/// "... its data end in slice 3 of 40".
[[noreturn]] void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices);

}  // namespace quench::io
