// SPDX-License-Identifier: Apache-2.0
// TIFF volumes: what is read is what the file holds, all of it; everything else is one sentence.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "small_files.h"
#include "tiff_fixture.h"
#ifdef QUENCH_TESTS_HAVE_TIFF
#include <tiffio.h>

namespace quench {
namespace tiff_test {

using namespace testing_tiff;

/// Rows of `width` bytes cut into tiles, filled up with rubbish at the edges.
std::vector<std::string> tiles(const std::vector<std::string>& planes, std::size_t row, std::size_t tile_row,
                               std::size_t tile_rows, std::size_t tile_planes) {
  std::vector<std::string> result;
  const std::size_t rows = planes[0].size() / row;
  for (std::size_t z0 = 0; z0 < planes.size(); z0 += tile_planes)
    for (std::size_t y0 = 0; y0 < rows; y0 += tile_rows)
      for (std::size_t x0 = 0; x0 < row; x0 += tile_row) {
        std::string& tile = result.emplace_back();
        for (std::size_t z = z0; z < z0 + tile_planes; ++z)
          for (std::size_t y = y0; y < y0 + tile_rows; ++y) {
            std::string piece;
            if (z < planes.size() && y < rows) piece = planes[z].substr(y * row + x0, std::min(tile_row, row - x0));
            tile += piece + std::string(tile_row - piece.size(), '\x55');
          }
      }
  return result;
}

constexpr std::uint32_t width = 21, height = 19;

template <class T>
void every_layout(const std::function<Volume(const std::string&)>& read, std::uint32_t format) {
  std::mt19937_64 random(sizeof(T) * 10 + format);
  std::vector<std::vector<T>> pages(3);
  std::vector<T> all;
  for (auto& page : pages)
    for (std::uint32_t i = 0; i < width * height; ++i) {
      if constexpr (std::is_floating_point_v<T>)
        page.push_back(static_cast<T>(static_cast<double>(random() % 20000) / 8 - 1000));
      else
        page.push_back(static_cast<T>(random()));
      all.push_back(page.back());
    }
  for (const bool big_endian : {false, true})
    for (const bool big_tiff : {false, true})
      for (const int layout : {0, 1, 2, 3}) {  // a strip, strips, tiles, compressed tiles
        TiffOptions o{.bits = 8 * sizeof(T), .format = format, .big_endian = big_endian, .big_tiff = big_tiff};
        TiffBytes file(big_endian, big_tiff);
        for (const auto& page : pages) {
          const std::string bytes = bytes_of(page, big_endian);
          std::vector<std::string> pieces{bytes};
          if (layout == 1) {
            o.rows_per_strip = 4;
            pieces.clear();
            for (std::size_t at = 0; at < bytes.size(); at += 4 * width * sizeof(T))
              pieces.push_back(bytes.substr(at, 4 * width * sizeof(T)));
          } else if (layout > 1) {
            o.tile = {16, 16};
            pieces = tiles({bytes}, width * sizeof(T), 16 * sizeof(T), 16, 1);
          }
          if (layout == 3) {
            o.compression = 8;
            for (std::string& piece : pieces) piece = small_files::deflated(piece);
          }
          file.page(width, height, pieces, o);
        }
        const Volume v = read(file.file());
        EXPECT_EQ(v.grid.dims, (Dims{width, height, 3}));
        ASSERT_TRUE(std::holds_alternative<std::vector<T>>(v.samples));
        EXPECT_EQ(std::get<std::vector<T>>(v.samples), all) << big_endian << big_tiff << layout;
      }
}

TEST_F(Tiff, EverySampleTypeByteOrderAndLayout) {
  const auto by_read = [this](const std::string& bytes) { return read(bytes); };
  every_layout<std::uint8_t>(by_read, 1);
  every_layout<std::uint16_t>(by_read, 1);
  every_layout<std::uint32_t>(by_read, 1);
  every_layout<std::uint64_t>(by_read, 1);
  every_layout<std::int8_t>(by_read, 2);
  every_layout<std::int16_t>(by_read, 2);
  every_layout<std::int32_t>(by_read, 2);
  every_layout<std::int64_t>(by_read, 2);
  every_layout<float>(by_read, 3);
  every_layout<double>(by_read, 3);
  EXPECT_EQ(notes, "");
}

TEST_F(Tiff, SamplesOfOtherSizes) {
  using Bytes = std::vector<std::uint8_t>;
  EXPECT_EQ(samples<std::uint8_t>(tiff(9, 1, {"\xa1\x80"}, {.bits = 1})), (Bytes{255, 0, 255, 0, 0, 0, 0, 255, 255}));
  EXPECT_EQ(samples<std::uint8_t>(tiff(3, 1, {"\x1b"}, {.bits = 2})), (Bytes{0, 85, 170}));
  EXPECT_EQ(samples<std::uint8_t>(tiff(3, 1, {"\x0f\x70"}, {.bits = 4})), (Bytes{0, 255, 119}));
  // Two samples of 12 bits in three bytes, in any byte order of the file; a row begins with a byte of its own.
  for (const bool big : {false, true})
    EXPECT_EQ(samples<std::uint16_t>(tiff(3, 2,
                                          {std::string("\x12\x3f\xff\x00\x10"
                                                       "\xab\xc0\x00\xff\xf0",
                                                       10)},
                                          {.bits = 12, .big_endian = big})),
              (std::vector<std::uint16_t>{0x123, 0xfff, 0x001, 0xabc, 0x000, 0xfff}));
  EXPECT_EQ(samples<std::uint16_t>(tiff(2, 1, {std::string("\xff\xfe\x00\x04", 4)}, {.bits = 15})),
            (std::vector<std::uint16_t>{0x7fff, 1}));
  for (const bool big : {false, true})
    EXPECT_EQ(samples<float>(tiff(3, 1, {bytes_of(std::vector<std::uint16_t>{0x3C00, 0xC000, 0x3800}, big)},
                                  {.bits = 16, .format = 3, .big_endian = big})),
              (std::vector<float>{1, -2, 0.5}));
  refused(tiff(2, 1, {std::string(6, 'a')}, {.bits = 24, .format = 3}), "floating-point samples of 24 bits");
  refused(tiff(2, 1, {std::string(16, 'a')}, {.bits = 64, .format = 6}), "complex");
  refused(tiff(2, 1, {"ab"}, {.bits = 4, .format = 2}), "signed samples of 4 bits");
  // Tiles of samples that share bytes.
  std::vector<std::string> rows(2, std::string(4, '\xf0'));
  EXPECT_EQ(samples<std::uint8_t>([&] {
              TiffBytes file;
              file.page(32, 2, tiles({rows[0] + rows[1]}, 4, 2, 16, 1), {.bits = 1, .tile = {16, 16}});
              return file.file();
            }())
                .size(),
            64u);
}

TEST_F(Tiff, WhereZeroIsWhiteUnsignedValuesAreInverted) {
  EXPECT_EQ(samples<std::uint8_t>(tiff(3, 1, {std::string("\0\1\xff", 3)}, {.photometric = 0})),
            (std::vector<std::uint8_t>{255, 254, 0}));
  EXPECT_NE(notes.find("0 is white"), std::string::npos) << notes;
  EXPECT_EQ(samples<std::uint8_t>(tiff(2, 1, {"\x80"}, {.bits = 1, .photometric = 0})),
            (std::vector<std::uint8_t>{0, 255}));
  EXPECT_EQ(samples<std::uint16_t>(tiff(2, 1, {std::string("\0\0\1\0", 4)}, {.bits = 16, .photometric = 0})),
            (std::vector<std::uint16_t>{65535, 65534}));
  EXPECT_EQ(samples<std::uint32_t>(tiff(1, 1, {std::string("\1\0\0\0", 4)}, {.bits = 32, .photometric = 0})),
            (std::vector<std::uint32_t>{4294967294}));
  EXPECT_EQ(samples<std::int8_t>(tiff(1, 1, {"\1"}, {.format = 2, .photometric = 0})), (std::vector<std::int8_t>{1}));
  EXPECT_EQ(notes, "");
}

TEST_F(Tiff, Palettes) {
  const TiffBytes b;
  std::vector<std::uint32_t> greys, colours;
  for (const std::uint32_t channel : {0u, 1u, 2u})
    for (std::uint32_t i = 0; i < 4; ++i) {
      greys.push_back((3 - i) * 0x5500);
      colours.push_back(i * 0x1100 * (channel + 1));
    }
  EXPECT_EQ(samples<std::uint8_t>(tiff(4, 1, {"\x1b"}, {.bits = 2, .photometric = 3, .tags = {b.shorts(320, greys)}})),
            (std::vector<std::uint8_t>{255, 170, 85, 0}));
  EXPECT_EQ(notes, "");
  EXPECT_EQ(
      samples<std::uint8_t>(tiff(4, 1, {"\x1b"}, {.bits = 2, .photometric = 3, .tags = {b.shorts(320, colours)}})),
      (std::vector<std::uint8_t>{0, 1, 2, 3}));
  EXPECT_NE(notes.find("indices of the colours"), std::string::npos) << notes;
  // Many writers give the colours in 8 bits, not in 16.
  for (std::uint32_t& grey : greys) grey >>= 8;
  EXPECT_EQ(samples<std::uint8_t>(tiff(4, 1, {"\x1b"}, {.bits = 2, .photometric = 3, .tags = {b.shorts(320, greys)}})),
            (std::vector<std::uint8_t>{255, 170, 85, 0}));
}

TEST_F(Tiff, BytesWithTheirLowestBitFirst) {
  const std::vector<std::uint8_t> expected{0x80, 0x40, 0x02, 0x81, 0xc0, 0xc0, 0xc0, 0xc0};
  const std::string planes = "\x01\x02\x40\x81\x03\x03\x03\x03";
  const TiffTag lowest_first = TiffBytes().shorts(266, {2});
  EXPECT_EQ(samples<std::uint8_t>(tiff(2, 2, {planes.substr(0, 4), planes.substr(4)}, {.tags = {lowest_first}})),
            expected);
  EXPECT_EQ(samples<std::uint8_t>(tiff(2, 2, {planes}, {.depth = 2, .tags = {lowest_first}})), expected);
  std::vector<TiffTag> tags = imagej_tags("ImageJ=1.53\nimages=2\nspacing=2\nunit=um", 2000000);
  tags.push_back(lowest_first);
  EXPECT_EQ(samples<std::uint8_t>(tiff(2, 2, {planes}, {.tags = tags})), expected);
  for (const bool big : {false, true}) {  // the bits of each byte, whatever the order of the bytes
    const std::string words = bytes_of(std::vector<std::uint16_t>{0x0180, 0x4002, 0x0001, 0x8000}, big);
    EXPECT_EQ(
        samples<std::uint16_t>(tiff(
            2, 1, {words}, {.bits = 16, .big_endian = big, .depth = 2, .tags = {TiffBytes(big).shorts(266, {2})}})),
        (std::vector<std::uint16_t>{0x8001, 0x0240, 0x0080, 0x0100}))
        << big;
  }
  for (const std::uint32_t together : {1u, 2u}) {
    TiffBytes tiled;
    tiled.page(16, 16, tiles({std::string(256, '\x01'), std::string(256, '\x03')}, 16, 16, 16, together),
               {.tile = {16, 16, together}, .depth = 2, .tags = {lowest_first}});
    const auto got = samples<std::uint8_t>(tiled.file());
    EXPECT_EQ(got.front(), 0x80) << together;
    EXPECT_EQ(got.back(), 0xc0) << together;
  }
}

TEST_F(Tiff, PagesAreTurnedUpright) {
  const std::string stored = "abcdef";  // abc over def
  const std::array<std::string, 8> upright{"abcdef", "cbafed", "fedcba", "defabc",
                                           "adbecf", "daebfc", "fcebda", "cfbead"};
  for (std::uint32_t o = 1; o <= 8; ++o) {
    const Volume v = read(tiff(3, 2, {stored, stored}, {.tags = {TiffBytes().shorts(274, {o})}}));
    EXPECT_EQ(v.grid.dims, o < 5 ? (Dims{3, 2, 2}) : (Dims{2, 3, 2}));
    const auto& got = std::get<std::vector<std::uint8_t>>(v.samples);
    EXPECT_EQ(std::string(got.begin(), got.end()), upright[o - 1] + upright[o - 1]) << o;
  }
  const Volume wide =
      read(tiff(2, 1, {std::string("\1\0\2\0", 4)}, {.bits = 16, .tags = {TiffBytes().shorts(274, {2})}}));
  EXPECT_EQ(std::get<std::vector<std::uint16_t>>(wide.samples), (std::vector<std::uint16_t>{2, 1}));
}

TEST_F(Tiff, VolumesInOnePage) {
  std::vector<std::string> planes;
  std::string all;
  for (int z = 0; z < 5; ++z) {
    std::string& plane = planes.emplace_back();
    for (int i = 0; i < 20 * 18; ++i) plane += static_cast<char>(z * 50 + i % 47);
    all += plane;
  }
  const std::vector<std::uint8_t> expected(all.begin(), all.end());
  for (const std::uint32_t together : {1u, 2u, 4u, 8u}) {
    TiffBytes file;
    file.page(20, 18, tiles(planes, 20, 16, 16, together), {.tile = {16, 16, together}, .depth = 5});
    const Volume v = read(file.file());
    EXPECT_EQ(v.grid.dims, (Dims{20, 18, 5})) << together;
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(v.samples), expected) << together;
    file.page(20, 18, tiles(planes, 20, 16, 16, together), {.tile = {16, 16, together}, .depth = 5});
    refused(file.file(), "2 volumes");
  }
  std::vector<std::string> packed = tiles(planes, 20, 16, 16, 2);
  for (std::string& tile : packed) tile = small_files::deflated(tile);
  TiffBytes deep;
  deep.page(20, 18, packed, {.compression = 8, .tile = {16, 16, 2}, .depth = 5});
  EXPECT_EQ(samples<std::uint8_t>(deep.file()), expected);
  refused(deep.file().substr(0, deep.file().size() - 9), "damaged or incomplete");
  for (const bool compressed : {false, true})  // the strips of all planes, one after the other
    for (const std::uint32_t rows : {5u, 18u}) {
      std::vector<std::string> strips;
      for (const std::string& plane : planes)
        for (std::size_t at = 0; at < plane.size(); at += rows * 20) {
          strips.push_back(plane.substr(at, rows * 20));
          if (compressed) strips.back() = small_files::deflated(strips.back());
        }
      TiffBytes file;
      file.page(20, 18, strips, {.compression = compressed ? 8u : 1u, .rows_per_strip = rows, .depth = 5});
      EXPECT_EQ(samples<std::uint8_t>(file.file()), expected) << compressed << rows;
      refused(file.file().substr(0, file.file().size() - 9), "damaged or incomplete");
    }
  EXPECT_EQ(samples<std::uint8_t>(tiff(20, 18, {all}, {.depth = 5})), expected);
  refused(tiff(20, 18, {small_files::deflated(all)}, {.compression = 8, .depth = 5}), "5 planes in strips");
  refused(tiff(20, 18, {all.substr(1)}, {.depth = 5}), "t.tif");
}

TEST_F(Tiff, AccessoryPagesAreLeftOut) {
  TiffBytes file;
  const TiffTag reduced = file.longs(254, {1}), mask = file.longs(254, {4}), page = file.longs(254, {2});
  file.page(3, 2, {"abcdef"}, {.tags = {page}});
  file.page(1, 1, {"x"}, {.tags = {reduced}});
  file.page(3, 2, {"ghijkl"}, {.tags = {page}});
  file.page(3, 2, {std::string(2, '\xff')}, {.bits = 1, .photometric = 4, .tags = {mask}});
  const Volume v = read(file.file());
  EXPECT_EQ(v.grid.dims, (Dims{3, 2, 2}));
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(v.samples)[6], 'g');
  EXPECT_NE(notes.find("4 pages, of which 2 are reduced copies or masks of others"), std::string::npos) << notes;
  TiffBytes two;
  two.page(1, 1, {"x"}, {});
  two.page(1, 1, {"x"}, {.tags = {two.longs(254, {1})}});
  read(two.file());
  EXPECT_NE(notes.find("2 pages, of which 1 is a reduced copy or mask of another"), std::string::npos) << notes;
  refused(tiff(1, 1, {"x"}, {.tags = {reduced}}), "only reduced copies");
}

TEST_F(Tiff, OtherPagesThanTheFirstAreNamed) {
  const auto with = [](std::uint32_t w, std::uint32_t h, const std::string& bytes, const TiffOptions& o) {
    TiffBytes file;
    file.page(3, 2, {"abcdef"}, {});
    file.page(3, 2, {"abcdef"}, {});
    file.page(w, h, {bytes}, o);
    return file.file();
  };
  refused(with(2, 3, "abcdef", {}), "page 3 has 2 x 3 pixels of uint8, page 1 3 x 2 pixels");
  refused(with(3, 2, "abcdefabcdef", {.bits = 16}), "page 3 has 3 x 2 pixels of uint16");
  refused(with(3, 2, "abcdef", {.format = 2}), "page 3 has 3 x 2 pixels of int8");
  refused(with(3, 2, std::string(2, 'a'), {.bits = 1}), "page 3 has 3 x 2 pixels of uint1");
  refused(with(3, 2, std::string(18, 'a'), {.photometric = 2, .samples = 3}), "uint8, 3 per pixel, page 1");
}

// What colours become: tests/io/formats/tiff.py.
TEST_F(Tiff, ColoursAreNamedWithAWayOut) {
  EXPECT_EQ(read(tiff(3, 2, {std::string(18, 'a')}, {.photometric = 2, .samples = 3})).picture, "an RGB picture");
  const std::string page(18, 'a');
  const std::string rgb =
      refused(tiff(3, 2, {page, page}, {.photometric = 2, .samples = 3}), "an RGB picture of 3 x 2");
  EXPECT_NE(rgb.find("which channel"), std::string::npos) << rgb;
  refused(tiff(3, 2, {std::string(12, 'a')}, {.samples = 2}), "2 values per pixel");
  const std::string ycbcr = refused(tiff(3, 2, {page}, {.photometric = 6, .samples = 3}), "YCbCr");
  EXPECT_NE(ycbcr.find("Image > Type > 8-bit"), std::string::npos) << ycbcr;
  refused(tiff(3, 2, {std::string(24, 'a')}, {.photometric = 5, .samples = 4}), "CMYK");
  refused(tiff(3, 2, {"abcdef"}, {.photometric = 32803}), "raw picture of a colour camera");
}

TEST_F(Tiff, DamagedChainsAreRefused) {
  const auto three = [](bool big_endian, bool big_tiff) {
    TiffBytes file(big_endian, big_tiff);
    std::vector<std::size_t> directories, links;
    for (const char* page : {"abcdef", "ghijkl", "mnopqr"}) {
      file.page(3, 2, {page}, {});
      directories.push_back(file.directory());
      links.push_back(file.link());
    }
    return std::tuple(file, directories, links);
  };
  for (const bool big_endian : {false, true})
    for (const bool big_tiff : {false, true}) {
      const auto [file, directories, links] = three(big_endian, big_tiff);
      EXPECT_EQ(read(file.file()).grid.dims[2], 3);
      const int size = big_tiff ? 8 : 4;
      const auto changed = [&, &f = file](std::size_t at, std::uint64_t to, int bytes) {
        std::string result = f.file();
        return result.replace(at, static_cast<std::size_t>(bytes), f.number(to, bytes));
      };
      // A link that leaves the file, into its last bytes, back, and to itself.
      refused(changed(links[0], 1000000, size), "directory of page 2, at byte 1000000");
      refused(changed(links[1], file.file().size() - 2, size), "directory of page 3");
      refused(changed(links[2], directories[0], size), "page 1 again");
      refused(changed(links[2], directories[2], size), "page 3 again");
      if (big_tiff) refused(changed(links[0], ~std::uint64_t{0}, size), "directory of page 2");
      // A directory without entries, or with more than the file.
      refused(changed(directories[1], 0, big_tiff ? 8 : 2), "directory of page 2");
      refused(changed(directories[1], 60000, big_tiff ? 8 : 2), "directory of page 2");
      // A page whose first tag is gone.
      const std::string other = refused(changed(directories[1] + (big_tiff ? 8 : 2), 60000, 2), "page 2 of");
      EXPECT_NE(other.find("damaged"), std::string::npos) << other;
    }
  refused("II*\0", "does not begin as one");
  refused(std::string("II*\0\0\0\0\0", 8), "no pages");
  refused("no TIFF", "does not begin as one");
  refused("", "empty");
}

std::vector<std::string> small_stacks() {
  std::vector<std::string> files;
  const std::string page = "abcdefghijklmnopqrst";
  for (const bool big : {false, true}) {
    files.push_back(tiff(5, 4, {page, page, page}, {.big_endian = big, .big_tiff = big}));
    const std::string packed = small_files::deflated(page);
    files.push_back(tiff(5, 4, {packed, packed}, {.big_endian = big, .compression = 8}));
    TiffBytes tiled(big);
    for (int i = 0; i < 2; ++i) tiled.page(5, 4, {std::string(256, 'x')}, {.tile = {16, 16}});
    files.push_back(tiled.file());
    files.push_back(
        tiff(5, 4, {page + page + page},
             {.big_endian = big, .tags = imagej_tags("ImageJ=1.53\nimages=3\nspacing=2\nunit=um", 2000000, big)}));
  }
  return files;
}

TEST_F(Tiff, EveryTruncationIsRefusedOrComplete) {
  testing::internal::CaptureStderr();
  for (const std::string& bytes : small_stacks()) {
    const Volume whole = read(bytes);
    for (std::size_t kept = 0; kept < bytes.size(); ++kept)
      if (const auto v = read_or_refuse(bytes.substr(0, kept))) {
        EXPECT_EQ(v->grid.dims, whole.grid.dims) << kept;
        EXPECT_EQ(v->samples, whole.samples) << kept;
      }
    EXPECT_EQ(read(bytes + "rubbish").samples, whole.samples);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Tiff, EveryChangedByteEndsInAVolumeOrASentence) {
  testing::internal::CaptureStderr();
  for (const std::string& bytes : small_stacks())
    for (std::size_t at = 0; at < bytes.size(); ++at)
      for (const int change : {1, 2, 0x80, 0xFF}) {
        std::string other = bytes;
        other[at] = static_cast<char>(other[at] ^ change);
        if (const auto v = read_or_refuse(other)) {
          const auto& dims = v->grid.dims;
          EXPECT_EQ(std::visit([](const auto& s) { return s.size(); }, v->samples),
                    static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
        }
      }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Tiff, ChainsCanBeLeftAndHaveAnEnd) {
  TiffBytes loop;
  loop.page(3, 2, {"abcdef"}, {});
  std::string bytes = loop.file();
  bytes.replace(loop.link(), 4, loop.number(loop.directory(), 4));
  refused(bytes, "page 1 again");
  Context context;
  context.cancel();
  try {
    io::read_volume(folder.write("t.tif", bytes), {}, &context);
    ADD_FAILURE() << "was read";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::cancelled) << e.what();
  }
  constexpr std::uint32_t most = 1000000, size = 18;  // of a directory with one tag
  bytes = "II*" + std::string(1, '\0') + loop.number(8, 4);
  for (std::uint32_t i = 1; i <= most + 1; ++i)
    bytes += loop.number(1, 2) + loop.number(256, 2) + loop.number(3, 2) + loop.number(1, 4) + loop.number(1, 4) +
             loop.number(i <= most ? 8 + i * size : 0, 4);
  refused(bytes, "more than 1000000 pages");
}

// A page may have tiles of another size or lie in another way than the first.
TEST_F(Tiff, TheMemoryOfEveryPageIsChecked) {
  const auto fails = [this](const TiffBytes& file, std::int64_t limit) {
    Context context;
    context.memory_limit = limit;
    try {
      const auto slices = io::open_slices(folder.write("t.tif", file.file()), {}, &context);
      std::vector<std::byte> slice(static_cast<std::size_t>(slices->grid.dims[0] * slices->grid.dims[1]));
      for (int z = 0; z < 2; ++z) slices->next(slice);
      return std::string();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::failed) << e.what();
      return std::string(e.what());
    }
  };
  TiffBytes tiled;
  tiled.page(3, 2, {"abcdef"}, {});
  tiled.page(3, 2, {small_files::deflated(std::string(2048 * 2048, 'x'))}, {.compression = 8, .tile = {2048, 2048}});
  EXPECT_NE(fails(tiled, 1 << 20).find("t.tif' needs about"), std::string::npos);
  EXPECT_EQ(fails(tiled, 1 << 23), "");
  TiffBytes turned;
  turned.page(300, 200, {std::string(60000, 'a')}, {});
  turned.page(300, 200, {std::string(60000, 'b')}, {.tags = {turned.shorts(274, {3})}});
  EXPECT_NE(fails(turned, 150000).find("t.tif' needs about"), std::string::npos);
  EXPECT_EQ(fails(turned, 200000), "");
}

TEST_F(Tiff, PipesAreRefusedAndNotWaitedFor) {
  const auto pipe = folder / "t.tif";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const bool whole : {false, true}) try {
      if (whole)
        io::read_volume(pipe);
      else
        io::open_slices(pipe);
      ADD_FAILURE() << "was read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::input);
      EXPECT_NE(std::string(e.what()).find("t.tif' is not a regular file"), std::string::npos) << e.what();
    }
}

TEST_F(Tiff, ClaimsBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  for (const std::uint32_t compression : {1u, 8u, 5u, 32773u})
    refused(tiff(2000000000, 2000000000, {"abc"}, {.compression = compression}), "");
  refused(tiff(100000, 100000, {"abc"}, {}), "damaged or incomplete");
  TiffBytes file;
  file.page(5, 4, {"abc"}, {.tile = {160000, 160000}});
  refused(file.file(), "t.tif");
}

int calls_of_the_program = 0;

// A program that uses libtiff has handlers of its own.
TEST_F(Tiff, HandlersOfTheProgramStay) {
  const auto handler = [](const char*, const char*, va_list) { ++calls_of_the_program; };
  const TIFFErrorHandler error = TIFFSetErrorHandler(handler), warning = TIFFSetWarningHandler(handler);
  refused(tiff(5, 4, {"too short for zlib"}, {.compression = 8}), "libtiff says");
  EXPECT_EQ(calls_of_the_program, 0);
  EXPECT_EQ(TIFFSetErrorHandler(error), TIFFErrorHandler(handler));
  EXPECT_EQ(TIFFSetWarningHandler(warning), TIFFErrorHandler(handler));
}

// Read in slices, a file gives the shape that it gives read whole.
TEST_F(Tiff, SlicesGiveTheShapeOfTheWhole) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::string> pages(5);
    for (std::string& page : pages)
      for (int i = 0; i < 30; ++i) page += static_cast<char>(random() % 4);
    const auto file = folder.write(fmt::format("{}.tiff", round), tiff(6, 5, pages));
    const auto slices = io::open_slices(file, {.spacing = Vec3(1, 1, 4)});
    ASSERT_TRUE(slices);
    EXPECT_EQ(slices->grid.spacing, Vec3(1, 1, 4));
    for (const ForegroundOptions& options :
         {ForegroundOptions{.threshold = 2, .label = {}}, ForegroundOptions{.threshold = {}, .label = 3}}) {
      const VoxelShape a = foreground(*io::open_slices(file), options), b = foreground(io::read_volume(file), options);
      EXPECT_EQ(a.grid().dims, (Dims{6, 5, 5}));
      ASSERT_EQ(a.voxel_count(), b.voxel_count());
      for (std::int64_t z = 0; z < 5; ++z)
        for (std::int64_t y = 0; y < 5; ++y)
          ASSERT_TRUE(std::ranges::equal(a.row(y, z), b.row(y, z), [](const quench::Run& p, const quench::Run& q) {
            return p.begin == q.begin && p.end == q.end;
          }));
    }
  }
}

// libtiff writes what it compresses; files by hand are above.
TEST_F(Tiff, EveryCompressionOfLibtiff) {
  struct Case {
    std::uint16_t compression, bits;
    int tolerance;
  };
  const std::string path = (folder / "c.tif").string();
  for (const Case& c : {Case{COMPRESSION_LZW, 8, 0},
                        {COMPRESSION_LZW, 16, 0},
                        {COMPRESSION_PACKBITS, 8, 0},
                        {COMPRESSION_ADOBE_DEFLATE, 16, 0},
                        {COMPRESSION_LZMA, 16, 0},
                        {COMPRESSION_ZSTD, 16, 0},
                        {COMPRESSION_LERC, 16, 0},
                        {COMPRESSION_JPEG, 8, 12},
                        {COMPRESSION_CCITTRLE, 1, 0},
                        {COMPRESSION_CCITTFAX3, 1, 0},
                        {COMPRESSION_CCITTFAX4, 1, 0},
                        {COMPRESSION_JBIG, 1, 0}}) {
    if (TIFFIsCODECConfigured(c.compression) == 0) continue;
    TIFF* out = TIFFOpen(path.c_str(), "w");
    ASSERT_TRUE(out);
    std::vector<int> expected;
    constexpr std::uint32_t w = 40, h = 24;
    for (std::uint32_t page = 0; page < 3; ++page) {
      TIFFSetField(out, TIFFTAG_IMAGEWIDTH, w);
      TIFFSetField(out, TIFFTAG_IMAGELENGTH, h);
      TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, c.bits);
      TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, 1);
      TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
      TIFFSetField(out, TIFFTAG_COMPRESSION, c.compression);
      TIFFSetField(out, TIFFTAG_ROWSPERSTRIP, c.compression == COMPRESSION_JBIG ? h : 8);
      std::vector<std::uint8_t> rows(w * h * c.bits / 8u);
      for (std::uint32_t i = 0; i < w * h; ++i) {
        const std::uint32_t v = i % w * 3 + i / w * 4 + page * 10, bit = v / 16 % 2;
        expected.push_back(static_cast<int>(c.bits == 1 ? bit * 255 : v));
        if (c.bits == 1) rows[i / 8] = static_cast<std::uint8_t>(rows[i / 8] | bit << (7 - i % 8));
        if (c.bits == 8) rows[i] = static_cast<std::uint8_t>(v);
        if (c.bits == 16) std::memcpy(&rows[2 * i], &v, 2);  // little-endian machines, as libtiff writes here
      }
      const std::size_t strip = (c.compression == COMPRESSION_JBIG ? h : 8) * w * c.bits / 8u;
      for (std::uint32_t s = 0; s * strip < rows.size(); ++s)
        ASSERT_GT(TIFFWriteEncodedStrip(out, s, &rows[s * strip], static_cast<tmsize_t>(strip)), 0);
      ASSERT_EQ(TIFFWriteDirectory(out), 1);
    }
    TIFFClose(out);
    const Volume v = io::read_volume(path);
    EXPECT_EQ(v.grid.dims, (Dims{w, h, 3}));
    std::visit(
        [&](const auto& samples) {
          ASSERT_EQ(samples.size(), expected.size());
          for (std::size_t i = 0; i < samples.size(); ++i)
            ASSERT_LE(std::abs(static_cast<int>(samples[i]) - expected[i]), c.tolerance)
                << "compression " << c.compression << ", sample " << i;
        },
        v.samples);
    // Cut anywhere it is never another volume; a last tag may be dispensable.
    const auto size = std::filesystem::file_size(path);
    for (std::uintmax_t kept = size - 1; kept > 0; kept -= std::min<std::uintmax_t>(kept, 37)) {
      std::filesystem::resize_file(path, kept);
      try {
        EXPECT_EQ(io::read_volume(path).samples, v.samples) << c.compression << " cut to " << kept << " of " << size;
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::input) << e.what();
      }
    }
  }
}

// The library of JBIG takes memory for the size that its data claim, and ends the program where there is none.
TEST_F(Tiff, SizesInsideJbigAreChecked) {
  if (TIFFIsCODECConfigured(COMPRESSION_JBIG) == 0) GTEST_SKIP() << "libtiff without JBIG";
  const auto file = folder / "j.tif";
  TIFF* out = TIFFOpen(file.c_str(), "w");
  ASSERT_TRUE(out);
  for (const std::uint32_t tag : {TIFFTAG_IMAGEWIDTH, TIFFTAG_IMAGELENGTH, TIFFTAG_ROWSPERSTRIP})
    TIFFSetField(out, tag, 16);
  for (const auto& [tag, value] : {std::pair{TIFFTAG_BITSPERSAMPLE, 1},
                                   {TIFFTAG_SAMPLESPERPIXEL, 1},
                                   {TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK},
                                   {TIFFTAG_COMPRESSION, COMPRESSION_JBIG}})
    TIFFSetField(out, static_cast<std::uint32_t>(tag), value);
  std::string samples(32, '\x5a');
  ASSERT_GT(TIFFWriteEncodedStrip(out, 0, samples.data(), 32), 0);
  TIFFClose(out);
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(read(bytes).grid.dims, (Dims{16, 16, 1}));
  for (const std::size_t at : {2u, 4u, 5u, 8u}) {  // planes, width, height
    std::string other = bytes;
    other[8 + at] = '\x7f';
    refused(other, "of another size");
  }
}

}  // namespace tiff_test
}  // namespace quench
#endif
