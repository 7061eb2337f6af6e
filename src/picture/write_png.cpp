// SPDX-License-Identifier: Apache-2.0
// PNG (second edition), through zlib, which the library has anyway: eight bits of red, green and blue, rows filtered by
// the least sum of absolute differences. Strips are deflated on their own, so that threads share the work.
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <array>
#include <cstdlib>
#include <ostream>
#include <span>

#include "base/deflated.h"
#include "base/parallel.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/picture.h"

namespace quench {
namespace {

constexpr std::size_t kStrip = 1 << 18;  // bytes

std::string big_endian(std::uint32_t x) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(x >> shift & 0xFF);
  return bytes;
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const uLong check = crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size());
  return big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(static_cast<std::uint32_t>(check));
}

std::uint8_t paeth(int left, int up, int corner) {
  const int p = left + up - corner, a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
  return static_cast<std::uint8_t>(a <= b && a <= c ? left : b <= c ? up : corner);
}

/// A row as the differences to what each of the five filters expects; the best of them with its number before it.
std::string filtered(std::span<const std::uint8_t> row, std::span<const std::uint8_t> above) {
  std::string best;
  long least = 0;
  for (int filter = 0; filter < 5; ++filter) {
    std::string out(1, static_cast<char>(filter));
    out.reserve(row.size() + 1);
    long sum = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const int left = i < 3 ? 0 : row[i - 3], up = above.empty() ? 0 : above[i],
                corner = i < 3 || above.empty() ? 0 : above[i - 3];
      const std::array<int, 5> expected{0, left, up, (left + up) / 2, paeth(left, up, corner)};
      const auto difference = static_cast<std::int8_t>(row[i] - expected[static_cast<std::size_t>(filter)]);
      out += static_cast<char>(difference);
      sum += std::abs(int{difference});
    }
    if (best.empty() || sum < least) {
      least = sum;
      best = std::move(out);
    }
  }
  return best;
}

/// The rows as one zlib stream.
std::string packed(const Picture& picture) {
  const auto height = static_cast<std::size_t>(picture.height);
  const std::size_t width = 3 * static_cast<std::size_t>(picture.width),
                    rows = std::max<std::size_t>(1, kStrip / width);
  const std::size_t strips = (height + rows - 1) / rows;
  std::vector<std::optional<std::string>> parts(strips);
  std::vector<uLong> checks(strips);
  std::vector<std::size_t> sizes(strips);
  tbb::parallel_for(std::size_t{0}, strips, [&](std::size_t s) {
    std::string raw;
    for (std::size_t y = s * rows; y < std::min(height, (s + 1) * rows); ++y) {
      const std::span<const std::uint8_t> all(picture.pixels);
      raw += filtered(all.subspan(y * width, width), y == 0 ? all.first(0) : all.subspan((y - 1) * width, width));
    }
    checks[s] = adler32_z(adler32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(raw.data()), raw.size());
    sizes[s] = raw.size();
    parts[s] = base::deflated(raw, 5, Z_FILTERED, s + 1 == strips);
  });
  if (std::find(parts.begin(), parts.end(), std::nullopt) != parts.end())
    throw Error(ErrorCode::failed, "zlib cannot compress a picture: not enough memory");
  std::string out = "\x78\x9c";
  uLong check = adler32_z(0, nullptr, 0);
  for (std::size_t s = 0; s < strips; ++s) {
    out += *parts[s];
    check = adler32_combine(check, checks[s], static_cast<z_off_t>(sizes[s]));
  }
  return out + big_endian(static_cast<std::uint32_t>(check));
}

}  // namespace

void write_png(const std::filesystem::path& file, const Picture& picture, Context* context) {
  base::in_arena(context, [&] {
    const std::string header = big_endian(static_cast<std::uint32_t>(picture.width)) +
                               big_endian(static_cast<std::uint32_t>(picture.height)) +
                               std::string("\x08\x02\0\0\0", 5);
    const std::string data = packed(picture);
    io::write_atomically(file, [&](std::ostream& out) {
      out << "\x89PNG\r\n\x1a\n" << chunk("IHDR", header) << chunk("IDAT", data) << chunk("IEND", "");
    });
  });
}

}  // namespace quench
