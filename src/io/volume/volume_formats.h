// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "io/volume/pixels.h"
#include "quench/io.h"

/// One function per volume format, behind io::read_volume. Each throws Error(failed) when the file cannot be opened and
/// Error(input) when its content cannot be used; none allocates samples before it knows that the file can hold them.
/// Spacing and dimension of the options are applied by read_volume, not here.
namespace quench::io {

/// NPY versions 1 to 3, bool, integers, half, float and double of either byte order. Memory order decides the axes: in
/// C order the last axis is x, in Fortran order the first.
Volume read_npy(const std::filesystem::path& file, Context* context);

/// DGtal .vol: a text header up to the line ".", then raw (version 2) or zlib (version 3) samples of 1, 2, 4 or 8
/// bytes, unsigned.
Volume read_vol(const std::filesystem::path& file, Context* context);

/// The signed octree of the authors of voxel cores: n cells per axis, voxels at the (n+1)^3 corners; 1 = inside.
Volume read_sof(const std::filesystem::path& file, Context* context);

/// PNG of all kinds. Grey of 1, 2 and 4 bits is scaled to 255; a palette of greys gives the greys; what has a
/// transparent colour (tRNS) has alpha.
Pixels read_png(const std::filesystem::path& file, Context* context);

/// PBM, PGM and PPM, plain and raw. Values as they are in the file, which says which one is white; the bits of a bitmap
/// become 0 (black) and 255. One picture per file.
Pixels read_pnm(const std::filesystem::path& file, Context* context);

/// BMP of 1, 4, 8 (also run-length encoded), 16, 24 and 32 bits. What a run-length encoded picture leaves out has
/// colour 0.
Pixels read_bmp(const std::filesystem::path& file, Context* context);

/// JPEG, grey or of three colours; 8 bits. Throws Error(usage) where Quench was built without libjpeg.
Pixels read_jpeg(const std::filesystem::path& file, Context* context);

/// By extension: .png, .pbm .pgm .ppm .pnm, .bmp, .jpg .jpeg.
bool is_picture(std::string_view extension);
Pixels read_picture(const std::filesystem::path& file, Context* context);

/// The PNG or TIFF files of a folder in natural order (2 before 10), one slice each, all of one size and type; numbered
/// slices must be complete (check_slice_numbers()). Spacing 1. Slices with colours need a channel. A note on several
/// slices is given once; TIFF slices whose pixels have a size are a note unless the spacing is given.
Volume read_slices(const std::filesystem::path& folder, const VolumeReadOptions& options, Context* context);

/// Throws Error(usage) for options that cannot be, of any file.
void check_options(const VolumeReadOptions& options);

/// Decides whether one slice is a plane or a slab. `grid.dimension` is what the file means: 2 for a picture; else a
/// volume, of which one slice may be meant as either and is Error(usage), field `dimension`, unless the options say
/// which. Of a plane it settles what Grid and Coordinates say of planes: the third coordinate goes, y is down or up as
/// the file says, else up only where y falls from row to row outside of LPS. Then the spacing becomes the one that is asked for; it and the origin are checked.
void settle_grid(const std::filesystem::path& file, const VolumeReadOptions& options, Grid& grid,
                 Coordinates& coordinates, Context* context);

/// Makes `spacing` that of a grid, `what`: "'file'". Its third number is 0 where there are only two, which a plane
/// takes and a volume does not; a plane takes no third number beside its two. Throws Error(usage), field `spacing`.
void take_spacing(const std::string& what, const Vec3& spacing, Grid& grid);

/// Throws Error(input) for a pipe or a device, which may block or have no end. Directories and files that do not exist
/// pass.
void check_regular_file(const std::filesystem::path& file);

/// In lower case, `.nii.gz` as one.
std::string volume_extension(const std::filesystem::path& file);

/// An open file and its size in bytes. Throws Error(failed), and Error(input) when it is empty.
struct InputFile {
  explicit InputFile(const std::filesystem::path& file);
  std::ifstream stream;
  std::uint64_t size = 0;
};

/// The product of `dims`. Throws Error(input) when a side is not in [1, 2^31 - 2] or when `available` bytes cannot hold
/// that many samples.
std::uint64_t checked_sample_count(const std::filesystem::path& file, const std::array<std::int64_t, 3>& dims,
                                   std::uint64_t bytes_per_sample, std::uint64_t available);

/// Throws Error(failed) with figures when the samples of a file take more memory than the context allows or, where it
/// says nothing, than is free: without it a system that promises more than it has would end the program unasked.
void check_read_memory(const std::filesystem::path& file, std::uint64_t bytes, const Context* context);

/// deflate cannot shrink by more than this factor; what a compressed file promises beyond it is not there.
inline constexpr std::uint64_t kDeflateLimit = 1032;

/// Reverses the bytes of every sample.
template <class T>
void swap_bytes(std::vector<T>& samples) {
  auto* bytes = reinterpret_cast<unsigned char*>(samples.data());
  for (std::size_t i = 0; i < samples.size(); ++i) std::reverse(bytes + i * sizeof(T), bytes + (i + 1) * sizeof(T));
}

/// Throws the Error(input) "'FILE' cannot be read as FORMAT: WHY".
[[noreturn]] void refuse(const std::filesystem::path& file, const char* format, const std::string& why);

}  // namespace quench::io
