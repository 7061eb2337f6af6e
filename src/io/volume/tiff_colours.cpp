// SPDX-License-Identifier: Apache-2.0
// Pages of TIFF with several samples per pixel, or a palette.
#include "io/volume/tiff_page.h"

#ifdef QUENCH_HAS_TIFF
#include <algorithm>
#include <cstring>
#include <limits>

namespace quench::io {

std::string TiffPage::kind_of_colours(const TiffLayout& layout) {
  if (layout.photometric == PHOTOMETRIC_PALETTE) return "a palette picture of colours";
  if (layout.channels == 2) return "a grey picture with alpha";
  return layout.alpha == TiffLayout::Alpha::none ? "an RGB picture" : "an RGBA picture";
}

namespace {

/// Pixels without samples, of the size of a page.
Pixels empty_pixels(const TiffLayout& layout, int channels) {
  Pixels pixels;
  pixels.width = layout.width;
  pixels.height = layout.height;
  pixels.channels = channels;
  pixels.white = layout.type == SampleType::uint8 ? 255 : 65535;
  pixels.kind = TiffPage::kind_of_colours(layout);
  return pixels;
}

template <class T>
std::vector<T> read_as(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// Leaves an extra sample that is not alpha out, and divides colours by the alpha they were multiplied by.
template <class T>
std::vector<T> straight_colours(const TiffLayout& layout, std::vector<T>&& stored) {
  const std::size_t n = layout.channels;
  if (layout.alpha == TiffLayout::Alpha::straight || n == 3) return std::move(stored);
  if (layout.alpha == TiffLayout::Alpha::none) {
    for (std::size_t i = 0; i < stored.size() / n; ++i)
      for (std::size_t c = 0; c < 3; ++c) stored[i * 3 + c] = stored[i * n + c];
    stored.resize(stored.size() / n * 3);
    return std::move(stored);
  }
  constexpr std::uint64_t white = std::numeric_limits<T>::max();
  for (std::size_t i = 0; i < stored.size(); i += n) {
    const std::uint64_t alpha = stored[i + n - 1];
    for (std::size_t c = 0; c + 1 < n; ++c)
      stored[i + c] = alpha == 0 ? T{0} : static_cast<T>(std::min(white, (stored[i + c] * white + alpha / 2) / alpha));
  }
  return std::move(stored);
}

}  // namespace

Pixels TiffPage::colours(const TiffLayout& layout, std::span<const std::byte> stored) const {
  const bool unknown = layout.channels == 4 && layout.alpha == TiffLayout::Alpha::none;
  Pixels pixels = empty_pixels(layout, unknown ? 3 : layout.channels);
  if (layout.type == SampleType::uint8)
    pixels.samples = straight_colours(layout, read_as<std::uint8_t>(stored));
  else
    pixels.samples = straight_colours(layout, read_as<std::uint16_t>(stored));
  return pixels;
}

Pixels TiffPage::colours_of_indices(const TiffLayout& layout, std::span<const std::byte> indices) const {
  std::array<std::uint16_t*, 3> map{};
  if (TIFFGetField(tiff_.get(), TIFFTAG_COLORMAP, &map[0], &map[1], &map[2]) != 1 || !map[0] || !map[1] || !map[2])
    refuse("has no palette for its indices; it is damaged");
  const std::size_t size = std::size_t{1} << layout.bits;
  const bool wide = std::any_of(map.begin(), map.end(), [size](const std::uint16_t* colour) {
    return std::any_of(colour, colour + size, [](std::uint16_t value) { return value > 255; });
  });
  Pixels pixels = empty_pixels(layout, 3);
  const auto take = [&]<class T>(T) {
    const int shift = wide && sizeof(T) == 1 ? 8 : 0;
    std::vector<T> samples;
    samples.reserve(layout.samples() * 3);
    for (const T index : read_as<T>(indices))
      for (const std::uint16_t* colour : map) samples.push_back(static_cast<T>(colour[index] >> shift));
    pixels.samples = std::move(samples);
  };
  if (layout.type == SampleType::uint8)
    take(std::uint8_t{});
  else
    take(std::uint16_t{});
  return pixels;
}

}  // namespace quench::io
#endif
