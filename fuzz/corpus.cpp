// SPDX-License-Identifier: Apache-2.0
// Writes what the targets begin with: the small files of the tests, and built-in shapes in the formats Quench writes.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "quench/io.h"
#include "quench/samples.h"
#include "small_files.h"
#include "small_polygons.h"
#include "small_zarr.h"
#ifdef QUENCH_HAS_TIFF
#include <tiffio.h>
#endif

namespace {

quench::Record as_axis(const quench::TriangleMesh& mesh) {
  quench::Record data;
  data.points = mesh.points;
  std::vector<double> radius(mesh.points.size(), 0.25);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    if (t % 3 == 0) {
      data.lines.push_back({corners[0], corners[1]});
      continue;
    }
    data.poly_corners.insert(data.poly_corners.end(), corners.begin(), corners.end());
    data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
  }
  data.point_data.push_back({"radius", 1, std::move(radius)});
  data.field_data.push_back({"units", 1, std::vector<std::string>{"mm"}});
  return data;
}

/// As zarr_target.cpp takes them apart.
void write_zarrs(const std::filesystem::path& folder) {
  using quench::small_files::ZarrKind;
  const std::string attributes =
      "{\"multiscales\": [{\"axes\": [{\"name\": \"z\", \"unit\": \"micrometer\"}, {\"name\": \"y\"}, {\"name\": "
      "\"x\"}], "
      "\"datasets\": [{\"path\": \"0\", \"coordinateTransformations\": [{\"type\": \"scale\", \"scale\": [2, 1, 1]}, "
      "{\"type\": \"translation\", \"translation\": [3, 2, 1]}]}]}]}";
  std::filesystem::create_directories(folder);
  for (const ZarrKind kind : {ZarrKind::zarr2, ZarrKind::zarr3, ZarrKind::shards, ZarrKind::n5}) {
    const auto array = quench::small_files::small_zarr(kind, {2, 2, 2}, {2, 2, 2}, {1, 2, 3, 4, 5, 6, 7, 8});
    const char letter = kind == ZarrKind::zarr2 ? '2' : kind == ZarrKind::n5 ? '5' : '3';
    std::ofstream(folder / std::to_string(static_cast<int>(kind)), std::ios::binary)
        << letter << array.metadata << '\0' << attributes << '\0' << array.chunks[0].second;
  }
}

#ifdef QUENCH_HAS_TIFF
/// A small grey TIFF in every compression of libtiff.
void write_compressed_tiffs(const std::filesystem::path& folder) {
  for (const std::uint16_t compression :
       {COMPRESSION_CCITTRLE, COMPRESSION_CCITTFAX3, COMPRESSION_CCITTFAX4, COMPRESSION_LZW, COMPRESSION_JPEG,
        COMPRESSION_PACKBITS, COMPRESSION_PIXARLOG, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_JBIG, COMPRESSION_LERC,
        COMPRESSION_LZMA, COMPRESSION_ZSTD}) {
    if (TIFFIsCODECConfigured(compression) == 0) continue;
    constexpr std::uint32_t side = 16;
    const bool bilevel = compression == COMPRESSION_JBIG || compression < COMPRESSION_LZW;
    const auto file = folder / ("compression" + std::to_string(compression) + ".tif");
    TIFF* out = TIFFOpen(file.c_str(), "w");
    if (!out) throw std::runtime_error("a TIFF file cannot be written");
    for (const std::uint32_t tag : {TIFFTAG_IMAGEWIDTH, TIFFTAG_IMAGELENGTH, TIFFTAG_ROWSPERSTRIP})
      TIFFSetField(out, tag, side);
    TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, bilevel ? 1 : 8);
    TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(out, TIFFTAG_COMPRESSION, compression);
    std::string samples;
    for (std::uint32_t i = 0; i < side * side / (bilevel ? 8 : 1); ++i) samples += static_cast<char>(i * i / 3);
    TIFFWriteEncodedStrip(out, 0, samples.data(), static_cast<tmsize_t>(samples.size()));
    TIFFClose(out);
  }
}
#endif

}  // namespace

int main(int argc, char** argv) try {
  namespace fs = std::filesystem;
  if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
  const fs::path folder = argv[1];
  for (const auto& files : {quench::small_files::all(), quench::small_files::polygons()})
    for (const auto& file : files) {
      fs::create_directories(folder / file.format);
      std::ofstream(folder / file.format / file.name, std::ios::binary) << file.bytes;
    }
  for (const auto& sample : quench::built_in_samples()) {
    const std::string name(sample.name);
    const auto made = quench::make_sample(name, {.noise = 0, .seed = 1, .branches = 1, .fineness = 0.05});
    if (made.mesh.triangles.size() > 300) continue;  // small inputs make fast targets
    for (const char* format : {"ply", "obj", "vtp", "ma"})
      quench::io::write_record(folder / format / (name + "." + format), as_axis(made.mesh));
  }
  write_zarrs(folder / "zarr");
#ifdef QUENCH_HAS_TIFF
  write_compressed_tiffs(folder / "tiff");
#endif
  return 0;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
