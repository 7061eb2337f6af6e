// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "small_files.h"

/// Tiny valid volumes in the formats ITK reads: 3 x 3 x 3 voxels, the middle one 1.
namespace quench::foreign_files {

struct ForeignFile {
  std::string name, bytes;
  std::string beside, bytes_beside;  ///< a second file, with the samples
};

inline std::string samples() {
  std::string bytes(27, '\0');
  bytes[13] = '\1';
  return bytes;
}

inline std::string meta(const std::string& more, const std::string& data_file) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + more +
         "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\nDimSize = 3 3 3\n"
         "ElementType = MET_UCHAR\nElementDataFile = " +
         data_file + "\n";
}

inline std::string nrrd(const std::string& encoding, const std::string& more = "") {
  return "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 3 3\nspace directions: (1,0,0) "
         "(0,1,0) (0,0,1)\nkinds: domain domain domain\nendian: little\nencoding: " +
         encoding + "\nspace origin: (0,0,0)\n" + more + "\n";
}

inline std::string nifti() {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, const std::string& part) { bytes.replace(at, part.size(), part); };
  const std::string one = small_files::number(small_files::one_as_float, 4);
  put(0, small_files::number(348, 4));
  for (std::size_t a = 0; a < 8; ++a) put(40 + 2 * a, small_files::number(a > 0 && a < 4 ? 3 : a ? 1 : 3, 2));
  put(70, small_files::number(2, 2));  // uint8
  put(72, small_files::number(8, 2));
  for (std::size_t a = 0; a < 8; ++a) put(76 + 4 * a, one);
  put(108, small_files::number(0x43B00000, 4));  // 352
  put(112, one);
  put(123, "\2");  // mm
  put(254, small_files::number(1, 2));
  for (std::size_t a = 0; a < 3; ++a) put(280 + 20 * a, one);
  put(344, std::string("n+1\0", 4));
  return bytes + samples();
}

inline std::string mrc() {
  std::string bytes(1024, '\0');
  const auto put = [&](std::size_t word, std::uint64_t value) {
    bytes.replace(4 * word, 4, small_files::number(value, 4));
  };
  for (const std::size_t word : {0, 1, 2, 7, 8, 9}) put(word, 3);
  for (const std::size_t word : {10, 11, 12}) put(word, 0x40400000);  // 3
  for (const std::size_t word : {13, 14, 15}) put(word, 0x42B40000);  // 90 degrees
  for (const std::size_t word : {16, 17, 18}) put(word, word - 15);
  bytes.replace(208, 4, "MAP ");
  bytes.replace(212, 4, std::string("DA\0\0", 4));
  return bytes + samples();
}

/// One page of 3 x 3 pixels; with `deflate` in a compressed strip.
inline std::string tiff(bool deflate) {
  const std::string plain("\0\0\0\0\1\0\0\0\0", 9), strip = deflate ? small_files::deflated(plain) : plain;
  const auto entry = [](int tag, int type, std::uint64_t value) {
    return small_files::number(static_cast<std::uint64_t>(tag), 2) +
           small_files::number(static_cast<std::uint64_t>(type), 2) + small_files::number(1, 4) +
           small_files::number(value, 4);
  };
  const std::size_t directory = 8 + (strip.size() + 1) / 2 * 2;
  std::string bytes = "II*" + std::string(1, '\0') + small_files::number(directory, 4) + strip;
  bytes.resize(directory, '\0');
  return bytes + small_files::number(10, 2) + entry(256, 3, 3) + entry(257, 3, 3) + entry(258, 3, 8) +
         entry(259, 3, deflate ? 8 : 1) + entry(262, 3, 1) + entry(273, 4, 8) + entry(277, 3, 1) + entry(278, 3, 3) +
         entry(279, 4, strip.size()) + entry(284, 3, 1) + small_files::number(0, 4);
}

inline std::vector<ForeignFile> volumes() {
  const std::string packed = small_files::deflated(samples());
  return {
      {"plain.mha", meta("", "LOCAL") + samples(), "", ""},
      {"packed.mha",
       meta("CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) + "\n", "LOCAL") + packed,
       "", ""},
      {"apart.mhd", meta("", "samples.raw"), "samples.raw", samples()},
      {"slices.mhd", meta("", "slice%d.raw 1 3 1"), "slice1.raw", samples()},
      {"raw.nrrd", nrrd("raw") + samples(), "", ""},
      {"gzip.nrrd", nrrd("gzip") + small_files::deflated(samples(), 15 + 16), "", ""},
      {"text.nrrd", nrrd("ascii") + "0 0 0 0 0 0 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0 0 0 0 0 0 0\n", "", ""},
      {"apart.nhdr", nrrd("raw", "data file: samples.raw\n"), "samples.raw", samples()},
      {"plain.nii", nifti(), "", ""},
      {"packed.nii.gz", small_files::deflated(nifti(), 15 + 16), "", ""},
      {"plain.mrc", mrc(), "", ""},
      {"plain.tif", tiff(false), "", ""},
      {"packed.tif", tiff(true), "", ""},
  };
}

}  // namespace quench::foreign_files
