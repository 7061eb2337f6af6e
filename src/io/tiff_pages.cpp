// SPDX-License-Identifier: Apache-2.0
// TIFF stacks page by page, through libtiff. Only what ITK reads in the same way is taken: the rest goes to ITK.
#include "io/slice_streams.h"

#ifdef QUENCH_HAS_TIFF
#include <fmt/format.h>
#include <tiffio.h>

#include <memory>

#include "io/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

struct Page {
  std::uint32_t width = 0, height = 0;
  std::uint16_t bits = 0, format = 0;
  bool operator==(const Page&) const = default;
};

template <class T>
T field(TIFF* tiff, std::uint32_t tag, T otherwise) {
  T value = otherwise;
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}

// The page that is open; nothing when it is not simple.
std::optional<Page> simple_page(TIFF* tiff) {
  const Page page{field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0), field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0),
                  field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 0),
                  field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT)};
  const bool simple = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1) == 1 &&
                      field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE) == PHOTOMETRIC_MINISBLACK &&
                      field<std::uint16_t>(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) == ORIENTATION_TOPLEFT &&
                      (field<std::uint32_t>(tiff, TIFFTAG_SUBFILETYPE, 0) & ~std::uint32_t{FILETYPE_PAGE}) == 0 &&
                      TIFFIsTiled(tiff) == 0 && page.width > 0 && page.height > 0;
  if (!simple) return {};
  return page;
}

std::optional<SampleType> sample_type(const Page& page) {
  const auto any = [&](int bits, std::uint16_t format) { return page.bits == bits && page.format == format; };
  if (any(8, SAMPLEFORMAT_UINT)) return SampleType::uint8;
  if (any(8, SAMPLEFORMAT_INT)) return SampleType::int8;
  if (any(16, SAMPLEFORMAT_UINT)) return SampleType::uint16;
  if (any(16, SAMPLEFORMAT_INT)) return SampleType::int16;
  if (any(32, SAMPLEFORMAT_UINT)) return SampleType::uint32;
  if (any(32, SAMPLEFORMAT_INT)) return SampleType::int32;
  if (any(32, SAMPLEFORMAT_IEEEFP)) return SampleType::float32;
  if (any(64, SAMPLEFORMAT_IEEEFP)) return SampleType::float64;
  return {};
}

}  // namespace

std::optional<SliceStream> open_tiff_pages(const std::filesystem::path& file, Context* context) {
  TIFFSetErrorHandler(nullptr);  // what fails is said once, by us
  TIFFSetWarningHandler(nullptr);
  const InputFile probe(file);
  const std::shared_ptr<TIFF> tiff(TIFFOpen(file.c_str(), "r"), [](TIFF* t) {
    if (t != nullptr) TIFFClose(t);
  });
  if (!tiff) return {};
  const std::optional<Page> first = simple_page(tiff.get());
  const std::optional<SampleType> type = first ? sample_type(*first) : std::nullopt;
  if (!type) return {};
  const bool sized = TIFFGetField(tiff.get(), TIFFTAG_XRESOLUTION, nullptr) == 1;
  std::int64_t pages = 1;
  while (TIFFReadDirectory(tiff.get()) == 1) {
    if (simple_page(tiff.get()) != first) return {};
    ++pages;
  }
  if (TIFFSetDirectory(tiff.get(), 0) != 1) return {};
  SliceStream stream;
  stream.grid.dims = {first->width, first->height, pages};
  stream.type = *type;
  const std::size_t size = first->bits / 8u, row = size * first->width;
  // LZW and fax pages shrink more than deflate does; the bound is that of read_itk().
  checked_sample_count(file, stream.grid.dims, size, probe.size << 20);
  check_read_memory(file, row * first->height, context);
  if (TIFFScanlineSize64(tiff.get()) != row) return {};
  stream.next = [tiff, file, row, pages, page = std::int64_t{0}](std::span<std::byte> out) mutable {
    if (page > 0 && TIFFReadDirectory(tiff.get()) != 1) slices_end_early(file, page, pages);
    for (std::uint32_t y = 0; (y + std::size_t{1}) * row <= out.size(); ++y)
      if (TIFFReadScanline(tiff.get(), out.data() + y * row, y, 0) != 1) slices_end_early(file, page, pages);
    ++page;
  };
  if (sized)
    note(context, fmt::format("'{}' gives a size of pixels but no distance of slices; the spacing is taken as 1 x 1 "
                              "x 1 (change it with --spacing)",
                              file.string()));
  return stream;
}

}  // namespace quench::io
#else
namespace quench::io {
std::optional<SliceStream> open_tiff_pages(const std::filesystem::path&, Context*) { return {}; }
}  // namespace quench::io
#endif
