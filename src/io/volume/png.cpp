// SPDX-License-Identifier: Apache-2.0
// Grey PNG slices (PNG specification, 3rd edition). Our own reader, because libpng leaves a damaged file by longjmp;
// here it is an exception.
#include <fmt/format.h>
#include <zlib.h>

#include <cstdlib>
#include <cstring>

#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

std::uint32_t big_endian(const unsigned char* p) {
  return static_cast<std::uint32_t>(p[0]) << 24 | static_cast<std::uint32_t>(p[1]) << 16 |
         static_cast<std::uint32_t>(p[2]) << 8 | p[3];
}

struct Png {
  std::uint32_t width = 0, height = 0;
  int depth = 0, colour = 0;
  bool interlaced = false;
  std::vector<unsigned char> grey_of_index;  // of a palette of greys
  std::vector<unsigned char> packed;         // all IDAT chunks
};

[[noreturn]] void refuse_picture(const std::filesystem::path& file, const Png& png, const char* kind) {
  throw Error(
      ErrorCode::input,
      fmt::format(
          "'{}' is {} picture of {} x {} pixels, and Quench needs one value per voxel; convert it to grey "
          "values, e.g. with 'convert IN.png -colorspace Gray -alpha off OUT.png' (one picture is one slice: for "
          "a 3D shape give a folder of slices)",
          file.string(), kind, png.width, png.height));
}

void read_header(Png& png, const unsigned char* data, const std::filesystem::path& file) {
  png.width = big_endian(data);
  png.height = big_endian(data + 4);
  png.depth = data[8];
  png.colour = data[9];
  png.interlaced = data[12] == 1;
  if (data[10] != 0 || data[11] != 0 || data[12] > 1) refuse(file, "PNG", "its compression method is unknown");
  if (png.colour == 2 || png.colour == 4 || png.colour == 6)
    refuse_picture(file, png, png.colour == 2 ? "an RGB" : png.colour == 4 ? "a grey and transparent" : "an RGBA");
  if (png.colour != 0 && png.colour != 3) refuse(file, "PNG", fmt::format("its colour type {} is unknown", png.colour));
  const int d = png.depth;
  if (d != 1 && d != 2 && d != 4 && d != 8 && !(d == 16 && png.colour == 0))
    refuse(file, "PNG", fmt::format("{} bits per sample are not possible", d));
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
      for (std::uint32_t i = 0; i + 2 < length; i += 3) {
        if (png.colour == 3 && (data[i] != data[i + 1] || data[i] != data[i + 2]))
          refuse_picture(file, png, "a colour (palette)");
        png.grey_of_index.push_back(data[i]);
      }
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

template <class T>
std::vector<T> decode(const Png& png, const std::filesystem::path& file, std::uint64_t count) {
  static constexpr std::array<Pass, 1> kWhole{{{0, 0, 1, 1}}};
  static constexpr std::array<Pass, 7> kAdam7{
      {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4}, {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}}};
  const std::span<const Pass> passes = png.interlaced ? std::span<const Pass>(kAdam7) : std::span<const Pass>(kWhole);
  const auto depth = static_cast<std::uint64_t>(png.depth);
  std::uint64_t expected = 0;
  for (const Pass& p : passes)
    if (const std::uint64_t w = steps(png.width, p.x0, p.dx); w > 0)
      expected += steps(png.height, p.y0, p.dy) * (1 + (w * depth + 7) / 8);
  std::vector<unsigned char> raw(expected);
  uLongf got = raw.size();
  const int result = uncompress(raw.data(), &got, png.packed.data(), png.packed.size());
  if ((result != Z_OK && result != Z_BUF_ERROR) || got != expected)
    refuse(file, "PNG", "its compressed pixels are damaged; copy it again");

  std::vector<T> samples(count);
  const int scale = png.depth < 8 && png.colour == 0 ? 255 / ((1 << png.depth) - 1) : 1;
  unsigned char* row = raw.data();
  for (const Pass& p : passes) {
    const std::uint32_t w = steps(png.width, p.x0, p.dx), h = steps(png.height, p.y0, p.dy);
    const std::size_t size = (w * depth + 7) / 8;
    if (w == 0) continue;
    for (std::uint32_t r = 0; r < h; ++r, row += size + 1) {
      unfilter(row[0], row + 1, r == 0 ? nullptr : row - size, size, std::max(1, png.depth / 8), file);
      T* out = samples.data() + static_cast<std::uint64_t>(p.y0 + r * p.dy) * png.width;
      for (std::uint32_t c = 0; c < w; ++c) {
        int value;
        if (png.depth == 16) {
          value = row[1 + 2 * c] << 8 | row[2 + 2 * c];
        } else {
          const std::uint64_t bit = c * depth;
          value = row[1 + bit / 8] >> (8 - depth - bit % 8) & ((1 << depth) - 1);
        }
        if (png.colour == 3) {
          if (static_cast<std::size_t>(value) >= png.grey_of_index.size())
            refuse(file, "PNG", fmt::format("a pixel has colour {}, beyond the end of the palette", value));
          value = png.grey_of_index[static_cast<std::size_t>(value)];
        }
        out[p.x0 + c * p.dx] = static_cast<T>(value * scale);
      }
    }
  }
  return samples;
}

}  // namespace

Volume read_png(const std::filesystem::path& file, Context* context) {
  checkpoint(context, "read", 0);
  const Png png = read_chunks(file);
  Volume volume;
  volume.grid.dims = {png.width, png.height, 1};
  volume.grid.make_plane();
  volume.coordinates.y_down = true;
  // Eight pixels may share a byte of what was packed; rows begin with a byte of their own.
  const std::uint64_t available = png.packed.size() * kDeflateLimit;
  const std::uint64_t count = checked_sample_count(file, volume.grid.dims, png.depth == 16 ? 2 : 1, available * 8);
  check_read_memory(file, count * (png.depth == 16 ? 4 : 2), context);  // also the filtered rows
  if (png.depth == 16)
    volume.samples = decode<std::uint16_t>(png, file, count);
  else
    volume.samples = decode<std::uint8_t>(png, file, count);
  checkpoint(context, "read", 1);
  return volume;
}

}  // namespace quench::io
