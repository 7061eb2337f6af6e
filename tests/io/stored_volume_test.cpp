// SPDX-License-Identifier: Apache-2.0
// NRRD, MetaImage, NIfTI and MRC, slice folders, and the NRRD writer. The files are written by hand.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <Eigen/LU>
#include <cstring>
#include <random>

#include "data.h"
#include "quench/error.h"
#include "quench/io.h"
#include "random_shapes.h"
#include "small_files.h"
#include "temporary_folder.h"
#include "tiff_bytes.h"

namespace quench {
namespace stored_volume_test {

using testing_tiff::tiff;

std::string big_endian(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8), static_cast<char>(v)};
}

std::string deflated(const std::string& data) {
  std::vector<unsigned char> out(compressBound(data.size()));
  uLongf size = out.size();
  compress(out.data(), &size, reinterpret_cast<const unsigned char*>(data.data()), data.size());
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

// 8-bit PNG; colour type 0 is grey, 2 RGB.
std::string png(std::uint32_t width, std::uint32_t height, const std::string& pixels, char colour_type = 0,
                std::uint32_t pixels_per_metre = 0, const std::string& palette = "") {
  const auto chunk = [](const std::string& type, const std::string& data) {
    const std::string body = type + data;
    const auto crc = crc32(0, reinterpret_cast<const unsigned char*>(body.data()), static_cast<unsigned>(body.size()));
    return big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(static_cast<std::uint32_t>(crc));
  };
  std::string rows;
  const std::size_t row = pixels.size() / height;
  for (std::uint32_t y = 0; y < height; ++y) rows += '\0' + pixels.substr(y * row, row);
  std::string file = "\x89PNG\r\n\x1a\n";
  file += chunk("IHDR", big_endian(width) + big_endian(height) + std::string{8, colour_type, 0, 0, 0});
  if (pixels_per_metre)
    file += chunk("pHYs", big_endian(pixels_per_metre) + big_endian(pixels_per_metre) + std::string{1});
  if (!palette.empty()) file += chunk("PLTE", palette);
  return file + chunk("IDAT", deflated(rows)) + chunk("IEND", "");
}

std::string nrrd(const std::string& fields, const std::string& samples) {
  return "NRRD0004\n" + fields + "encoding: raw\nendian: little\n\n" + samples;
}

std::string mha(const std::string& fields, const std::string& samples) {
  return "ObjectType = Image\n" + fields + "ElementDataFile = LOCAL\n" + samples;
}

std::vector<std::uint8_t> bytes_in(const Volume& v) { return std::get<std::vector<std::uint8_t>>(v.samples); }

const io::VolumeReadOptions kSlab{.spacing = {}, .dimension = 3};  // of one slice

std::string refusal(const std::filesystem::path& file, const std::string& part) {
  try {
    io::read_volume(file, kSlab);
  } catch (const Error& e) {
    const std::string what = e.what();
    EXPECT_EQ(e.code(), ErrorCode::input) << what;
    EXPECT_NE(what.find(part), std::string::npos) << what;
    EXPECT_NE(what.find(file.filename().string()), std::string::npos) << what;
    for (const char* noise : {"\n", "0x", ".cxx", ".hxx", "ERROR"})
      EXPECT_EQ(what.find(noise), std::string::npos) << what;
    return what;
  }
  ADD_FAILURE() << file << " was read";
  return {};
}

TEST(StoredVolume, NrrdKeepsReflectedAndRotatedAxes) {
  const TemporaryFolder folder;
  const Volume v = io::read_volume(
      folder.write("r.nrrd", nrrd("type: short\ndimension: 3\nspace dimension: 3\nsizes: 2 1 1\n"
                                  "space directions: (0,2,0) (-3,0,0) (0,0,-5)\nspace origin: (1,2,3)\n",
                                  std::string("\1\0\xff\xff", 4))),
      kSlab);
  EXPECT_EQ(v.grid.spacing, Vec3(2, 3, 5));
  EXPECT_EQ(v.grid.origin, Vec3(1, 2, 3));
  EXPECT_TRUE(v.grid.world(Vec3(1.5, 0.5, 0.5)).isApprox(Vec3(1, 4, 3)));
  EXPECT_LT(v.grid.direction.determinant(), 0);
  EXPECT_EQ(std::get<std::vector<std::int16_t>>(v.samples), (std::vector<std::int16_t>{1, -1}));
}

TEST(StoredVolume, KeepsTheSampleType) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& type, const std::string& samples) {
    return io::read_volume(
        folder.write("t.nrrd", nrrd("type: " + type + "\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1 1\n", samples)),
        kSlab);
  };
  EXPECT_TRUE(std::holds_alternative<std::vector<std::int8_t>>(read("int8", "a").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint16_t>>(read("uint16", "ab").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint32_t>>(read("uint32", "abcd").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::int32_t>>(read("int32", "abcd").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint64_t>>(read("uint64", "abcdefgh").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::int64_t>>(read("int64", "abcdefgh").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<float>>(read("float", "abcd").samples));
  EXPECT_TRUE(std::holds_alternative<std::vector<double>>(read("double", "abcdefgh").samples));
}

TEST(StoredVolume, RefusesWhatIsNoScalarVolume) {
  const TemporaryFolder folder;
  refusal(folder.write("shear.nrrd", nrrd("type: uint8\ndimension: 3\nspace dimension: 3\nsizes: 1 1 1\n"
                                          "space directions: (1,0,0) (0.1,1,0) (0,0,1)\nspace origin: (0,0,0)\n",
                                          "a")),
          "not perpendicular");
  refusal(folder.write("tiny.nrrd", nrrd("type: uint8\ndimension: 3\nspace dimension: 3\nsizes: 1 1 1\n"
                                         "space directions: (1e-300,0,0) (0,1e-300,0) (0,0,1e-300)\nspace origin: "
                                         "(0,0,0)\n",
                                         "a")),
          "along axis 0");
  for (const char* steps : {"(1e300,0,0) (0,1e300,0) (0,0,1e300)", "(1,0,0) (0,-1e200,0) (0,0,1)"})
    refusal(folder.write("huge.nrrd", nrrd("type: uint8\ndimension: 3\nspace dimension: 3\nsizes: 1 1 1\n"
                                           "space directions: " +
                                               std::string(steps) + "\nspace origin: (0,0,0)\n",
                                           "a")),
            "not from 1e-30 to 1e+30");
  EXPECT_EQ(io::read_volume(folder.write("large.nrrd", nrrd("type: uint8\ndimension: 3\nspace dimension: 3\n"
                                                            "sizes: 1 1 1\nspace directions: (1e29,0,0) (0,1e29,0) "
                                                            "(0,0,1e29)\nspace origin: (0,0,0)\n",
                                                            "a")),
                            kSlab)
                .grid.spacing,
            Vec3::Constant(1e29));
  refusal(folder.write("rgb.nrrd", nrrd("type: uint8\ndimension: 4\nspace dimension: 3\nsizes: 3 1 1 1\nkinds: "
                                        "RGB-color domain domain domain\nspace directions: none (1,0,0) (0,1,0) "
                                        "(0,0,1)\nspace origin: (0,0,0)\n",
                                        "abc")),
          "3 values");
  refusal(folder.write("four.mha", mha("NDims = 4\nDimSize = 1 1 1 2\nElementType = MET_UCHAR\n", "ab")),
          "4 dimensions");
  refusal(folder.write("vector.mha", mha("NDims = 3\nDimSize = 1 1 1\nElementNumberOfChannels = 2\nElementType = "
                                         "MET_UCHAR\n",
                                         "ab")),
          "2 values");
  const Volume one = io::read_volume(
      folder.write("one.mha", mha("NDims = 4\nDimSize = 2 1 1 1\nElementType = MET_UCHAR\n", "ab")), kSlab);
  EXPECT_EQ(one.grid.dims, (std::array<std::int64_t, 3>{2, 1, 1}));
  EXPECT_EQ(bytes_in(one), (std::vector<std::uint8_t>{'a', 'b'}));
}

TEST(StoredVolume, PackedMetaImagesAreWholeOrRefused) {
  const TemporaryFolder folder;
  std::string samples(27, '\0');
  samples[13] = 7;
  const std::string packed = deflated(samples);
  for (const bool own : {true, false}) {
    folder.write("block.zraw", packed);
    const auto image = [&](const std::string& size, const std::string& dims = "3 3 3") {
      const std::string fields = "ObjectType = Image\nNDims = 3\nCompressedData = True\n" + size + "DimSize = " + dims +
                                 "\nElementType = MET_UCHAR\nElementDataFile = ";
      return own ? folder.write("p.mha", fields + "LOCAL\n" + packed) : folder.write("p.mhd", fields + "block.zraw\n");
    };
    const auto claims = [](const std::string& size) { return "CompressedDataSize = " + size + "\n"; };
    const std::string size = std::to_string(packed.size());
    EXPECT_EQ(bytes_in(io::read_volume(image(claims(size)))),
              std::vector<std::uint8_t>(samples.begin(), samples.end()));
    for (const char* wrong : {"-15", "-1e300", "1000000000000", "99999999999999999999999", "nan", "x"})
      refusal(image(claims(wrong)), "damaged or");
    // The size is only what the header says of the data behind it.
    for (const std::size_t less : {std::size_t{0}, std::size_t{1}, packed.size() - 1})
      EXPECT_EQ(bytes_in(io::read_volume(image(claims(std::to_string(less))))),
                std::vector<std::uint8_t>(samples.begin(), samples.end()));
    EXPECT_EQ(bytes_in(io::read_volume(image(""))), std::vector<std::uint8_t>(samples.begin(), samples.end()));
    refusal(image(claims(size), "3 3 4"), "end in slice 4 of 4");
  }
}

TEST(StoredVolume, RefusesHostileAndTruncatedFiles) {
  const TemporaryFolder folder;
  testing::internal::CaptureStderr();
  const std::string fields = "type: uint8\ndimension: 3\nspacings: 1 1 1\n";
  refusal(folder.write("huge.nrrd", nrrd(fields + "sizes: 100000 100000 1000\n", "abc")), "");
  refusal(folder.write("over.nrrd", nrrd(fields + "sizes: 4000000000 4000000000 4000000000\n", "abc")), "");
  refusal(folder.write("short.nrrd", nrrd(fields + "sizes: 10 10 10\n", "abc")), "");
  refusal(folder.write("huge.mha", mha("NDims = 3\nDimSize = 100000 100000 1000\nElementType = MET_UCHAR\n", "abc")),
          "too short");
  refusal(folder.write("detached.nhdr", "NRRD0004\n" + fields +
                                            "sizes: 100000 10000 1000\nencoding: raw\ndata file: "
                                            "none.raw\n"),
          "");
  refusal(folder.write("huge.mhd",
                       "ObjectType = Image\nNDims = 3\nDimSize = 100000 100000 1000\nElementType = "
                       "MET_UCHAR\nElementDataFile = huge.mha\n"),
          "where 10000000000000 are needed");
  for (const char* name :
       {"a.nrrd", "a.mha", "a.nii", "a.nii.gz", "a.mrc", "a.map", "a.tif", "a.png", "a.nhdr", "a.mhd"}) {
    refusal(folder.write(name, ""), "");
    refusal(folder.write(name, "not an image of any kind"), "");
    refusal(folder.write(name, std::string(4000, '\x7f')), "");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(StoredVolume, RefusesTruncatedRealFiles) {
  const TemporaryFolder folder;
  REQUIRE_DATA("references/bunny7.nrrd");
  for (const char* name : {"references/bunny7.nrrd", "volumes/torsoLabel.nii.gz", "volumes/emd_5625.map"}) {
    std::ifstream in(data_file(name), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    const std::string file = std::filesystem::path(name).filename().string();
    for (const double part : {0.001, 0.01, 0.1, 0.5, 0.9, 0.99})
      refusal(folder.write(file, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size())))),
              "");
  }
}

// A file of any size may be called a header.
TEST(StoredVolume, LinesOfHeadersEnd) {
  const TemporaryFolder folder;
  const std::string line(std::size_t{3} << 20, 'x');
  for (const char* name : {"a.nrrd", "a.mha"}) refusal(folder.write(name, line), "");
  refusal(folder.write("b.nrrd", "NRRD0004\n# " + line), "longer than a megabyte");
  refusal(folder.write("b.mha", "ObjectType = Image\nComment = " + line), "longer than a megabyte");
  refusal(folder.write("c.nhdr",
                       "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\ndata file: LIST\n" + line),
          "longer than a megabyte");
}

TEST(StoredVolume, DataFilesThatAreNotFiles) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "folder");
  ASSERT_EQ(mkfifo((folder.path() / "fifo").c_str(), 0600), 0);
  const auto nhdr = [&](const std::string& data) {
    return folder.write("a.nhdr",
                        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 2 2\nencoding: raw\ndata file: " + data + "\n");
  };
  for (const char* name : {"folder", "fifo"}) refusal(nhdr(name), "not a regular file");
  refusal(nhdr("none.raw"), "does not exist; put it there");
  refusal(nhdr("my slice%02d.raw 0 1 1"), "no other blanks");
}

TEST(StoredVolume, PipesAreRefusedBeforeTheyAreOpened) {
  const TemporaryFolder folder;
  for (const char* name :
       {"p.nrrd", "p.mha", "p.nii", "p.mrc", "p.npy", "p.vol", "p.sof", "p.png", "p.tif", "p.pgm", "p.bmp"}) {
    const auto file = folder.path() / name;
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
    refusal(file, "not a regular file");
  }
}

// From the beginning of the file, as MetaIO takes it.
TEST(StoredVolume, HeaderSizeOfAMetaImageWithItsOwnSamples) {
  const TemporaryFolder folder;
  const auto image = [](int size) {
    return fmt::format(
        "ObjectType = Image\nNDims = 3\nHeaderSize = {:4}\nDimSize = 1 1 2\nElementType = MET_UCHAR\n"
        "ElementDataFile = LOCAL\n",
        size);
  };
  const int header = static_cast<int>(image(0).size());
  const auto read = [&](int size) { return io::read_volume(folder.write("h.mha", image(size) + "abcd")); };
  EXPECT_EQ(bytes_in(read(0)), (std::vector<std::uint8_t>{'a', 'b'}));
  EXPECT_EQ(bytes_in(read(header)), (std::vector<std::uint8_t>{'a', 'b'}));
  EXPECT_EQ(bytes_in(read(header + 1)), (std::vector<std::uint8_t>{'b', 'c'}));
  EXPECT_EQ(bytes_in(read(-1)), (std::vector<std::uint8_t>{'c', 'd'}));
  refusal(folder.write("h.mha", image(header - 1) + "abcd"), "HeaderSize");
}

// Scaled samples stay different from each other.
TEST(StoredVolume, ScaledSamplesAreToldApart) {
  const TemporaryFolder folder;
  const auto nifti = [&](float slope, float intercept, std::uint8_t unit) {
    std::string bytes(352, '\0');
    const auto put = [&](std::size_t at, const auto& value) {
      bytes.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
    };
    put(0, std::int32_t{348});
    for (std::size_t a = 0; a < 8; ++a) put(40 + 2 * a, static_cast<std::int16_t>(a == 0 ? 3 : a == 3 ? 2 : 1));
    put(70, std::int16_t{4});
    put(72, std::int16_t{16});
    for (std::size_t a = 0; a < 8; ++a) put(76 + 4 * a, 1.0f);
    put(108, 352.0f);
    put(112, slope);
    put(116, intercept);
    put(123, unit);
    bytes.replace(344, 3, "n+1");
    return io::read_volume(folder.write("s.nii", bytes + std::string("\1\0\2\0", 4)));
  };
  EXPECT_EQ(std::get<std::vector<float>>(nifti(0.5f, -1, 2).samples), (std::vector<float>{-0.5f, 0}));
  EXPECT_EQ(std::get<std::vector<double>>(nifti(1, 1e9f, 2).samples), (std::vector<double>{1000000001, 1000000002}));
  EXPECT_EQ(nifti(1, 0, 2).coordinates.units, "mm");
  EXPECT_EQ(nifti(1, 0, 3).coordinates.units, "mm");
  EXPECT_EQ(nifti(1, 0, 3).grid.spacing, Vec3::Constant(0.001));
  EXPECT_EQ(nifti(1, 0, 0).coordinates.units, "");
}

TEST(StoredVolume, DetachedHeaders) {
  const TemporaryFolder folder;
  folder.write("d.raw", "abcd");
  const std::vector<std::uint8_t> expected{'a', 'b', 'c', 'd'};
  EXPECT_EQ(bytes_in(io::read_volume(folder.write("d.nhdr",
                                                  "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 2 2\n"
                                                  "spacings: 1 1 1\nencoding: raw\ndata file: d.raw\n"))),
            expected);
  const Volume meta = io::read_volume(
      folder.write("d.mhd",
                   "ObjectType = Image\nNDims = 3\nDimSize = 4 1 1\nElementSpacing = 1 2 3\nOffset = 4 5 6\n"
                   "ElementType = MET_UCHAR\nElementDataFile = d.raw\n"),
      kSlab);
  EXPECT_EQ(bytes_in(meta), expected);
  EXPECT_EQ(meta.grid.spacing, Vec3(1, 2, 3));
  EXPECT_EQ(meta.grid.origin, Vec3(4, 5, 6));
}

TEST(StoredVolume, SlicesInNaturalOrder) {
  const TemporaryFolder slices;
  for (int i = 0; i < 12; ++i)
    slices.write(fmt::format("s{}.png", i), png(2, 1, std::string(2, static_cast<char>('a' + i)), 0, 2835));
  slices.write("notes.txt", "not a slice");
  const Volume v = io::read_volume(slices.path());
  EXPECT_EQ(v.grid.dims, (std::array<std::int64_t, 3>{2, 1, 12}));
  EXPECT_EQ(v.grid.spacing, Vec3(1, 1, 1));
  for (int i = 0; i < 12; ++i) EXPECT_EQ(bytes_in(v)[static_cast<std::size_t>(2 * i)], 'a' + i);
  slices.write("s5.png", png(1, 2, "xy"));
  EXPECT_THROW(io::read_volume(slices.path()), Error);
  slices.write("s5.png", tiff(2, 1, {"xy", "zz"}));
  EXPECT_THROW(io::read_volume(slices.path()), Error);
  slices.write("s5.png", png(2, 1, "xy"));
  slices.write("s12.tif", tiff(2, 1, {"xy"}));
  EXPECT_THROW(io::read_volume(slices.path()), Error);
  const TemporaryFolder none;
  EXPECT_THROW(io::read_volume(none.path()), Error);
}

TEST(Png, EveryTruncation) {
  testing::internal::CaptureStderr();
  const TemporaryFolder folder;
  const std::string bytes = png(3, 2, "abcdef");
  for (std::size_t length = 0; length < bytes.size(); ++length)
    refusal(folder.write("t.png", bytes.substr(0, length)), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// What colours become: tests/io/formats/png.py.
TEST(Png, UnknownColourTypesAreNamed) {
  const TemporaryFolder folder;
  refusal(folder.write("other.png", png(1, 1, "a", 5)), "colour type 5");
}

// One pixel after the other of every depth, as the specification packs them, and all filters on a gradient.
TEST(Png, EveryDepth) {
  const TemporaryFolder folder;
  const auto read = [&](std::uint32_t width, const std::string& row, int depth) {
    std::string bytes = png(width, 1, row);
    bytes[24] = static_cast<char>(depth);
    const auto crc = crc32(0, reinterpret_cast<const unsigned char*>(bytes.data()) + 12, 17);
    bytes.replace(29, 4, big_endian(static_cast<std::uint32_t>(crc)));
    return io::read_volume(folder.write("d.png", bytes));
  };
  EXPECT_EQ(bytes_in(read(9, "\xa1\x80", 1)), (std::vector<std::uint8_t>{255, 0, 255, 0, 0, 0, 0, 255, 255}));
  EXPECT_EQ(bytes_in(read(3, "\x1b", 2)), (std::vector<std::uint8_t>{0, 85, 170}));
  EXPECT_EQ(bytes_in(read(3, "\x0f\x70", 4)), (std::vector<std::uint8_t>{0, 255, 119}));
  EXPECT_EQ(std::get<std::vector<std::uint16_t>>(read(2, std::string("\1\2\xff\0", 4), 16).samples),
            (std::vector<std::uint16_t>{258, 65280}));
}

TEST(Png, ReadsTheSilhouettes) {
  REQUIRE_DATA("images/mpeg7_beetle-1.png");
  ForegroundOptions white;
  white.threshold = 128;
  EXPECT_EQ(foreground(io::read_volume(data_file("images/mpeg7_elephant-1.png")), white).voxel_count(), 218038);
  EXPECT_EQ(foreground(io::read_volume(data_file("images/mpeg7_beetle-1.png")), white).voxel_count(), 60690);
}

TEST(StoredVolume, WrittenPlanesComeBack) {
  const TemporaryFolder folder;
  Grid grid;
  grid.dims = {7, 5, 1};
  grid.spacing = {0.5, 0.25, 1};
  grid.make_plane();
  grid.origin = {0.1, -7, 0};
  grid.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const VoxelShape shape = testing_shapes::from_predicate(grid, [](int x, int y, int) { return (x * y) % 3 == 1; });
  const auto file = folder.path() / "w.nrrd";
  io::write_volume(file, shape, {.units = "mm", .space = {}, .y_down = true});
  const Volume volume = io::read_volume(file);
  EXPECT_TRUE(volume.grid.is_plane());
  EXPECT_TRUE(volume.coordinates.y_down);
  EXPECT_EQ(volume.coordinates.units, "mm");
  EXPECT_EQ(volume.grid.spacing, Vec3(0.5, 0.25, 0.25));
  EXPECT_EQ(volume.grid.origin, grid.origin);
  EXPECT_EQ(volume.grid.direction, grid.direction);
  std::int64_t inside = 0;
  for (std::size_t i = 0; i < 35; ++i) {
    const bool in = shape.contains(static_cast<std::int64_t>(i % 7), static_cast<std::int64_t>(i / 7), 0);
    EXPECT_EQ(bytes_in(volume)[i] != 0, in);
    inside += in;
  }
  EXPECT_EQ(inside, shape.voxel_count());
  io::write_volume(file, shape, {.units = {}, .space = {}, .y_down = false});
  EXPECT_FALSE(io::read_volume(file).coordinates.y_down);
}

TEST(StoredVolume, YGrowsAsTheFileSaysOrAsItsRowsLie) {
  const TemporaryFolder folder;
  const auto y_down = [&](const std::string& geometry, std::optional<int> dimension = {}) {
    const auto file = folder.write("y.nrrd", nrrd("type: uint8\n" + geometry, "ab"));
    return io::read_volume(file, {.spacing = {}, .dimension = dimension}).coordinates.y_down;
  };
  const std::string plane = "dimension: 2\nsizes: 1 2\nspace dimension: 2\n";
  const std::string up = "space directions: (1,0) (0,1)\n", turned = "space directions: (1,0) (0,-1)\n";
  EXPECT_TRUE(y_down(plane + up));
  EXPECT_FALSE(y_down(plane + turned));
  EXPECT_FALSE(y_down(plane + up + "y_axis:=up\n"));
  EXPECT_TRUE(y_down(plane + turned + "y_axis:=down\n"));
  EXPECT_TRUE(y_down(plane + up + "y_axis:=somewhere\n"));
  // y of LPS grows to the back, which is drawn below.
  const std::string slice = "dimension: 3\nsizes: 1 2 1\n", flipped = "space directions: (1,0,0) (0,-1,0) (0,0,1)\n";
  EXPECT_TRUE(y_down("space: LPS\n" + slice + flipped, 2));
  EXPECT_FALSE(y_down("space dimension: 3\n" + slice + flipped, 2));
  EXPECT_FALSE(y_down("space dimension: 3\n" + slice + flipped, 3));
}

TEST(StoredVolume, WrittenShapesComeBack) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VoxelShape random = testing_shapes::random_shape(seed, 12, true);
    Grid grid = random.grid();
    grid.origin = {0.1, -7, 1e6};
    if (seed % 2) grid.direction << 0, -1, 0, 1, 0, 0, 0, 0, -1;
    const VoxelShape shape =
        testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return random.contains(x, y, z); });
    const auto file = folder.path() / "w.nrrd";
    io::write_volume(file, shape);
    const Volume volume = io::read_volume(file);
    EXPECT_EQ(volume.grid.spacing, grid.spacing);
    EXPECT_EQ(volume.grid.origin, grid.origin);
    EXPECT_EQ(volume.grid.direction, grid.direction);
    const VoxelShape back = foreground(volume, {});
    ASSERT_EQ(back.grid().dims, grid.dims);
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        ASSERT_TRUE(std::ranges::equal(back.row(y, z), shape.row(y, z))) << "seed " << seed;
  }
}

TEST(ReadVolume, RefusesOtherNamesAndBadSpacing) {
  const TemporaryFolder folder;
  const auto code = [](const std::filesystem::path& file, const io::VolumeReadOptions& options = {}) {
    try {
      io::read_volume(file, options);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode{0};
  };
  EXPECT_EQ(code(folder.write("a.xyz", "")), ErrorCode::usage);
  EXPECT_EQ(code(folder / "missing.nrrd"), ErrorCode::failed);
  io::VolumeReadOptions options;
  options.spacing = Vec3(1, 0, 1);
  EXPECT_EQ(code(folder.write("a.npy", ""), options), ErrorCode::usage);
}

/// The error of reading a file; none: field "read".
Error error_of(const std::filesystem::path& file, const io::VolumeReadOptions& options) {
  try {
    io::read_volume(file, options);
  } catch (const Error& e) {
    return e;
  }
  return {ErrorCode::failed, "", "read"};
}

TEST(ReadVolume, SpacingHasTheDimensionOfTheFile) {
  const TemporaryFolder folder;
  const auto image = folder.write("i.png", png(2, 1, "ab"));
  const auto volume = folder.write("v.nrrd", nrrd("type: uint8\ndimension: 3\nsizes: 1 1 2\n", "ab"));
  const auto spacing = [](const std::filesystem::path& file, const Vec3& given) {
    return io::read_volume(file, {.spacing = given}).grid.spacing;
  };
  EXPECT_EQ(spacing(image, Vec3(2, 3, 0)), Vec3(2, 3, 2));
  EXPECT_EQ(spacing(image, Vec3(2, 2, 2)), Vec3(2, 2, 2));  // one number
  EXPECT_EQ(spacing(volume, Vec3(2, 3, 4)), Vec3(2, 3, 4));
  for (const auto& [file, given, words] : {std::tuple(image, Vec3(2, 3, 4), "has three numbers"),
                                           {volume, Vec3(2, 3, 0), "has two numbers"},
                                           {image, Vec3(2, -3, 0), "positive"},
                                           {volume, Vec3(2, 3, -1), "positive"}}) {
    const Error error = error_of(file, {.spacing = given});
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_EQ(error.field(), "spacing");
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(ReadVolume, OptionsThatCannotBeNameTheirField) {
  const TemporaryFolder folder;
  const auto image = folder.write("i.png", png(2, 1, "ab"));
  EXPECT_EQ(error_of(image, {.spacing = {}, .dimension = 4}).field(), "dimension");
  EXPECT_EQ(error_of(image, {.spacing = {}, .dimension = {}, .channel = "hue"}).field(), "channel");
  EXPECT_EQ(error_of(image, {.spacing = {}, .dimension = {}, .channel = "alpha"}).field(), "channel");
  EXPECT_EQ(error_of(image, {.spacing = {}, .dimension = {}, .channel = "red"}).field(), "read");
}

/// The notes of reading a file.
std::string notes_of(const std::filesystem::path& file, const io::VolumeReadOptions& options = {}) {
  std::string notes;
  Context context;
  context.note = [&](const std::string& sentence) { notes += sentence + "\n"; };
  io::read_volume(file, options, &context);
  return notes;
}

TEST(Pictures, ANoteSaysWhatIsNotTheLuminanceOfAnOpaquePicture) {
  const TemporaryFolder folder;
  const auto stencil = folder.write("s.png", png(2, 1, std::string("\7\7\7\0\7\7\7\xff", 8), 6));
  const auto shaded = folder.write("t.png", png(2, 1, std::string("\1\7\7\x40\7\7\7\xff", 8), 6));
  const auto opaque = folder.write("o.png", png(2, 1, std::string("\1\7\7\xff\7\7\7\xff", 8), 6));
  EXPECT_NE(notes_of(stencil).find("of one colour on transparent ground: the values are its alpha"), std::string::npos);
  EXPECT_NE(notes_of(shaded).find("with transparent pixels: the values are its luminance"), std::string::npos);
  EXPECT_EQ(notes_of(opaque), "");
  for (const auto& file : {stencil, shaded, opaque})
    EXPECT_EQ(notes_of(file, {.spacing = {}, .dimension = {}, .channel = "luminance"}), "");
}

TEST(Pictures, AlphaThatIsNowhereWrittenIsNone) {
  const TemporaryFolder folder;
  const auto picture = [](const std::string& pixels) {  // of 32 bits with masks for blue, green, red and alpha
    std::string bytes = small_files::bmp(2, 1, 32, 6, 4, pixels);
    return bytes.replace(54, 16, std::string("\0\0\xff\0\0\xff\0\0\xff\0\0\0\0\0\0\xff", 16));
  };
  const auto opaque = folder.write("o.bmp", picture(std::string("\7\7\7\0\x50\x50\x50\0", 8)));
  const Volume volume = io::read_volume(opaque);
  EXPECT_EQ(bytes_in(volume), (std::vector<std::uint8_t>{7, 0x50}));
  EXPECT_EQ(volume.picture, "an RGB picture");
  EXPECT_EQ(notes_of(opaque), "");
  const Volume seen = io::read_volume(folder.write("a.bmp", picture(std::string("\7\7\7\0\x50\x50\x50\xff", 8))));
  EXPECT_EQ(bytes_in(seen), (std::vector<std::uint8_t>{0, 255}));
}

TEST(Pictures, RealOnes) {
  REQUIRE_DATA("images/horse.png");
  const Volume horse = io::read_volume(data_file("images/horse.png"));
  EXPECT_EQ(horse.grid.dims, (std::array<std::int64_t, 3>{400, 328, 1}));
  EXPECT_NE(horse.picture, "");
  const Volume contour = io::read_volume(data_file("images/contourS.pgm"));
  EXPECT_EQ(contour.grid.dims, (std::array<std::int64_t, 3>{185, 85, 1}));
  EXPECT_EQ(contour.picture, "a grey picture");
  EXPECT_TRUE(contour.grid.is_plane() && contour.coordinates.y_down);
}

}  // namespace stored_volume_test
}  // namespace quench
