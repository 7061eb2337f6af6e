// SPDX-License-Identifier: Apache-2.0
// Windows and OS/2 bitmaps: 1, 4 and 8 bits with a palette (also RLE8 and RLE4), 16, 24 and 32 bits.
#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <span>

#include "io/volume/pixels.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

enum Compression : std::uint32_t { bi_rgb = 0, bi_rle8 = 1, bi_rle4 = 2, bi_bitfields = 3, bi_alphabitfields = 6 };

/// One of the colours of a pixel: the bits of a mask, stretched to 255.
struct BitField {
  std::uint32_t mask = 0;

  std::uint8_t of(std::uint32_t pixel) const {
    const int shift = std::countr_zero(mask);
    const std::uint64_t most = mask >> shift;
    return static_cast<std::uint8_t>(((pixel & mask) >> shift) * 255ull / most);
  }
  bool is_one_piece() const {
    return mask != 0 && std::has_single_bit((std::uint64_t{mask} >> std::countr_zero(mask)) + 1);
  }
};

class BmpFile {
 public:
  explicit BmpFile(const std::filesystem::path& file) : file_(file) {
    InputFile in(file);
    bytes_.resize(in.size);
    in.stream.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    if (!in.stream || bytes_.size() < 26 || bytes_[0] != 'B' || bytes_[1] != 'M') give_up("it does not begin as one");
    read_header();
    if (bits_ <= 8)
      read_palette();
    else
      read_fields();
    set_kind();
  }

  Pixels read(Context* context) {
    const bool packed = compression_ == bi_rle8 || compression_ == bi_rle4;
    const std::uint64_t left = bytes_.size() - begin_, w = width(), h = height();
    // Two bytes are a run of up to 255 pixels or end a row; what a small picture leaves out is not counted.
    constexpr std::uint64_t kSmall = 1 << 20, kWidest = 1 << 16;
    if (packed && w > kWidest) give_up(fmt::format("its rows are longer than {} pixels", kWidest));
    const std::uint64_t available = packed ? std::max(kSmall, (left / 2 + 1) * std::max<std::uint64_t>(255, w))
                                           : left * 8 / static_cast<std::uint64_t>(bits_);
    const std::uint64_t count = checked_sample_count(file_, {pixels_.width, pixels_.height, 1}, 1, available);
    const std::uint64_t row = (w * static_cast<std::uint64_t>(bits_) + 31) / 32 * 4;
    // The last row may do without the bytes that fill it up.
    if (!packed && (h - 1) * row + (w * static_cast<std::uint64_t>(bits_) + 7) / 8 > left)
      give_up("its pixels end early; it is damaged or incomplete");
    if (pixels_.has_alpha() && !any_alpha(row)) {
      fields_[3].mask = 0;
      set_kind();
    }
    const auto channels = static_cast<std::uint64_t>(pixels_.channels);
    check_read_memory(file_, count * (channels + packed), context);
    std::vector<std::uint8_t> samples(count * channels);
    if (packed) {
      const std::vector<std::uint8_t> indices = unpacked(count);
      for (std::uint64_t i = 0; i < count; ++i) put_colour(indices[i], &samples[i * channels]);
    } else {
      for (std::uint64_t y = 0; y < h; ++y) {
        const unsigned char* in = row_of(y, row);
        for (std::uint64_t x = 0; x < w; ++x) put_pixel(in, x, &samples[(y * w + x) * channels]);
      }
    }
    pixels_.samples = std::move(samples);
    return std::move(pixels_);
  }

 private:
  [[noreturn]] void give_up(const std::string& why) const { refuse(file_, "BMP", why); }
  std::uint64_t width() const { return static_cast<std::uint64_t>(pixels_.width); }
  std::uint64_t height() const { return static_cast<std::uint64_t>(pixels_.height); }
  std::uint32_t word(std::size_t at, std::size_t size = 4) const {
    if (at + size > bytes_.size()) give_up("its header is incomplete");
    std::uint32_t value = 0;
    for (std::size_t b = size; b-- > 0;) value = value << 8 | bytes_[at + b];
    return value;
  }

  void read_header() {
    begin_ = word(10);
    header_ = word(14);
    old_ = header_ == 12;
    if (!old_ && (header_ < 40 || header_ > 1024)) give_up(fmt::format("its header of {} bytes is not known", header_));
    const auto side = [&](std::size_t at) {
      return old_ ? std::int64_t{word(at, 2)} : std::int64_t{static_cast<std::int32_t>(word(at))};
    };
    pixels_.width = side(18);
    pixels_.height = side(old_ ? 20 : 22);
    top_down_ = pixels_.height < 0;
    if (top_down_) pixels_.height = -pixels_.height;
    bits_ = static_cast<int>(word(old_ ? 24 : 28, 2));
    compression_ = old_ ? std::uint32_t{bi_rgb} : word(30);
    const bool fields = compression_ == bi_bitfields || compression_ == bi_alphabitfields;
    const bool possible = compression_ == bi_rgb
                              ? bits_ == 1 || bits_ == 4 || bits_ == 8 || bits_ == 16 || bits_ == 24 || bits_ == 32
                          : compression_ == bi_rle8 ? bits_ == 8 && !top_down_
                          : compression_ == bi_rle4 ? bits_ == 4 && !top_down_
                                                    : fields && (bits_ == 16 || bits_ == 32);
    if (!possible)
      give_up(fmt::format("{} bits per pixel with compression {} are not read; save it as PNG", bits_, compression_));
    if (begin_ < 14 + std::uint64_t{header_} || begin_ > bytes_.size())
      give_up(fmt::format("its pixels begin at byte {} of {}", begin_, bytes_.size()));
  }

  void read_palette() {
    const std::uint32_t most = 1u << bits_, named = old_ ? 0 : word(46);
    const std::size_t size = old_ ? 3 : 4, first = 14 + std::size_t{header_};
    if (named > most) give_up(fmt::format("it has a palette of {} colours for {} bits per pixel", named, bits_));
    // Old files have as many as there is place for.
    const std::size_t count = std::min<std::size_t>(named ? named : most, (begin_ - first) / size);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned char* bgr = bytes_.data() + first + i * size;
      palette_.push_back({bgr[2], bgr[1], bgr[0]});
      grey_ = grey_ && bgr[0] == bgr[1] && bgr[0] == bgr[2];
    }
  }

  void read_fields() {
    grey_ = false;
    if (bits_ == 16) fields_ = {BitField{0x7C00}, BitField{0x3E0}, BitField{0x1F}, BitField{0}};
    if (compression_ == bi_rgb) return;
    // Behind a header of 40 bytes or inside a longer one, at the same place.
    const bool alpha = compression_ == bi_alphabitfields || header_ >= 56;
    for (std::size_t c = 0; c < (alpha ? 4 : 3); ++c) fields_[c].mask = word(54 + 4 * c);
    std::uint64_t sum = 0, all = 0;
    for (const BitField& field : fields_) {
      sum += field.mask;
      all |= field.mask;
      if ((&field != &fields_[3] || field.mask != 0) && !field.is_one_piece())
        give_up("the masks of its colours are not possible");
    }
    if (sum != all || (bits_ == 16 && all > 0xFFFF)) give_up("the masks of its colours are not possible");
  }

  void set_kind() {
    const bool alpha = bits_ > 8 && fields_[3].mask != 0;
    pixels_.channels = bits_ <= 8 ? (grey_ ? 1 : 3) : alpha ? 4 : 3;
    pixels_.kind = bits_ <= 8 ? (grey_ ? "a palette picture of greys" : "a palette picture of colours")
                   : alpha    ? "an RGBA picture"
                              : "an RGB picture";
  }

  const unsigned char* row_of(std::uint64_t y, std::uint64_t bytes) const {
    return bytes_.data() + begin_ + (top_down_ ? y : height() - 1 - y) * bytes;
  }

  /// Of 16 to 32 bits.
  std::uint32_t pixel_at(const unsigned char* row, std::uint64_t x) const {
    const std::size_t size = static_cast<std::size_t>(bits_) / 8;
    std::uint32_t pixel = 0;
    for (std::size_t b = size; b-- > 0;) pixel = pixel << 8 | row[x * size + b];
    return pixel;
  }

  /// Programs that know no transparency leave the bytes of alpha 0 in all pixels: such a picture is opaque.
  bool any_alpha(std::uint64_t row) const {
    for (std::uint64_t y = 0; y < height(); ++y)
      for (std::uint64_t x = 0; x < width(); ++x)
        if ((pixel_at(row_of(y, row), x) & fields_[3].mask) != 0) return true;
    return false;
  }

  void put_colour(std::uint32_t index, std::uint8_t* out) const {
    if (index >= palette_.size()) give_up(fmt::format("a pixel has colour {}, beyond the end of the palette", index));
    for (std::size_t c = 0; c < static_cast<std::size_t>(pixels_.channels); ++c) out[c] = palette_[index][c];
  }

  void put_pixel(const unsigned char* row, std::uint64_t x, std::uint8_t* out) const {
    if (bits_ <= 8) {
      const std::uint64_t bit = x * static_cast<std::uint64_t>(bits_);
      const int shift = 8 - bits_ - static_cast<int>(bit % 8);
      return put_colour(static_cast<std::uint32_t>(row[bit / 8] >> shift & ((1 << bits_) - 1)), out);
    }
    const std::uint32_t pixel = pixel_at(row, x);
    for (std::size_t c = 0; c < static_cast<std::size_t>(pixels_.channels); ++c) out[c] = fields_[c].of(pixel);
  }

  /// The colours of all pixels of a run-length encoded picture, from its top; those that are left out have colour 0.
  std::vector<std::uint8_t> unpacked(std::uint64_t count) const {
    std::vector<std::uint8_t> out(count, 0);
    const std::span<const unsigned char> in(bytes_.data() + begin_, bytes_.size() - begin_);
    const std::uint64_t w = width(), h = height();
    std::uint64_t x = 0, y = 0;
    std::size_t at = 0;
    const auto byte = [&]() -> std::uint32_t {
      if (at >= in.size()) give_up("its pixels end early; it is damaged or incomplete");
      return in[at++];
    };
    const auto put = [&](std::uint32_t colour) {
      if (x >= w || y >= h) give_up("a run of pixels is longer than its row; it is damaged");
      out[(h - 1 - y) * w + x++] = static_cast<std::uint8_t>(colour);
    };
    const bool nibbles = compression_ == bi_rle4;
    for (;;) {
      const std::uint32_t length = byte(), code = byte();
      if (length > 0) {
        for (std::uint32_t i = 0; i < length; ++i) put(!nibbles ? code : i % 2 == 0 ? code >> 4 : code & 15);
      } else if (code == 0) {
        x = 0;
        ++y;
      } else if (code == 1) {
        return out;
      } else if (code == 2) {
        x += byte();
        y += byte();
      } else {  // pixels one by one, filled up to two bytes
        std::uint32_t value = 0;
        for (std::uint32_t i = 0; i < code; ++i) {
          if (!nibbles || i % 2 == 0) value = byte();
          put(!nibbles ? value : i % 2 == 0 ? value >> 4 : value & 15);
        }
        if (((nibbles ? (code + 1) / 2 : code) & 1) != 0) byte();
      }
    }
  }

  const std::filesystem::path& file_;
  std::vector<unsigned char> bytes_;
  std::uint32_t begin_ = 0, header_ = 0, compression_ = 0;
  int bits_ = 0;
  bool old_ = false, top_down_ = false, grey_ = true;
  std::vector<std::array<std::uint8_t, 3>> palette_;
  std::array<BitField, 4> fields_{BitField{0xFF0000}, BitField{0xFF00}, BitField{0xFF}, BitField{0}};
  Pixels pixels_;
};

}  // namespace

Pixels read_bmp(const std::filesystem::path& file, Context* context) {
  checkpoint(context, "read", 0);
  Pixels pixels = BmpFile(file).read(context);
  checkpoint(context, "read", 1);
  return pixels;
}

}  // namespace quench::io
