// SPDX-License-Identifier: Apache-2.0
// Portable bitmaps, greymaps and pixmaps, plain (P1 to P3) and raw (P4 to P6), as Netpbm documents them.
#include <fmt/format.h>

#include <string_view>

#include "io/volume/pixels.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

class PnmFile {
 public:
  explicit PnmFile(const std::filesystem::path& file) : file_(file) {
    InputFile in(file);
    bytes_.resize(in.size);
    in.stream.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    if (!in.stream || bytes_.size() < 2 || bytes_[0] != 'P' || bytes_[1] < '1' || bytes_[1] > '6')
      give_up("it does not begin with P1, P2, P3, P4, P5 or P6");
    kind_ = (bytes_[1] - '1') % 3;
    plain_ = bytes_[1] < '4';
    at_ = 2;
    pixels_.width = number(kMostSide, "its width");
    pixels_.height = number(kMostSide, "its height");
    pixels_.white = kind_ == 0 ? 1 : number(65535, "its largest value");
    if (pixels_.white == 0) give_up("its largest value is 0");
    pixels_.channels = kind_ == 2 ? 3 : 1;
    constexpr std::array kNames{"a bitmap", "a grey picture", "an RGB picture"};
    pixels_.kind = kNames[static_cast<std::size_t>(kind_)];
    if (!plain_ && (at_ >= bytes_.size() || !is_blank(bytes_[at_++]))) give_up("its header is incomplete");
  }

  Pixels read(Context* context) {
    const std::uint64_t size = pixels_.white > 255 ? 2 : 1, left = bytes_.size() - at_;
    const auto channels = static_cast<std::uint64_t>(pixels_.channels);
    // A raw bitmap has eight pixels to a byte; plain numbers take a byte at least, and one of two bytes is no shorter.
    const std::uint64_t available = kind_ == 0 && !plain_ ? left * 8 : plain_ ? (left + 1) * size : left;
    const std::uint64_t count =
        checked_sample_count(file_, {pixels_.width, pixels_.height, 1}, size * channels, available) * channels;
    check_read_memory(file_, count * size, context);
    if (size == 2)
      pixels_.samples = samples<std::uint16_t>(count);
    else if (kind_ == 0)
      pixels_.samples = bits(count);
    else
      pixels_.samples = samples<std::uint8_t>(count);
    if (kind_ == 0) pixels_.white = 255;
    while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
    if (at_ < bytes_.size())
      give_up(fmt::format("more follows behind its pixels, at byte {}; save the picture you mean on its own", at_));
    return std::move(pixels_);
  }

 private:
  static constexpr std::uint32_t kMostSide = 0x7FFFFFFF;

  [[noreturn]] void give_up(const std::string& why) const { refuse(file_, "PNM", why); }
  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  /// Blanks, and comments up to the end of their line.
  void skip_blanks() {
    for (; at_ < bytes_.size() && (is_blank(bytes_[at_]) || bytes_[at_] == '#'); ++at_)
      if (bytes_[at_] == '#')
        while (at_ + 1 < bytes_.size() && bytes_[at_ + 1] != '\n') ++at_;
  }
  std::uint32_t number(std::uint32_t most, std::string_view what) {
    skip_blanks();
    const std::size_t begin = at_;
    std::uint64_t value = 0;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9'; ++at_) {
      value = value * 10 + static_cast<std::uint64_t>(bytes_[at_] - '0');
      if (value > most) give_up(fmt::format("{}, at byte {}, is larger than {}", what, begin, most));
    }
    if (at_ == begin) give_up(fmt::format("{} is missing at byte {}; it is damaged or incomplete", what, begin));
    return static_cast<std::uint32_t>(value);
  }

  template <class T>
  std::vector<T> samples(std::uint64_t count) {
    std::vector<T> values(count);
    for (T& value : values) value = static_cast<T>(plain_ ? number(pixels_.white, "a value") : raw_number(sizeof(T)));
    return values;
  }
  std::uint32_t raw_number(std::size_t size) {
    std::uint32_t value = 0;
    for (std::size_t b = 0; b < size; ++b) value = value << 8 | static_cast<unsigned char>(bytes_[at_++]);
    if (value > pixels_.white)
      give_up(fmt::format("the value {} at byte {} is larger than {}", value, at_ - size, pixels_.white));
    return value;
  }

  /// 1 is black. Rows of raw bits begin with a byte of their own; plain digits need no blanks between them.
  std::vector<std::uint8_t> bits(std::uint64_t count) {
    const auto width = static_cast<std::uint64_t>(pixels_.width), row = (width + 7) / 8;
    if (!plain_ && row * static_cast<std::uint64_t>(pixels_.height) > bytes_.size() - at_)
      give_up("its pixels end early; it is damaged or incomplete");
    std::vector<std::uint8_t> values(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t x = i % width;
      const bool black = plain_ ? plain_bit() : (bytes_[at_ + i / width * row + x / 8] >> (7 - x % 8) & 1) != 0;
      values[i] = black ? 0 : 255;
    }
    if (!plain_) at_ += row * static_cast<std::uint64_t>(pixels_.height);
    return values;
  }
  bool plain_bit() {
    skip_blanks();
    if (at_ >= bytes_.size()) give_up("its pixels end early; it is damaged or incomplete");
    const char c = bytes_[at_++];
    if (c != '0' && c != '1') give_up(fmt::format("a pixel at byte {} is neither 0 nor 1", at_ - 1));
    return c == '1';
  }

  const std::filesystem::path& file_;
  std::string bytes_;
  std::size_t at_ = 0;
  int kind_ = 0;  ///< bits, greys, colours
  bool plain_ = false;
  Pixels pixels_;
};

}  // namespace

Pixels read_pnm(const std::filesystem::path& file, Context* context) {
  checkpoint(context, "read", 0);
  Pixels pixels = PnmFile(file).read(context);
  checkpoint(context, "read", 1);
  return pixels;
}

}  // namespace quench::io
