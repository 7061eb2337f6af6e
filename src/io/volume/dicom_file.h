// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "quench/geometry.h"

/// Files of DICOM, through GDCM. To be called in a child process: on damaged files GDCM may crash or read endlessly.
namespace quench::io {

/// What a file says of one of its frames: in the file itself, or of an enhanced one in the functional groups of the
/// frame or of all.
struct DicomFrame {
  std::optional<Vec3> position;                ///< ImagePositionPatient: the centre of the first pixel
  std::optional<std::array<Vec3, 2>> axes;     ///< ImageOrientationPatient: along a row, along a column
  std::optional<std::array<double, 2>> pixel;  ///< between columns, between rows
  std::optional<double> between;               ///< SpacingBetweenSlices, else SliceThickness
  double slope = 1, intercept = 0;
};

/// How samples are stored.
struct DicomSamples {
  int allocated = 0, stored = 0;  ///< bits
  bool is_signed = false;
  int channels = 1;
  bool operator==(const DicomSamples&) const = default;
};

struct DicomFile {
  std::filesystem::path file;
  std::string series;            ///< SeriesInstanceUID
  std::string title;             ///< of the series: its number and description, as far as there are
  std::string colours;           ///< PhotometricInterpretation
  std::optional<double> number;  ///< InstanceNumber
  std::int64_t columns = 0, rows = 0;
  DicomSamples samples;
  bool detector = false;  ///< the size of pixels is that of the detector (ImagerPixelSpacing)
  std::vector<DicomFrame> frames;

  /// Bytes of a frame as dicom_pixels() gives it.
  std::uint64_t frame_bytes() const {
    return static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows) *
           static_cast<std::uint64_t>((samples.allocated + 7) / 8 * samples.channels);
  }
};

/// All but the pixels. Nothing for a file without pixels: reports, directories. Throws Error(input) for a file that
/// cannot be read.
std::optional<DicomFile> dicom_header(const std::filesystem::path& file);

/// The samples of all frames of a grey picture of 8, 16 or 32 bits, decompressed, in the byte order of the machine;
/// bits beyond those that are stored are those of the sign. Throws Error(input) where they are damaged.
std::vector<std::byte> dicom_pixels(const DicomFile& file);

}  // namespace quench::io
