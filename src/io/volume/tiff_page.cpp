// SPDX-License-Identifier: Apache-2.0
#include "io/volume/tiff_page.h"

#ifdef QUENCH_HAS_TIFF
#include <fmt/format.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>

#include "io/volume/float16.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {

// The file with another start of the chain of directories in its header: libtiff opens one page and never follows the
// chain, whose end it does not tell from damage and whose length it limits.
struct TiffPage::Source {
  const TiffFile* file;
  std::uint64_t at = 0;
  std::uint64_t start_at = 0;
  std::vector<std::byte> start;

  static tmsize_t read(thandle_t handle, void* out, tmsize_t size) {
    auto& s = *static_cast<Source*>(handle);
    const std::span<std::byte> to(static_cast<std::byte*>(out), static_cast<std::size_t>(size));
    const std::size_t got = s.file->read(s.at, to);
    for (std::size_t i = 0; i < s.start.size(); ++i)
      if (const std::uint64_t byte = s.start_at + i; byte >= s.at && byte < s.at + got) to[byte - s.at] = s.start[i];
    s.at += got;
    return static_cast<tmsize_t>(got);
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }
  static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    auto& s = *static_cast<Source*>(handle);
    s.at = offset + (whence == SEEK_CUR ? s.at : whence == SEEK_END ? s.file->size() : 0);
    return s.at;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t handle) { return static_cast<Source*>(handle)->file->size(); }
};

namespace {

template <class T>
T field(TIFF* tiff, std::uint32_t tag, T otherwise) {
  T value = otherwise;
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}

std::optional<SampleType> sample_type(std::uint16_t bits, std::uint16_t format) {
  const bool integer = format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID,
             is_signed = format == SAMPLEFORMAT_INT;
  const bool real = format == SAMPLEFORMAT_IEEEFP;
  if (integer && (bits == 1 || bits == 2 || bits == 4 || bits == 8)) return SampleType::uint8;
  if (integer && bits > 8 && bits <= 16) return SampleType::uint16;
  if (integer && bits == 32) return SampleType::uint32;
  if (integer && bits == 64) return SampleType::uint64;
  if (is_signed && bits == 8) return SampleType::int8;
  if (is_signed && bits == 16) return SampleType::int16;
  if (is_signed && bits == 32) return SampleType::int32;
  if (is_signed && bits == 64) return SampleType::int64;
  if (real && (bits == 16 || bits == 32)) return SampleType::float32;
  if (real && bits == 64) return SampleType::float64;
  return {};
}

std::string format_name(std::uint16_t format) {
  switch (format) {
    case SAMPLEFORMAT_INT:
      return "signed";
    case SAMPLEFORMAT_IEEEFP:
      return "floating-point";
    case SAMPLEFORMAT_COMPLEXINT:
    case SAMPLEFORMAT_COMPLEXIEEEFP:
      return "complex";
    default:
      return "unsigned";
  }
}

/// What a picture with several values per pixel, or colours, is.
std::string colour_name(std::uint16_t photometric, std::uint16_t samples) {
  switch (photometric) {
    case PHOTOMETRIC_RGB:
      return samples == 4 ? "an RGBA picture" : "an RGB picture";
    case PHOTOMETRIC_YCBCR:
      return "a colour picture (YCbCr)";
    case PHOTOMETRIC_SEPARATED:
      return "a picture in colours of print (CMYK)";
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
    case PHOTOMETRIC_ITULAB:
      return "a colour picture (L*a*b*)";
    case PHOTOMETRIC_CFA:
      return "the raw picture of a colour camera";
    case PHOTOMETRIC_LOGL:
    case PHOTOMETRIC_LOGLUV:
      return "a picture of logarithmic luminance (LogLuv)";
    default:
      return samples == 1 ? fmt::format("a picture of another kind (PhotometricInterpretation {})", photometric)
                          : fmt::format("a picture with {} values per pixel", samples);
  }
}

/// How much larger samples can be than what a file stores of them. Nothing bounds blank areas of fax, JBIG and the
/// like.
std::uint64_t largest_ratio(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return 64;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return kDeflateLimit;
    default:
      return std::uint64_t{1} << 20;
  }
}

/// Whether the decoder needs no size of a strip or tile beside that of its output.
bool decodes_any_size(std::uint16_t compression) {
  return compression == COMPRESSION_NONE || compression == COMPRESSION_LZW || compression == COMPRESSION_PACKBITS ||
         compression == COMPRESSION_DEFLATE || compression == COMPRESSION_ADOBE_DEFLATE ||
         compression == COMPRESSION_LZMA || compression == COMPRESSION_ZSTD;
}

// From columns i and rows j as stored to the picture upright (TIFF 6.0, Orientation).
template <std::size_t size>
void turn_upright(const TiffLayout& layout, std::span<const std::byte> stored, std::span<std::byte> out) {
  const std::uint64_t w = layout.width, h = layout.height, row = layout.transposed() ? h : w;
  const auto o = layout.orientation;
  const bool right = o == ORIENTATION_TOPRIGHT || o == ORIENTATION_BOTRIGHT;
  const bool bottom = o == ORIENTATION_BOTRIGHT || o == ORIENTATION_BOTLEFT;
  const bool from_right = o == ORIENTATION_RIGHTTOP || o == ORIENTATION_RIGHTBOT;
  const bool from_bottom = o == ORIENTATION_RIGHTBOT || o == ORIENTATION_LEFTBOT;
  for (std::uint64_t j = 0; j < h; ++j)
    for (std::uint64_t i = 0; i < w; ++i) {
      const std::uint64_t x = layout.transposed() ? (from_right ? h - 1 - j : j) : right ? w - 1 - i : i;
      const std::uint64_t y = layout.transposed() ? (from_bottom ? w - 1 - i : i) : bottom ? h - 1 - j : j;
      std::memcpy(&out[(y * row + x) * size], &stored[(j * w + i) * size], size);
    }
}

}  // namespace

TiffPage::TiffPage(const TiffFile& file, std::size_t index, std::int64_t memory)
    : file_(file),
      index_(index),
      messages_(std::make_unique<Messages>()),
      source_(new Source{&file, 0, file.big_tiff() ? 8u : 4u, {}}, [](Source* s) { delete s; }),
      tiff_(nullptr, TIFFClose) {
  const std::size_t size = file.big_tiff() ? 8 : 4;
  for (std::size_t i = 0; i < size; ++i)
    source_->start.push_back(
        static_cast<std::byte>(file.directories()[index] >> 8 * (file.big_endian() ? size - 1 - i : i) & 0xFF));
  // No memory mapping (a file cut while it is read is a short read, not a signal), strips as the file has them.
  constexpr const char* kMode = "rmc";
  // Handlers of one open file (libtiff 4.5); those of the process are not touched.
  const auto error = [](TIFF*, void* data, const char*, const char* format, std::va_list arguments) -> int {
    auto& messages = *static_cast<Messages*>(data);
    if (!messages.first_error.empty()) return 1;
    char text[300];
    if (std::vsnprintf(text, sizeof text, format, arguments) < 0) return 1;
    for (const char* c = text; *c; ++c) messages.first_error += *c >= ' ' && *c <= '~' ? *c : '?';
    return 1;
  };
  const auto warning = [](TIFF*, void* data, const char*, const char* format, std::va_list arguments) -> int {
    auto& messages = *static_cast<Messages*>(data);
    messages.warned = true;
    char text[300];
    if (std::vsnprintf(text, sizeof text, format, arguments) < 0) return 1;
    for (const char* piece : {"StripByteCounts", "StripOffsets", "TileByteCounts", "TileOffsets", "tile"})
      messages.mended = messages.mended || std::string_view(text).find(piece) != std::string_view::npos;
    return 1;
  };
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  if (!options) throw std::bad_alloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), error, messages_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), warning, messages_.get());
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), memory);
  tiff_.reset(TIFFClientOpenExt(file.path().c_str(), kMode, source_.get(), Source::read, Source::write, Source::seek,
                                Source::close, Source::size, nullptr, nullptr, options.get()));
  if (!tiff_ || !messages_->first_error.empty()) refuse_damaged();
  if (messages_->mended)
    refuse("is wrong about where its strips or tiles are, or how long; it is damaged or incomplete");
  if (field<std::uint16_t>(tiff_.get(), TIFFTAG_COMPRESSION, 0) == COMPRESSION_JPEG &&
      field<std::uint16_t>(tiff_.get(), TIFFTAG_PHOTOMETRIC, 0) == PHOTOMETRIC_YCBCR)
    TIFFSetField(tiff_.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);  // the decoder's own conversion
}

std::string TiffPage::name() const {
  if (file_.directories().size() == 1) return fmt::format("'{}'", file_.path().string());
  return fmt::format("page {} of '{}'", index_ + 1, file_.path().string());
}

void TiffPage::refuse(const std::string& what) const {
  throw Error(ErrorCode::input, fmt::format("{} {}", name(), what));
}

void TiffPage::refuse_damaged() const {
  std::string reason = messages_->first_error;
  if (reason.find("4294967295") != reason.npos) reason.clear();  // libtiff's "no row": it says nothing to a user
  while (!reason.empty() && (reason.back() == '.' || reason.back() == ' ')) reason.pop_back();
  refuse("is damaged or incomplete" + (reason.empty() ? "" : ": libtiff says '" + reason + "'"));
}

bool TiffPage::is_accessory() const {
  return (field<std::uint32_t>(tiff_.get(), TIFFTAG_SUBFILETYPE, 0) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

void TiffPage::check_one_value(const TiffLayout& layout, std::uint16_t samples) const {
  const bool grey = layout.photometric == PHOTOMETRIC_MINISBLACK || layout.photometric == PHOTOMETRIC_MINISWHITE ||
                    layout.photometric == PHOTOMETRIC_PALETTE;
  if (grey && samples == 1) return;
  refuse(fmt::format("is {} of {} x {} pixels, and Quench needs one value per voxel; {}",
                     colour_name(layout.photometric, samples), layout.width, layout.height,
                     grey ? "save the channel you mean on its own"
                          : "convert it to grey values, e.g. in ImageJ with Image > Type > 8-bit"));
}

bool TiffPage::set_colours(TiffLayout& layout, std::uint16_t samples) const {
  TIFF* t = tiff_.get();
  std::uint16_t extra = 0, *kinds = nullptr;
  TIFFGetFieldDefaulted(t, TIFFTAG_EXTRASAMPLES, &extra, &kinds);
  const std::uint16_t kind = extra == 1 && kinds ? kinds[0] : std::uint16_t{EXTRASAMPLE_UNSPECIFIED};
  const bool alpha = kind == EXTRASAMPLE_ASSOCALPHA || kind == EXTRASAMPLE_UNASSALPHA;
  const bool rgb = layout.photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4);
  const bool ycbcr = layout.photometric == PHOTOMETRIC_YCBCR && samples == 3 && layout.compression == COMPRESSION_JPEG;
  const bool grey_and_alpha = layout.photometric == PHOTOMETRIC_MINISBLACK && samples == 2 && alpha;
  if (!rgb && !ycbcr && !grey_and_alpha) return false;
  layout.channels = samples;
  if (alpha && samples % 2 == 0)
    layout.alpha = kind == EXTRASAMPLE_ASSOCALPHA ? TiffLayout::Alpha::multiplied : TiffLayout::Alpha::straight;
  const bool whole = layout.format == SAMPLEFORMAT_UINT || layout.format == SAMPLEFORMAT_VOID;
  if (!whole || (layout.bits != 8 && layout.bits != 16) || layout.depth > 1)
    refuse(fmt::format("has colours in {} samples of {} bits, which are not read; save it as RGB of 8 or 16 bits",
                       format_name(layout.format), layout.bits));
  if (field<std::uint16_t>(t, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) != PLANARCONFIG_CONTIG)
    refuse("has each colour in a plane of its own, which is not read; save it with the colours of a pixel together");
  return true;
}

TiffLayout TiffPage::layout() const {
  TIFF* t = tiff_.get();
  TiffLayout l;
  l.width = field(t, TIFFTAG_IMAGEWIDTH, l.width);
  l.height = field(t, TIFFTAG_IMAGELENGTH, l.height);
  l.depth = field(t, TIFFTAG_IMAGEDEPTH, l.depth);
  l.bits = field(t, TIFFTAG_BITSPERSAMPLE, l.bits);
  l.format = field(t, TIFFTAG_SAMPLEFORMAT, l.format);
  l.compression = field<std::uint16_t>(t, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const bool fax = l.compression == COMPRESSION_CCITTRLE || l.compression == COMPRESSION_CCITTRLEW ||
                   l.compression == COMPRESSION_CCITTFAX3 || l.compression == COMPRESSION_CCITTFAX4;
  l.photometric = field<std::uint16_t>(t, TIFFTAG_PHOTOMETRIC, fax ? PHOTOMETRIC_MINISWHITE : PHOTOMETRIC_MINISBLACK);
  l.orientation = field(t, TIFFTAG_ORIENTATION, l.orientation);
  l.lowest_bit_first = field<std::uint16_t>(t, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB) == FILLORDER_LSB2MSB;
  const auto samples = field<std::uint16_t>(t, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (!set_colours(l, samples)) check_one_value(l, samples);
  const std::optional<SampleType> type = sample_type(l.bits, l.format);
  if (!type)
    refuse(
        fmt::format("has {} samples of {} bits, which are not read; save it as integers of 8 or 16 bits, or as "
                    "float32",
                    format_name(l.format), l.bits));
  l.type = *type;
  if (l.compression == COMPRESSION_OJPEG)
    refuse("is compressed by JPEG as in TIFF 6.0 of 1992, which is not read; save it with another compression");
  if (TIFFIsCODECConfigured(l.compression) == 0)
    refuse(
        fmt::format("is compressed in a way this libtiff does not know (Compression {}); save it without compression",
                    l.compression));
  if (l.photometric == PHOTOMETRIC_PALETTE &&
      (l.bits > 16 || *type == SampleType::int8 || l.format == SAMPLEFORMAT_INT || l.format == SAMPLEFORMAT_IEEEFP))
    refuse("has a palette for samples that are not indices; it is damaged");
  l.colour_indices = l.photometric == PHOTOMETRIC_PALETTE && !grey_palette(l);
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t ratio = largest_ratio(l.compression) * (l.bits < 8 ? 8u / l.bits : 1);
  const std::uint64_t available = file_.size() > most / ratio ? most : file_.size() * ratio;
  // Packed samples of 9 to 15 bits and half floats become larger in memory: they are counted as they are stored.
  checked_sample_count(file_.path(), {l.width, l.height, l.depth}, std::max<std::uint64_t>(1, l.pixel_bits() / 8),
                       available);
  return l;
}

std::string TiffPage::description() const {
  const char* text = nullptr;
  return TIFFGetField(tiff_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr ? text : "";
}

TiffResolution TiffPage::resolution() const {
  const auto side = [&](std::uint16_t tag) -> std::optional<double> {
    float per_unit = 0;
    if (TIFFGetField(tiff_.get(), tag, &per_unit) != 1) return {};
    if (const auto exact = file_.rational(file_.directories()[index_], tag))
      return pixel_side(exact->numerator, exact->denominator);
    return per_unit > 0 ? 1 / static_cast<double>(per_unit) : 0;  // NaN: 0
  };
  TiffResolution result{side(TIFFTAG_XRESOLUTION), side(TIFFTAG_YRESOLUTION), ""};
  const auto unit = field<std::uint16_t>(tiff_.get(), TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
  if (unit == RESUNIT_INCH) result.unit = "inch";
  if (unit == RESUNIT_CENTIMETER) result.unit = "cm";
  return result;
}

std::optional<std::uint64_t> TiffPage::raw_planes(const TiffLayout& layout, std::uint64_t planes, bool counted) const {
  TIFF* t = tiff_.get();
  if (layout.compression != COMPRESSION_NONE || is_tiled() || layout.bits % 8 != 0) return {};
  const std::uint64_t begin = TIFFGetStrileOffset(t, 0);
  std::uint64_t end = begin;
  for (std::uint32_t s = 0; s < TIFFNumberOfStrips(t); ++s) {
    if (TIFFGetStrileOffset(t, s) != end) return {};
    const std::uint64_t size = TIFFGetStrileByteCount(t, s);
    if (size > file_.size() - std::min(end, file_.size())) return {};
    end += size;
  }
  const std::uint64_t there = counted ? end - begin : file_.size() - std::min(begin, file_.size());
  if (there / layout.plane_bytes() < planes) return {};
  return begin;
}

std::uint32_t TiffPage::planes_together(const TiffLayout& layout) const {
  if (!is_tiled()) return 1;
  return std::clamp(tile_depth(), 1u, std::max(1u, layout.depth));
}

/// Strips and tiles begin behind the header of the file.
void TiffPage::check_pieces() const {
  const std::uint64_t header = file_.big_tiff() ? 16 : 8;
  TIFF* t = tiff_.get();
  const std::uint32_t pieces = is_tiled() ? TIFFNumberOfTiles(t) : TIFFNumberOfStrips(t);
  for (std::uint32_t p = 0; p < pieces; ++p)
    if (TIFFGetStrileOffset(t, p) < header && TIFFGetStrileByteCount(t, p) > 0)
      refuse("has samples inside the header of the file; it is damaged");
}

std::uint64_t TiffPage::buffer_bytes(const TiffLayout& layout) const {
  TIFF* t = tiff_.get();
  check_pieces();
  if (!is_tiled()) {
    const std::uint32_t rows = std::min(field<std::uint32_t>(t, TIFFTAG_ROWSPERSTRIP, layout.height), layout.height);
    if (rows == 0 || TIFFScanlineSize64(t) != layout.row_bytes() ||
        TIFFNumberOfStrips(t) != (layout.height - 1) / rows + 1)
      refuse("contradicts itself about the size of its strips; it is damaged");
    return 0;
  }
  const auto width = field<std::uint32_t>(t, TIFFTAG_TILEWIDTH, 0),
             height = field<std::uint32_t>(t, TIFFTAG_TILELENGTH, 0);
  const std::uint64_t row = TIFFTileRowSize64(t), plane = TIFFTileSize64(t), depth = tile_depth();
  const bool sound = width > 0 && height > 0 && depth > 0 && row == (width * layout.pixel_bits() + 7) / 8 &&
                     plane > 0 && plane / height == row && plane <= std::numeric_limits<std::int64_t>::max() / depth &&
                     (width >= layout.width || width * layout.pixel_bits() % 8 == 0);
  const std::uint64_t bytes = sound ? plane * depth : 0;
  if (!sound || bytes / std::max(1u, 8u / layout.bits) / largest_ratio(layout.compression) > file_.size())
    refuse("contradicts itself about the size of its tiles; it is damaged");
  if (depth > 1 && !decodes_any_size(layout.compression))
    refuse(
        fmt::format("has tiles of {} planes in a compression that is not read for them (Compression {}); save it "
                    "without compression",
                    depth, layout.compression));
  return bytes;
}

std::uint32_t TiffPage::tile_depth() const { return field<std::uint32_t>(tiff_.get(), TIFFTAG_TILEDEPTH, 1); }

bool TiffPage::decode(std::uint32_t piece, std::uint64_t at, std::uint64_t size, std::span<std::byte> out) {
  if (at >= file_.size() || size == 0 || size > file_.size() - at) return false;
  packed_.resize(size);
  return file_.read(at, packed_) == size &&
         TIFFReadFromUserBuffer(tiff_.get(), piece, packed_.data(), static_cast<tmsize_t>(size), out.data(),
                                static_cast<tmsize_t>(out.size())) == 1;
}

bool TiffPage::read_tile(std::uint32_t tile) {
  TIFF* t = tiff_.get();
  const auto size = static_cast<tmsize_t>(tile_.size());
  if (tile_depth() == 1) return TIFFReadEncodedTile(t, tile, tile_.data(), size) == size;
  // libtiff counts the tiles of a volume, but takes each for one plane deep.
  return decode(tile, TIFFGetStrileOffset(t, tile), TIFFGetStrileByteCount(t, tile), tile_);
}

void TiffPage::check_decoded(const TiffLayout& layout, bool whole) const {
  const bool goes_on = layout.compression == COMPRESSION_JPEG || layout.compression == COMPRESSION_PACKBITS ||
                       layout.compression == COMPRESSION_JBIG || layout.compression == COMPRESSION_CCITTRLE ||
                       layout.compression == COMPRESSION_CCITTRLEW || layout.compression == COMPRESSION_CCITTFAX3 ||
                       layout.compression == COMPRESSION_CCITTFAX4;
  if (!whole || !messages_->first_error.empty() || (goes_on && messages_->warned)) refuse_damaged();
}

// The JBIG library takes memory for the size its data claim, and ends the program when it gets none.
void TiffPage::check_jbig(const TiffLayout& layout, std::uint64_t at, std::uint32_t width, std::uint32_t height) const {
  if (layout.compression != COMPRESSION_JBIG) return;
  std::array<std::uint8_t, 20> header{};
  file_.read(at, std::as_writable_bytes(std::span(header)));
  if (!layout.lowest_bit_first) TIFFReverseBits(header.data(), header.size());  // libtiff writes it so
  const auto number = [&](std::size_t i) {
    return std::uint32_t{header[i]} << 24 | std::uint32_t{header[i + 1]} << 16 | std::uint32_t{header[i + 2]} << 8 |
           header[i + 3];
  };
  if (header[2] != 1 || number(4) != width || number(8) != height)
    refuse("is damaged or incomplete: its compressed samples are of another size");
}

void TiffPage::read_strips(const TiffLayout& layout, std::span<std::byte> out) {
  const std::uint32_t rows =
      std::min(field<std::uint32_t>(tiff_.get(), TIFFTAG_ROWSPERSTRIP, layout.height), layout.height);
  const std::uint64_t strip = rows * layout.row_bytes();
  for (std::uint32_t s = 0; s * strip < out.size(); ++s) {
    const auto part = out.subspan(s * strip, std::min(strip, out.size() - s * strip));
    const auto size = static_cast<tmsize_t>(part.size());
    check_jbig(layout, TIFFGetStrileOffset(tiff_.get(), s), layout.width,
               static_cast<std::uint32_t>(part.size() / layout.row_bytes()));
    check_decoded(layout, TIFFReadEncodedStrip(tiff_.get(), s, part.data(), size) == size);
  }
}

bool TiffPage::lists_strips_of_planes(const TiffLayout& layout) const {
  const auto& directory = file_.directories()[index_];
  const std::uint64_t strips = std::uint64_t{TIFFNumberOfStrips(tiff_.get())} * layout.depth;
  return !is_tiled() && file_.numbers(directory, TIFFTAG_STRIPOFFSETS).size() == strips &&
         file_.numbers(directory, TIFFTAG_STRIPBYTECOUNTS).size() == strips;
}

// libtiff knows the strips of the first plane only.
void TiffPage::read_strips_of_plane(const TiffLayout& layout, std::uint32_t plane, std::span<std::byte> out) {
  if (strip_offsets_.empty()) {
    strip_offsets_ = file_.numbers(file_.directories()[index_], TIFFTAG_STRIPOFFSETS);
    strip_sizes_ = file_.numbers(file_.directories()[index_], TIFFTAG_STRIPBYTECOUNTS);
  }
  const std::uint32_t rows =
      std::min(field<std::uint32_t>(tiff_.get(), TIFFTAG_ROWSPERSTRIP, layout.height), layout.height);
  const std::uint64_t strip = rows * layout.row_bytes();
  const std::size_t first = std::size_t{plane} * TIFFNumberOfStrips(tiff_.get());
  for (std::uint32_t s = 0; s * strip < out.size(); ++s) {
    const auto part = out.subspan(s * strip, std::min(strip, out.size() - s * strip));
    const std::uint64_t at = strip_offsets_.at(first + s);
    check_jbig(layout, at, layout.width, static_cast<std::uint32_t>(part.size() / layout.row_bytes()));
    check_decoded(layout, decode(s, at, strip_sizes_.at(first + s), part));
  }
}

void TiffPage::read_tiles(const TiffLayout& layout, std::uint32_t first, std::span<std::byte> out) {
  TIFF* t = tiff_.get();
  const auto width = field<std::uint32_t>(t, TIFFTAG_TILEWIDTH, 0),
             height = field<std::uint32_t>(t, TIFFTAG_TILELENGTH, 0);
  const std::uint64_t tile_row = TIFFTileRowSize64(t), row = layout.row_bytes(), plane = layout.plane_bytes();
  const auto planes = static_cast<std::uint32_t>(out.size() / plane);
  tile_.resize(TIFFTileSize64(t) * tile_depth());
  for (std::uint64_t y0 = 0; y0 < layout.height; y0 += height)
    for (std::uint64_t x0 = 0; x0 < layout.width; x0 += width) {
      const std::uint32_t tile =
          TIFFComputeTile(t, static_cast<std::uint32_t>(x0), static_cast<std::uint32_t>(y0), first, 0);
      check_jbig(layout, TIFFGetStrileOffset(t, tile), width, height);
      check_decoded(layout, read_tile(tile));
      const std::uint64_t left = x0 * layout.pixel_bits() / 8, bytes = std::min(tile_row, row - left);
      const std::uint64_t rows = std::min<std::uint64_t>(height, layout.height - y0);
      for (std::uint64_t z = 0; z < planes; ++z)
        for (std::uint64_t y = 0; y < rows; ++y)
          std::memcpy(&out[z * plane + (y0 + y) * row + left], &tile_[(z * height + y) * tile_row], bytes);
    }
}

void TiffPage::read_planes(const TiffLayout& layout, std::uint32_t first, std::span<std::byte> out) {
  *messages_ = {};  // what concerned the directory
  if (is_tiled())
    read_tiles(layout, first, out);
  else if (layout.depth > 1)
    read_strips_of_plane(layout, first, out);
  else
    read_strips(layout, out);
}

std::optional<std::vector<std::uint16_t>> TiffPage::grey_palette(const TiffLayout& layout) const {
  std::uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
  if (TIFFGetField(tiff_.get(), TIFFTAG_COLORMAP, &red, &green, &blue) != 1 || !red || !green || !blue) return {};
  const std::size_t size = std::size_t{1} << layout.bits;
  std::vector<std::uint16_t> greys(red, red + size);
  if (!std::equal(greys.begin(), greys.end(), green) || !std::equal(greys.begin(), greys.end(), blue)) return {};
  // Values of 16 bits; many writers give 8, as libtiff's own tools take into account.
  const bool wide = std::any_of(greys.begin(), greys.end(), [](std::uint16_t grey) { return grey > 255; });
  if (wide && layout.type == SampleType::uint8)
    for (std::uint16_t& grey : greys) grey >>= 8;
  return greys;
}

void TiffPage::to_values(const TiffLayout& layout, std::span<const std::byte> stored, std::span<std::byte> out) const {
  const std::uint64_t w = layout.width, row = layout.row_bytes();
  const bool palette = layout.photometric == PHOTOMETRIC_PALETTE, white = layout.photometric == PHOTOMETRIC_MINISWHITE;
  const auto greys = palette ? grey_palette(layout) : std::nullopt;
  if (layout.bits == 8 * shape::size_of(layout.type) && !greys) {
    std::memcpy(out.data(), stored.data(), out.size());
    if (white && layout.format != SAMPLEFORMAT_INT && layout.format != SAMPLEFORMAT_IEEEFP)
      for (std::byte& byte : out) byte = ~byte;  // the highest value minus this one, whatever its size
    return;
  }
  const auto each = [&]<class T>(T, const auto& value_of) {
    for (std::uint64_t y = 0; y < layout.height; ++y)
      for (std::uint64_t x = 0; x < w; ++x) {
        const T value = static_cast<T>(value_of(stored.data() + y * row, x));
        std::memcpy(&out[(y * w + x) * sizeof(T)], &value, sizeof(T));
      }
  };
  const auto bits_at = [bits = layout.bits](const std::byte* at, std::uint64_t x) {
    std::uint32_t three = 0;  // a sample of 15 bits touches at most three bytes; the row ends with its last bit
    const std::uint64_t first = x * bits / 8, last = (x * bits + bits - 1) / 8;
    for (std::uint64_t b = first; b <= last; ++b) three = three << 8 | std::to_integer<std::uint32_t>(at[b]);
    return three >> ((last + 1) * 8 - (x + 1) * bits) & ((1u << bits) - 1);
  };
  const std::uint32_t highest = (1u << layout.bits) - 1;
  if (layout.format == SAMPLEFORMAT_IEEEFP) {  // halves
    each(float{}, [](const std::byte* at, std::uint64_t x) {
      std::uint16_t half;
      std::memcpy(&half, at + 2 * x, 2);
      return from_half(half);
    });
  } else if (layout.type == SampleType::uint8) {
    const std::uint32_t scale = palette ? 1 : 255 / highest;
    each(std::uint8_t{}, [&](const std::byte* at, std::uint64_t x) {
      const std::uint32_t value = bits_at(at, x);
      return greys ? (*greys)[value] : (white ? highest - value : value) * scale;
    });
  } else {
    each(std::uint16_t{}, [&](const std::byte* at, std::uint64_t x) {
      std::uint16_t whole = 0;  // in the byte order of the machine, which samples of other sizes are not
      if (layout.bits == 16) std::memcpy(&whole, at + 2 * x, 2);
      const std::uint32_t value = layout.bits == 16 ? whole : bits_at(at, x);
      return greys ? (*greys)[value] : white ? highest - value : value;
    });
  }
}

void TiffPage::convert(const TiffLayout& layout, std::span<const std::byte> stored, std::span<std::byte> out) const {
  if (layout.orientation == ORIENTATION_TOPLEFT) return to_values(layout, stored, out);
  std::vector<std::byte> lying(out.size());
  to_values(layout, stored, lying);
  turn(layout, lying, out);
}

void TiffPage::turn(const TiffLayout& layout, std::span<const std::byte> lying, std::span<std::byte> out) {
  if (layout.orientation == ORIENTATION_TOPLEFT) {
    std::memcpy(out.data(), lying.data(), out.size());
    return;
  }
  switch (out.size() / layout.samples()) {
    case 1:
      return turn_upright<1>(layout, lying, out);
    case 2:
      return turn_upright<2>(layout, lying, out);
    case 4:
      return turn_upright<4>(layout, lying, out);
    default:
      return turn_upright<8>(layout, lying, out);
  }
}

}  // namespace quench::io
#endif
