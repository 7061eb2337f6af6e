// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

/// Volumes whose header says where the samples lie and how they are stored: NRRD, MetaImage, NIfTI, MRC. A function per
/// format reads the header; one reader, open_stored(), reads the samples of all of them.
namespace quench::io {

/// A sample as it is stored: one that stays as it is, or a half, which becomes a float.
struct StoredType {
  SampleType type = SampleType::uint8;  ///< what it becomes (before scaling)
  bool half = false;
  std::size_t size() const;  ///< bytes of a stored sample
};

/// A part of a file that holds samples.
struct SampleBlock {
  std::filesystem::path file;
  std::uint64_t begin = 0;            ///< offset in the file
  std::uint64_t skip = 0;             ///< bytes before the first sample in what is decompressed
  std::optional<std::uint64_t> size;  ///< bytes in the file that belong to it; nothing: up to the end of the file
};

enum class Encoding { raw, deflate, text, hex };  ///< deflate: gzip (also several members) or zlib

/// What the header of a volume says.
struct StoredVolume {
  Grid grid;
  Coordinates coordinates;
  std::string spacing_source;
  StoredType type;
  bool swapped = false;  ///< the byte order is not the one of this machine
  Encoding encoding = Encoding::raw;
  std::vector<SampleBlock> blocks;   ///< each holds an equal share of the samples, one after the other
  double slope = 1, intercept = 0;   ///< value = slope * sample + intercept
  std::array<int, 3> axes{0, 1, 2};  ///< the axis of the grid stored fastest, second, slowest (MRC: in any order)
  bool scaled() const { return slope != 1 || intercept != 0; }
};

/// Each throws Error(failed) when the file cannot be opened and Error(input) when the header is damaged, contradicts
/// itself or describes anything but a scalar volume on a rectangular grid. No samples are read.
StoredVolume nrrd_header(const std::filesystem::path& file);  ///< NRRD0001 to 0005, attached or detached
StoredVolume meta_header(const std::filesystem::path& file, Context* context);   ///< MetaImage, attached or detached
StoredVolume nifti_header(const std::filesystem::path& file, Context* context);  ///< NIfTI-1 and 2, .nii and .nii.gz
StoredVolume mrc_header(const std::filesystem::path& file);                      ///< MRC2014 and CCP4 maps

/// The samples slice by slice; never more than a slice in memory, except where the axes are stored in another order.
/// Throws Error(input), before a sample is read, when the files are too short for what the header says, and later when
/// compressed samples are damaged or end early.
SliceStream open_stored(const std::filesystem::path& file, const StoredVolume& volume, Context* context);

/// By extension: .nrrd .nhdr, .mha .mhd, .nii .nii.gz, .mrc .map.
bool is_stored_volume(std::string_view extension);
SliceStream open_stored(const std::filesystem::path& file, Context* context);

/// Used by all headers.

[[noreturn]] void refuse_volume(const std::filesystem::path& file, const std::string& why);

/// Largest cosine between two axes that is taken for rounding: 1/20 voxel at the end of 500.
inline constexpr double kShearTolerance = 1e-4;

/// Fills in spacing and direction from the steps between neighbouring voxels along x, y and z in the world. Throws
/// Error(input) where a step is 0, not finite or beyond double precision and where steps are not perpendicular (up to
/// rounding: 1/20 voxel at the end of 500). `where`: what of the header is to be corrected.
void set_steps(const std::filesystem::path& file, const Mat3& steps, std::string_view where, Grid& grid);

/// The next line of a header without its line end; false at the end of the file. Throws Error(input) where it is longer
/// than a megabyte, as in what is not a header.
bool next_header_line(std::istream& in, const std::filesystem::path& file, std::string& line);

/// The shortest decimal number that a float stands for: 0.782, where its value is 0.78200000524.
double decimal(float value);

/// Lower case, without blanks at either end.
std::string lower(std::string_view text);
std::string_view trimmed(std::string_view text);
/// The words of a line, separated by blanks.
std::vector<std::string_view> words_of(std::string_view text);

}  // namespace quench::io
