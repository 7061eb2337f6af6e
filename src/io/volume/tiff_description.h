// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "quench/geometry.h"

/// What the text in a TIFF file (ImageDescription) and its resolution tags say of a volume. TIFF itself knows pages,
/// not volumes.
namespace quench::io {

/// A unit of length.
struct LengthUnit {
  std::string name;   ///< one spelling for each; inches become millimetres
  double metres = 0;  ///< 0: of no known length
  double factor = 1;  ///< from the unit of the file to `name`
};

/// "um", "micrometer" ... in any case of letters.
LengthUnit known_unit(std::string_view text);

/// A size of voxels, in the words of the file. Not positive or not finite: it is there and cannot be used.
struct TiffLength {
  double value = 0;
  std::string unit;  ///< empty: not said
};

/// The ImageDescription of ImageJ, OME or tifffile; of any other text everything is as if it were not there.
struct TiffDescription {
  std::string name;         ///< "ImageJ description", "OME-XML description" ...; empty: another text
  std::int64_t images = 0;  ///< how many pictures the file has by it; 0: it does not say
  std::int64_t channels = 1, times = 1, volumes = 1;
  bool one_directory = false;                     ///< the directories of all pictures but the first are left out
  bool several_files = false;                     ///< the pictures are in several files
  std::optional<std::string> unit;                ///< ImageJ: what the resolution tags count in
  std::array<std::optional<TiffLength>, 3> size;  ///< of a voxel in x, y, z (ImageJ: z only)
  std::optional<std::int64_t> function;           ///< ImageJ: what becomes of grey values; kStraightLine or others
  std::array<double, 2> line{0, 1};               ///< of a straight line: value = line[0] + line[1] * sample
};

/// ImageJ's number of the function, and of there being none.
inline constexpr std::int64_t kStraightLine = 0, kNoFunction = 20;

TiffDescription tiff_description(const std::string& text);

/// The resolution tags of a page.
struct TiffResolution {
  std::optional<double> x, y;  ///< side of a pixel in `unit`; not positive or not finite: the tag cannot be used
  std::string unit;            ///< "inch", "cm" or empty
};

/// The side of a pixel where `numerator / denominator` pixels are in a unit: the shortest decimal number that a writer
/// may have meant, as the fraction is rounded (15384615/1000000 pixels: 0.065).
double pixel_side(std::uint32_t numerator, std::uint32_t denominator);

/// The spacing of a volume and why.
struct TiffCalibration {
  Vec3 spacing = Vec3::Ones();
  std::string units, source;  ///< as of a Volume
  std::string note;           ///< what the user should know, to be put after the name of the file; may be empty
};

/// `slices`: how many the volume has. Without a distance of slices the spacing is 1: dots per inch of a picture are
/// seldom meant.
TiffCalibration tiff_calibration(const TiffDescription& description, const TiffResolution& resolution,
                                 std::int64_t slices);

/// The same of one picture, by its size of pixels alone: as the description of ImageJ or OME says, else 1.
TiffCalibration tiff_plane_calibration(const TiffDescription& description, const TiffResolution& resolution);

}  // namespace quench::io
