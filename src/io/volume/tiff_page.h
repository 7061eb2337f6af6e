// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef QUENCH_HAS_TIFF
#include <tiffio.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/volume/pixels.h"
#include "io/volume/tiff_description.h"
#include "io/volume/tiff_directories.h"
#include "quench/shape.h"

namespace quench::io {

/// What a page says about its samples.
struct TiffLayout {
  std::uint32_t width = 0, height = 0, depth = 1;
  std::uint16_t bits = 1, format = SAMPLEFORMAT_UINT, photometric = PHOTOMETRIC_MINISBLACK, compression = 0;
  std::uint16_t orientation = ORIENTATION_TOPLEFT;
  SampleType type = SampleType::uint8;                                  ///< of the values it becomes
  bool lowest_bit_first = false;                                        ///< in each byte of the file (FillOrder 2)
  bool colour_indices = false;                                          ///< of a palette that holds more than greys
  std::uint16_t channels = 1;                                           ///< samples of a pixel, stored together
  enum class Alpha { none, straight, multiplied } alpha = Alpha::none;  ///< what the last of several samples is

  bool transposed() const { return orientation >= ORIENTATION_LEFTTOP && orientation <= ORIENTATION_LEFTBOT; }
  bool has_colours() const { return channels > 1; }
  std::uint64_t pixel_bits() const { return std::uint64_t{bits} * channels; }
  std::uint64_t row_bytes() const { return (width * pixel_bits() + 7) / 8; }  ///< as stored
  std::uint64_t plane_bytes() const { return row_bytes() * height; }          ///< as stored
  std::uint64_t samples() const { return std::uint64_t{width} * height; }     ///< of a plane, one per pixel
};

/// One page of a TIFF file through libtiff: a picture, or (ImageDepth) a volume.
class TiffPage {
 public:
  /// `index` in file.directories(). libtiff allocates at most `memory` bytes at once. Throws Error(input) for a damaged
  /// directory.
  TiffPage(const TiffFile& file, std::size_t index, std::int64_t memory);

  /// A smaller copy of another page, or a mask.
  bool is_accessory() const;
  /// Throws Error(input) where the page has no samples that Quench reads as one value each.
  TiffLayout layout() const;
  std::string description() const;
  TiffResolution resolution() const;
  /// Where the samples of `planes` planes lie one after the other, uncompressed, counted by the file itself; nothing
  /// where they are not. What is read there has the bytes and bits in the order of the file.
  std::optional<std::uint64_t> raw_planes(const TiffLayout& layout, std::uint64_t planes, bool counted) const;
  /// Whether a page of several planes lists the strips of all.
  bool lists_strips_of_planes(const TiffLayout& layout) const;
  bool is_tiled() const { return TIFFIsTiled(tiff_.get()) != 0; }
  /// Planes that are stored together: the depth of a tile.
  std::uint32_t planes_together(const TiffLayout& layout) const;
  /// Bytes that read_planes() needs beside its result. Throws Error(input) where the page contradicts itself.
  std::uint64_t buffer_bytes(const TiffLayout& layout) const;

  /// Planes first, first + 1 ... as stored, in the byte order of the machine; `first` is a multiple of
  /// planes_together(). Throws Error(input) when they are damaged.
  void read_planes(const TiffLayout& layout, std::uint32_t first, std::span<std::byte> out);
  /// Values of the samples of a plane: unpacked, inverted where 0 is white, grey values of a palette of greys, turned
  /// upright.
  void convert(const TiffLayout& layout, std::span<const std::byte> stored, std::span<std::byte> out) const;

  /// The pixels of a plane with colours, as it lies in the file.
  Pixels colours(const TiffLayout& layout, std::span<const std::byte> stored) const;
  /// The colours that indices (what convert() gives of a palette) stand for, of the type of the indices.
  Pixels colours_of_indices(const TiffLayout& layout, std::span<const std::byte> indices) const;
  /// "an RGB picture": of a page with colours or a palette.
  static std::string kind_of_colours(const TiffLayout& layout);
  /// From one value per pixel as the page lies in the file to the picture upright.
  static void turn(const TiffLayout& layout, std::span<const std::byte> lying, std::span<std::byte> out);

  /// "'file'" or "page 3 of 'file'".
  std::string name() const;

 private:
  struct Source;  // what libtiff reads from
  struct Messages {
    std::string first_error;
    bool warned = false;
    bool mended = false;  ///< libtiff guessed where or how long strips or tiles are
  };
  [[noreturn]] void refuse(const std::string& what) const;
  [[noreturn]] void refuse_damaged() const;
  void check_pieces() const;
  void check_one_value(const TiffLayout& layout, std::uint16_t samples) const;
  /// Whether the page has colours, or grey and alpha, that are read; of the layout channels and alpha are filled in.
  bool set_colours(TiffLayout& layout, std::uint16_t samples) const;
  void check_jbig(const TiffLayout& layout, std::uint64_t at, std::uint32_t width, std::uint32_t height) const;
  /// Decodes `size` bytes of the file at `at` as strip or tile `piece`.
  bool decode(std::uint32_t piece, std::uint64_t at, std::uint64_t size, std::span<std::byte> out);
  void read_strips_of_plane(const TiffLayout& layout, std::uint32_t plane, std::span<std::byte> out);
  void read_strips(const TiffLayout& layout, std::span<std::byte> out);
  std::uint32_t tile_depth() const;
  bool read_tile(std::uint32_t tile);  ///< into tile_
  void read_tiles(const TiffLayout& layout, std::uint32_t first, std::span<std::byte> out);
  void to_values(const TiffLayout& layout, std::span<const std::byte> stored, std::span<std::byte> out) const;
  /// A warning is as good as an error where the decoder goes on with what it has.
  void check_decoded(const TiffLayout& layout, bool whole) const;
  std::optional<std::vector<std::uint16_t>> grey_palette(const TiffLayout& layout) const;

  const TiffFile& file_;
  std::size_t index_;
  std::unique_ptr<Messages> messages_;
  std::unique_ptr<Source, void (*)(Source*)> source_;
  std::unique_ptr<TIFF, void (*)(TIFF*)> tiff_;
  std::vector<std::byte> tile_, packed_;
  std::vector<std::uint64_t> strip_offsets_, strip_sizes_;  // of all planes
};

}  // namespace quench::io
#endif
