// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "quench/io.h"

/// One function per volume format, behind io::read_volume. Each throws Error(failed) when the file cannot be opened and
/// Error(input) when its content cannot be used; none allocates samples before it knows that the file can hold them.
/// `spacing` of the options is applied by read_volume, not here.
namespace quench::io {

/// NPY versions 1 to 3, bool, integers, half, float and double of either byte order. Memory order decides the axes: in
/// C order the last axis is x, in Fortran order the first.
Volume read_npy(const std::filesystem::path& file, Context* context);

/// DGtal .vol: a text header up to the line ".", then raw (version 2) or zlib (version 3) samples of 1, 2, 4 or 8
/// bytes, unsigned.
Volume read_vol(const std::filesystem::path& file, Context* context);

/// The signed octree of the authors of voxel cores: n cells per axis, voxels at the (n+1)^3 corners; 1 = inside.
Volume read_sof(const std::filesystem::path& file, Context* context);

/// Grey PNG as one slice of uint8 (1, 2, 4 and 8 bits, scaled to 255; palettes of greys) or uint16. Spacing 1: dots per
/// inch do not give a distance of slices.
Volume read_png(const std::filesystem::path& file, Context* context);

/// The PNG or TIFF files of a folder in natural order (2 before 10), one slice each, all of one size and type and with
/// or without colours; numbered slices must be complete (check_slice_numbers()). Spacing 1. A note on several slices is
/// given once; TIFF slices whose pixels have a size are a note unless `spacing_is_given`.
Volume read_slices(const std::filesystem::path& folder, Context* context, bool spacing_is_given = false);

/// Replaces the spacing as asked and checks it and the origin.
void apply_spacing(const std::filesystem::path& file, const VolumeReadOptions& options, Grid& grid);

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
