// SPDX-License-Identifier: Apache-2.0
// PNG pictures (PNG specification, 3rd edition). Our own reader, because libpng leaves a damaged file by longjmp; here
// it is an exception.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include "io/volume/pixels.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

std::uint32_t big_endian(const unsigned char* p) {
  return static_cast<std::uint32_t>(p[0]) << 24 | static_cast<std::uint32_t>(p[1]) << 16 |
         static_cast<std::uint32_t>(p[2]) << 8 | p[3];
}

enum PngColour { png_grey = 0, png_rgb = 2, png_palette = 3, png_grey_alpha = 4, png_rgb_alpha = 6 };

struct Png {
  std::uint32_t width = 0, height = 0;
  int depth = 0, colour = 0;
  bool interlaced = false;
  std::vector<std::array<unsigned char, 4>> colours;        // of a palette: red, green, blue, alpha
  std::optional<std::array<std::uint32_t, 3>> transparent;  // of grey and RGB: this value is (tRNS)
  bool grey_palette = true, palette_has_alpha = false;
  std::vector<unsigned char> packed;  // all IDAT chunks

  /// Samples of a pixel as they are stored.
  std::uint32_t stored() const {
    return colour == png_rgb ? 3 : colour == png_grey_alpha ? 2 : colour == png_rgb_alpha ? 4 : 1;
  }
  std::uint32_t bits() const { return stored() * static_cast<std::uint32_t>(depth); }
  /// Samples of a pixel as they are given back.
  int channels() const {
    if (colour == png_palette) return (grey_palette ? 1 : 3) + palette_has_alpha;
    return static_cast<int>(stored()) + transparent.has_value();
  }
};

std::string kind_of(const Png& png) {
  const bool alpha = png.channels() % 2 == 0;
  if (png.colour == png_palette)
    return fmt::format("a palette picture of {}{}", png.grey_palette ? "greys" : "colours", alpha ? " and alpha" : "");
  if (png.channels() < 3) return alpha ? "a grey picture with alpha" : "a grey picture";
  return alpha ? "an RGBA picture" : "an RGB picture";
}

void read_header(Png& png, const unsigned char* data, const std::filesystem::path& file) {
  png.width = big_endian(data);
  png.height = big_endian(data + 4);
  png.depth = data[8];
  png.colour = data[9];
  png.interlaced = data[12] == 1;
  if (data[10] != 0 || data[11] != 0 || data[12] > 1) refuse(file, "PNG", "its compression method is unknown");
  if (png.colour > 6 || png.colour == 1 || png.colour == 5)
    refuse(file, "PNG", fmt::format("its colour type {} is unknown", png.colour));
  const int d = png.depth;
  const bool low = png.colour == png_grey || png.colour == png_palette;
  if (d != 8 && !(d == 16 && png.colour != png_palette) && !(low && (d == 1 || d == 2 || d == 4)))
    refuse(file, "PNG", fmt::format("{} bits per sample are not possible", d));
}

void read_palette(Png& png, std::span<const unsigned char> data, const std::filesystem::path& file) {
  if (png.colour != png_palette) return;  // colours to show the others with
  if (data.size() % 3 != 0 || data.size() > 768 || !png.colours.empty())
    refuse(file, "PNG", fmt::format("its palette of {} bytes is not possible, or repeated", data.size()));
  for (std::size_t i = 0; i < data.size(); i += 3) {
    png.colours.push_back({data[i], data[i + 1], data[i + 2], 255});
    png.grey_palette = png.grey_palette && data[i] == data[i + 1] && data[i] == data[i + 2];
  }
}

void read_transparency(Png& png, std::span<const unsigned char> data, const std::filesystem::path& file) {
  const std::uint32_t samples = png.stored();
  if (png.colour == png_palette) {
    if (data.size() > png.colours.size())
      refuse(file, "PNG", "it has more transparent colours than its palette has colours");
    for (std::size_t i = 0; i < data.size(); ++i) png.colours[i][3] = data[i];
    png.palette_has_alpha = std::any_of(data.begin(), data.end(), [](unsigned char a) { return a != 255; });
  } else if (png.colour == png_grey || png.colour == png_rgb) {
    if (data.size() != 2 * samples) refuse(file, "PNG", "its transparent colour is not one of its kind of picture");
    png.transparent.emplace();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t at = 2 * std::min<std::size_t>(i, samples - 1);
      (*png.transparent)[i] = static_cast<std::uint32_t>(data[at] << 8 | data[at + 1]);
    }
  }
}

Png read_chunks(const std::filesystem::path& file) {
  InputFile in(file);
  std::vector<unsigned char> bytes(in.size);
  in.stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in.stream || bytes.size() < 8 || std::memcmp(bytes.data(), "\x89PNG\r\n\x1a\n", 8) != 0)
    refuse(file, "PNG", "it does not begin as one");
  Png png;
  for (std::size_t at = 8;;) {
    if (bytes.size() - at < 12) refuse(file, "PNG", fmt::format("it is cut off at byte {}", bytes.size()));
    const std::uint32_t length = big_endian(&bytes[at]);
    if (length > bytes.size() - at - 12) refuse(file, "PNG", fmt::format("it is cut off in the chunk at byte {}", at));
    const unsigned char* data = &bytes[at + 8];
    const auto type = std::string_view(reinterpret_cast<const char*>(&bytes[at + 4]), 4);
    if (crc32(0, &bytes[at + 4], length + 4) != big_endian(data + length))
      refuse(file, "PNG",
             fmt::format("the checksum of the chunk at byte {} is wrong: the file is damaged; copy it again", at));
    if ((at == 8) != (type == "IHDR") || (at == 8 && length != 13))
      refuse(file, "PNG", "its header is missing or repeated");
    if (type == "IHDR") {
      read_header(png, data, file);
    } else if (type == "PLTE") {
      read_palette(png, {data, length}, file);
    } else if (type == "tRNS") {
      read_transparency(png, {data, length}, file);
    } else if (type == "IDAT") {
      png.packed.insert(png.packed.end(), data, data + length);
    } else if (type == "IEND") {
      return png;
    } else if (!(type[0] & 0x20)) {
      refuse(file, "PNG", fmt::format("the critical chunk at byte {} is unknown", at));
    }
    at += 12 + static_cast<std::size_t>(length);
  }
}

// Undoes the filter of one row in place (PNG specification, sec. 9); `step` is the distance to the pixel before.
void unfilter(unsigned char type, unsigned char* row, const unsigned char* above, std::size_t size, std::size_t step,
              const std::filesystem::path& file) {
  if (type > 4) refuse(file, "PNG", fmt::format("a row has the unknown filter {}", type));
  for (std::size_t i = 0; i < size; ++i) {
    const int left = i < step ? 0 : row[i - step];
    const int up = above ? above[i] : 0;
    const int corner = above && i >= step ? above[i - step] : 0;
    int guess = 0;
    if (type == 1) guess = left;
    if (type == 2) guess = up;
    if (type == 3) guess = (left + up) / 2;
    if (type == 4) {
      const int a = std::abs(up - corner), b = std::abs(left - corner), c = std::abs(left + up - 2 * corner);
      guess = a <= b && a <= c ? left : b <= c ? up : corner;
    }
    row[i] = static_cast<unsigned char>(row[i] + guess);
  }
}

// One image, or one of the seven reduced images of an interlaced one.
struct Pass {
  std::uint32_t x0, y0, dx, dy;
};

std::uint32_t steps(std::uint32_t size, std::uint32_t first, std::uint32_t step) {
  return size <= first ? 0 : (size - first - 1) / step + 1;
}

/// The rows of all images one after the other, each behind the type of its filter.
std::vector<unsigned char> inflated(const Png& png, std::span<const Pass> passes, const std::filesystem::path& file) {
  std::uint64_t expected = 0;
  for (const Pass& p : passes)
    if (const std::uint64_t w = steps(png.width, p.x0, p.dx); w > 0)
      expected += steps(png.height, p.y0, p.dy) * (1 + (w * png.bits() + 7) / 8);
  std::vector<unsigned char> raw(expected);
  uLongf got = raw.size();
  const int result = uncompress(raw.data(), &got, png.packed.data(), png.packed.size());
  if ((result != Z_OK && result != Z_BUF_ERROR) || got != expected)
    refuse(file, "PNG", "its compressed pixels are damaged; copy it again");
  return raw;
}

/// Writes the pixels of a row where they belong.
template <class T>
class RowReader {
 public:
  RowReader(const Png& png, const std::filesystem::path& file)
      : png_(png), file_(file), scale_(png.depth < 8 && png.colour == png_grey ? 255u / ((1u << png.depth) - 1) : 1) {}

  void pixel(const unsigned char* row, std::uint64_t at, T* out) const {
    const std::uint32_t n = png_.stored();
    std::array<std::uint32_t, 4> value{};
    for (std::uint32_t c = 0; c < n; ++c) value[c] = sample(row, at * n + c);
    if (png_.colour == png_palette) return colour(value[0], out);
    for (std::uint32_t c = 0; c < n; ++c) out[c] = static_cast<T>(value[c] * scale_);
    if (!png_.transparent) return;
    const bool seen = !std::equal(value.begin(), value.begin() + n, png_.transparent->begin());
    out[n] = seen ? std::numeric_limits<T>::max() : T{0};
  }

 private:
  std::uint32_t sample(const unsigned char* row, std::uint64_t at) const {
    const auto depth = static_cast<std::uint64_t>(png_.depth);
    if (depth == 16) return static_cast<std::uint32_t>(row[2 * at] << 8 | row[2 * at + 1]);
    const std::uint64_t bit = at * depth;
    return static_cast<std::uint32_t>(row[bit / 8] >> (8 - depth - bit % 8) & ((1 << depth) - 1));
  }
  void colour(std::uint32_t index, T* out) const {
    if (index >= png_.colours.size())
      refuse(file_, "PNG", fmt::format("a pixel has colour {}, beyond the end of the palette", index));
    const auto& rgba = png_.colours[index];
    const std::size_t n = png_.grey_palette ? 1 : 3;
    for (std::size_t c = 0; c < n; ++c) out[c] = rgba[c];
    if (png_.palette_has_alpha) out[n] = rgba[3];
  }

  const Png& png_;
  const std::filesystem::path& file_;
  std::uint32_t scale_;
};

template <class T>
std::vector<T> decode(const Png& png, const std::filesystem::path& file, std::uint64_t count) {
  static constexpr std::array<Pass, 1> kWhole{{{0, 0, 1, 1}}};
  static constexpr std::array<Pass, 7> kAdam7{
      {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4}, {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}}};
  const std::span<const Pass> passes = png.interlaced ? std::span<const Pass>(kAdam7) : std::span<const Pass>(kWhole);
  std::vector<unsigned char> raw = inflated(png, passes, file);
  const auto channels = static_cast<std::uint64_t>(png.channels());
  std::vector<T> samples(count * channels);
  const RowReader<T> reader(png, file);
  unsigned char* row = raw.data();
  for (const Pass& p : passes) {
    const std::uint32_t w = steps(png.width, p.x0, p.dx), h = steps(png.height, p.y0, p.dy);
    const std::size_t size = (static_cast<std::size_t>(w) * png.bits() + 7) / 8;
    if (w == 0) continue;
    for (std::uint32_t r = 0; r < h; ++r, row += size + 1) {
      unfilter(row[0], row + 1, r == 0 ? nullptr : row - size, size, std::max(1u, png.bits() / 8), file);
      T* out = samples.data() + static_cast<std::uint64_t>(p.y0 + r * p.dy) * png.width * channels;
      for (std::uint32_t c = 0; c < w; ++c) reader.pixel(row + 1, c, out + (p.x0 + c * p.dx) * channels);
    }
  }
  return samples;
}

}  // namespace

Pixels read_png(const std::filesystem::path& file, Context* context) {
  checkpoint(context, "read", 0);
  const Png png = read_chunks(file);
  Pixels pixels;
  pixels.width = png.width;
  pixels.height = png.height;
  pixels.channels = png.channels();
  pixels.kind = kind_of(png);
  // Eight pixels may share a byte of what was packed; rows begin with a byte of their own.
  const std::uint64_t available = png.packed.size() * kDeflateLimit;
  const std::uint64_t size = png.depth == 16 ? 2 : 1;
  const std::uint64_t count =
      checked_sample_count(file, {png.width, png.height, 1}, size * png.stored(), available * (png.bits() < 8 ? 8 : 1));
  check_read_memory(file, count * size * (png.stored() + static_cast<std::uint64_t>(pixels.channels)), context);
  if (png.depth == 16) {
    pixels.white = 65535;
    pixels.samples = decode<std::uint16_t>(png, file, count);
  } else {
    pixels.samples = decode<std::uint8_t>(png, file, count);
  }
  checkpoint(context, "read", 1);
  return pixels;
}

}  // namespace quench::io
