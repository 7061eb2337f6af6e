// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tiff_bytes.h"

/// A tiny valid file of every format Quench reads in its own process: what the tests damage and the fuzz targets begin
/// with. Each shows another part of its reader.
namespace quench::small_files {

struct SmallFile {
  std::string name;    ///< with the extension of its format
  std::string format;  ///< ply, obj, off, stl, vtp, ma, radii, npy, vol, sof, png, pnm, bmp, jpeg, nrrd, mha, nii, mrc,
                       ///< tiff, out, swc or rsml
  std::string bytes;
};

inline std::string deflated(const std::string& data, int window = 15) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&z, static_cast<uLong>(data.size())) + 100, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  z.avail_in = static_cast<uInt>(data.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// The bytes of a number, least significant first unless `big`.
inline std::string number(std::uint64_t value, int size, bool big = false) {
  std::string bytes;
  for (int b = 0; b < size; ++b) bytes += static_cast<char>(value >> 8 * (big ? size - 1 - b : b) & 0xFF);
  return bytes;
}

inline constexpr std::uint32_t one_as_float = 0x3F800000;

inline std::string binary_ply(bool big) {
  std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement vertex 3\nproperty char x\nproperty float y\nproperty short z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float uv\n"
                      "end_header\n";
  for (const int v : {0, 1, 2})
    bytes += number(v == 1, 1) + number(v == 2 ? one_as_float : 0, 4, big) + number(0xFFFE, 2, big);
  bytes += number(3, 1);
  for (const int v : {0, 1, 2}) bytes += number(static_cast<std::uint64_t>(v), 4, big);
  return bytes + number(1, 1) + number(one_as_float, 4, big);
}

inline std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes += number(1, 4) + std::string(12, '\0');
  for (const int one_at : {-1, 0, 1})
    for (int a = 0; a < 3; ++a) bytes += number(a == one_at ? one_as_float : 0, 4);
  return bytes + number(0, 2);
}

/// VTP as text or as inline base64, uncompressed.
inline std::string inline_vtp(bool base64) {
  const char* format = base64 ? "binary" : "ascii";
  const auto array = [&](const char* type, const char* name, int components, const char* text, const char* code) {
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"" + format + "\">" + (base64 ? code : text) + "</DataArray>\n";
  };
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData>"
         "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points>" +
         array("Float32", "Points", 3, "0 0 0 1 0 0 0 1 0",
               "JAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAA==") +
         "</Points><PointData>" + array("UInt8", "flag", 1, "1 2 3", "AwAAAAECAw==") + "</PointData><Polys>" +
         array("Int32", "connectivity", 1, "0 1 2", "DAAAAAAAAAABAAAAAgAAAA==") +
         array("Int32", "offsets", 1, "3", "BAAAAAMAAAA=") + "</Polys></Piece></PolyData></VTKFile>\n";
}

/// Two pieces with every kind of cell; the first one's data appended, in compressed blocks.
inline std::string appended_vtp() {
  std::string appended;
  const auto array = [&](const char* type, const char* name, int components, const std::string& bytes) {
    const std::string stored = deflated(bytes);
    const std::string node = std::string("<DataArray type=\"") + type + "\" Name=\"" + name +
                             "\" NumberOfComponents=\"" + std::to_string(components) +
                             "\" format=\"appended\" offset=\"" + std::to_string(appended.size()) + "\"/>";
    appended += number(1, 8) + number(bytes.size(), 8) + number(0, 8) + number(stored.size(), 8) + stored;
    return node;
  };
  const auto integers = [](std::initializer_list<int> values) {
    std::string bytes;
    for (const int v : values) bytes += number(static_cast<std::uint64_t>(v), 4);
    return bytes;
  };
  std::string points;
  for (int p = 0; p < 4; ++p)
    for (int a = 0; a < 3; ++a) points += number(p >> a & 1 ? one_as_float : 0, 4);
  const auto cells = [&](const char* kind, std::initializer_list<int> corners, std::initializer_list<int> ends) {
    return std::string("<") + kind + ">" + array("Int32", "connectivity", 1, integers(corners)) +
           array("Int32", "offsets", 1, integers(ends)) + "</" + kind + ">";
  };
  std::string text =
      "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
      "compressor=\"vtkZLibDataCompressor\"><PolyData><FieldData><DataArray type=\"String\" Name=\"units\" "
      "format=\"ascii\">109 109 0</DataArray></FieldData><Piece NumberOfPoints=\"4\" NumberOfVerts=\"1\" "
      "NumberOfLines=\"1\" NumberOfPolys=\"1\" NumberOfStrips=\"1\"><Points>" +
      array("Float32", "Points", 3, points) + "</Points><CellData>" + array("Int8", "kind", 1, "\1\2\3\4") +
      "</CellData>" + cells("Verts", {3}, {1}) + cells("Lines", {0, 1, 2}, {3}) + cells("Polys", {0, 1, 2}, {3}) +
      cells("Strips", {0, 1, 2, 3}, {4}) + "</Piece><Piece NumberOfPoints=\"1\"><Points>";
  text += "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">5 5 5</DataArray></Points></Piece>";
  return text + "</PolyData><AppendedData encoding=\"raw\">_" + appended + "</AppendedData></VTKFile>\n";
}

inline std::string npy(const std::string& type, bool fortran_order, const std::string& shape,
                       const std::string& samples, int version = 1) {
  const std::string header = "{'descr': '" + type + "', 'fortran_order': " + (fortran_order ? "True" : "False") +
                             ", 'shape': (" + shape + "), }\n";
  return "\x93NUMPY" + number(static_cast<std::uint64_t>(version), 1) + number(0, 1) +
         number(header.size(), version == 1 ? 2 : 4) + header + samples;
}

inline std::string vol(int version, int sample_size, const std::string& samples) {
  return "X: 2\nY: 2\nZ: 2\nVoxel-Size: " + std::to_string(sample_size) +
         "\nVoxel-Endian: 0\nVersion: " + std::to_string(version) + "\n.\n" +
         (version == 3 ? deflated(samples) : samples);
}

/// Two cells per axis, or four of which most are one empty cell.
inline std::string sof(int n) {
  const std::string leaves = std::string("\0\2\xF0\2\xF0\2\xF0\2\xF0\2\x0F\2\x0F\2\x0F\2\x0F", 17);
  if (n == 2) return number(2, 4) + leaves;
  std::string bytes = number(4, 4) + std::string(1, '\0') + leaves;
  for (int child = 1; child < 8; ++child) bytes += std::string("\1", 1) + static_cast<char>(child & 1);
  return bytes;
}

inline std::string png_block(const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return number(data.size(), 4, true) + checked + number(sum, 4, true);
}

/// Makes the checksums of all blocks right that are there as a whole.
inline void mend_checksums(std::string& png) {
  for (std::size_t at = 8; png.size() - std::min(at, png.size()) >= 12;) {
    std::size_t length = 0;
    for (std::size_t b = 0; b < 4; ++b) length = length << 8 | static_cast<unsigned char>(png[at + b]);
    if (length > png.size() - at - 12) return;
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(&png[at + 4]), static_cast<uInt>(length + 4));
    png.replace(at + 8 + length, 4, number(sum, 4, true));
    at += 12 + length;
  }
}

inline std::string png(int width, int height, int depth, int colour, bool interlaced, const std::string& rows) {
  std::string bytes = "\x89PNG\r\n\x1a\n" + png_block("IHDR", number(static_cast<std::uint64_t>(width), 4, true) +
                                                                  number(static_cast<std::uint64_t>(height), 4, true) +
                                                                  static_cast<char>(depth) + static_cast<char>(colour) +
                                                                  std::string(2, '\0') + (interlaced ? '\1' : '\0'));
  if (colour == 3) bytes += png_block("PLTE", std::string("\0\0\0\x80\x80\x80", 6)) + png_block("tRNS", "\x40");
  return bytes + png_block("IDAT", deflated(rows)) + png_block("IEND", "");
}

/// A bitmap with a header of 40 bytes and a palette of `colours` greys.
inline std::string bmp(int width, int height, int bits, int compression, int colours, const std::string& rows) {
  const auto whole = [](int value) { return number(static_cast<std::uint32_t>(value), 4); };
  const int begin = 54 + 4 * colours;
  std::string bytes = "BM" + whole(begin + static_cast<int>(rows.size())) + whole(0) + whole(begin) + whole(40) +
                      whole(width) + whole(height) + number(1, 2) + number(static_cast<std::uint64_t>(bits), 2) +
                      whole(compression) + whole(0) + whole(0) + whole(0) + whole(colours) + whole(0);
  for (int c = 0; c < colours; ++c) bytes += std::string(3, static_cast<char>(c * 40)) + '\0';
  return bytes + rows;
}

/// Two blocks of one grey each, baseline or progressive.
inline std::string jpeg(bool progressive) {
  const auto segment = [](char marker, const std::string& data) {
    return std::string("\xff") + marker + number(data.size() + 2, 2, true) + data;
  };
  std::string digits(12, '\0');
  for (int i = 0; i < 12; ++i) digits[static_cast<std::size_t>(i)] = static_cast<char>(i);
  // A difference of 3, and of -3: category 2 (0010), its bits, and the end of the block (0).
  const std::string scan = segment('\xda', std::string("\1\1\0\0", 4) + (progressive ? '\0' : '\x3f') + '\0');
  return "\xff\xd8" + segment('\xdb', '\0' + std::string(64, '\1')) +
         segment(progressive ? '\xc2' : '\xc0', std::string("\x08\0\x08\0\x10\1\1\x11\0", 9)) +
         segment('\xc4', '\0' + std::string("\0\0\0\x0c", 4) + std::string(12, '\0') + digits) +
         segment('\xc4', '\x10' + std::string("\1", 1) + std::string(16, '\0')) + scan +
         (progressive ? "\x2c\x8f" : "\x2c\x43") + "\xff\xd9";
}

inline std::string nrrd(const std::string& encoding, const std::string& endian, const std::string& samples) {
  return "NRRD0004\ntype: unsigned short\ndimension: 3\nsizes: 2 2 2\nendian: " + endian + "\nencoding: " + encoding +
         "\n\n" + (encoding == "gzip" ? deflated(samples, 15 + 16) : samples);
}

/// 3 x 3 x 3 voxels, the middle one 1.
inline std::string middle() {
  std::string bytes(27, '\0');
  bytes[13] = '\1';
  return bytes;
}

inline std::string meta(const std::string& more, const std::string& data_file) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + more +
         "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\nDimSize = 3 3 3\n"
         "ElementType = MET_UCHAR\nElementDataFile = " +
         data_file + "\n";
}

inline std::string placed_nrrd(const std::string& encoding, const std::string& more = "") {
  return "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 3 3\nspace directions: (1,0,0) "
         "(0,1,0) (0,0,1)\nkinds: domain domain domain\nendian: little\nencoding: " +
         encoding + "\nspace origin: (0,0,0)\n" + more + "\n";
}

inline std::string nifti() {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, const std::string& part) { bytes.replace(at, part.size(), part); };
  const std::string one = number(one_as_float, 4);
  put(0, number(348, 4));
  for (std::size_t a = 0; a < 8; ++a) put(40 + 2 * a, number(a > 0 && a < 4 ? 3 : a ? 1 : 3, 2));
  put(70, number(2, 2));  // uint8
  put(72, number(8, 2));
  for (std::size_t a = 0; a < 8; ++a) put(76 + 4 * a, one);
  put(108, number(0x43B00000, 4));  // 352
  put(112, one);
  put(123, "\2");  // mm
  put(254, number(1, 2));
  for (std::size_t a = 0; a < 3; ++a) put(280 + 20 * a, one);
  put(344, std::string("n+1\0", 4));
  return bytes + middle();
}

inline std::string mrc() {
  std::string bytes(1024, '\0');
  const auto put = [&](std::size_t word, std::uint64_t value) { bytes.replace(4 * word, 4, number(value, 4)); };
  for (const std::size_t word : {0, 1, 2, 7, 8, 9}) put(word, 3);
  for (const std::size_t word : {10, 11, 12}) put(word, 0x40400000);  // 3
  for (const std::size_t word : {13, 14, 15}) put(word, 0x42B40000);  // 90 degrees
  for (const std::size_t word : {16, 17, 18}) put(word, word - 15);
  bytes.replace(208, 4, "MAP ");
  bytes.replace(212, 4, std::string("DA\0\0", 4));
  return bytes + middle();
}

/// Two pages, a page in tiles, a volume in tiles, a palette, and descriptions of other programs.
inline std::vector<SmallFile> tiff_files() {
  using namespace testing_tiff;
  const std::string page = "\1\2\3\4\5\6\7\1", halves(16, '\x3c'), name = "tiff";
  const TiffBytes little, big(true);
  TiffBytes tiled(false, true), volume(true), mixed;
  tiled.page(3, 2, {std::string(256, 'x')}, {.tile = {16, 16}, .tags = {tiled.shorts(274, {6})}});
  volume.page(2, 2, {deflated(std::string(512, 'y'))}, {.compression = 8, .tile = {16, 16, 2}, .depth = 2});
  mixed.page(4, 2, {page}, {});
  mixed.page(1, 1, {page}, {.tags = {mixed.longs(254, {1})}});
  mixed.page(4, 2, {deflated(page)}, {.photometric = 0, .compression = 8});
  const std::string ome =
      "<OME><Image><Pixels SizeZ=\"2\" SizeC=\"1\" PhysicalSizeX=\"1\" PhysicalSizeY=\"2\" PhysicalSizeZ=\"3\" "
      "PhysicalSizeZUnit=\"nm\"/></Image></OME>";
  return {
      {"pages.tif", name, tiff(4, 2, {page, page})},
      {"big.tif", name, tiff(2, 2, {page}, {.bits = 16, .format = 2, .big_endian = true, .big_tiff = true})},
      {"half.tif", name, tiff(4, 2, {halves}, {.bits = 16, .format = 3})},
      {"packed.tif", name, tiff(5, 2, {page + page}, {.bits = 12, .photometric = 0, .big_endian = true})},
      {"palette.tif", name,
       tiff(4, 2, {page}, {.bits = 1, .photometric = 3, .tags = {little.shorts(320, {0, 9, 0, 9, 0, 9})}})},
      {"imagej.tif", name,
       tiff(4, 1, {page}, {.tags = imagej_tags("ImageJ=1\nimages=2\nunit=um\nspacing=2\n", 2000000)})},
      {"ome.tif", name, tiff(4, 2, {page, page}, {.tags = {TiffBytes::text(270, ome)}})},
      {"shaped.tif", name,
       tiff(4, 2, {page}, {.tags = {TiffBytes::text(270, "{\"shape\": [1, 2, 4], \"axes\": \"ZYX\"}")}})},
      {"tiled.tif", name, tiled.file()},
      {"volume.tif", name, volume.file()},
      {"mixed.tif", name, mixed.file()},
  };
}

inline std::vector<SmallFile> all() {
  const std::string bytes8 = "\1\2\3\4\5\6\7\1", bytes16 = bytes8 + bytes8;
  std::vector<SmallFile> files{
      {"little.ply", "ply", binary_ply(false)},
      {"big.ply", "ply", binary_ply(true)},
      {"text.ply", "ply",
       "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
       "property double radius\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nproperty uchar m\n"
       "element face 1\nproperty list uchar int vertex_index\nproperty float m\nend_header\n"
       "0 0 0 1\n1 0 0 1\n0 1 0 2\n0 1 7 .5\n0 1 7\n3 0 1 2 0.5\n"},
      {"hand.obj", "obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//2 -1\nl 1 2 \\\n 3\np 1\n"},
      {"hand.off", "off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n2 0 1\n"},
      {"normals.off", "off", "CNOFF 3\n1 0\n0 0 0 0 0 1 1 1 1 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"},
      {"text.stl", "stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "endsolid a\n"},
      {"binary.stl", "stl", binary_stl()},
      {"hand.ma", "ma", "4 1 1\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 .5\nv 3 3 3 1\ne 0 1\nf 0 1 2\n"},
      {"text.vtp", "vtp", inline_vtp(false)},
      {"base64.vtp", "vtp", inline_vtp(true)},
      {"appended.vtp", "vtp", appended_vtp()},
      {"hand.r", "radii", "3\n0 0 0 1\n1 0 0 2.5\n0 1 0 1e-3\n"},
      {"bytes.npy", "npy", npy("|u1", false, "2, 2, 2", bytes8)},
      {"big.npy", "npy", npy(">i2", true, "2, 2, 2", bytes16)},
      {"half.npy", "npy", npy("<f2", false, "1, 2, 2, 2", bytes16, 2)},
      {"plain.vol", "vol", vol(2, 1, bytes8)},
      {"deflated.vol", "vol", vol(3, 2, bytes16)},
      {"two.sof", "sof", sof(2)},
      {"four.sof", "sof", sof(4)},
      {"grey.png", "png", png(3, 2, 8, 0, false, std::string("\1\1\2\3\2\1\1\1", 8))},
      {"wide.png", "png", png(1, 3, 16, 0, false, std::string("\0\1\2\3\1\2\4\1\1", 9))},
      {"palette.png", "png", png(9, 2, 1, 3, false, std::string("\0\xA5\x80\0\x5A\0", 6))},
      {"woven.png", "png", png(2, 2, 4, 0, true, std::string("\0\x10\0\x20\0\x34", 6))},
      {"rgb.png", "png", png(1, 2, 16, 2, false, std::string("\1\1\2\3\4\5\6\4\1\2\3\4\5\6", 14))},
      {"rgba.png", "png", png(2, 1, 8, 6, false, std::string("\3\7\7\7\0\7\7\7\xff", 9))},
      {"alpha.png", "png", png(1, 1, 8, 4, true, std::string("\0\5\x80", 3))},
      {"bits.pbm", "pnm", std::string("P4 9 2\n\xA5\x80\x5A\0", 11)},
      {"plain.pbm", "pnm", "P1\n# c\n3 2\n101\n0 1 0\n"},
      {"plain.pgm", "pnm", "P2 2 2 300 0 1 299 300\n"},
      {"raw.pgm", "pnm", "P5 3 2 255\n" + bytes8.substr(0, 6)},
      {"wide.pgm", "pnm", std::string("P5 2 1 1000\n\0\1\2\3", 16)},
      {"raw.ppm", "pnm", "P6 2 1 9\n\1\2\3\4\5\6"},
      {"plain.ppm", "pnm", "P3 1 1 7 1 2 3"},
      {"rgb.bmp", "bmp", bmp(2, 2, 24, 0, 0, bytes16)},
      {"four.bmp", "bmp", bmp(3, -2, 4, 0, 8, bytes8)},
      {"runs.bmp", "bmp", bmp(4, 2, 8, 1, 3, std::string("\1\1\0\3\1\2\1\0\0\0\0\2\1\0\1\2\0\1", 18))},
      {"nibbles.bmp", "bmp", bmp(4, 1, 4, 2, 3, std::string("\2\x12\0\1", 4))},
      {"baseline.jpg", "jpeg", jpeg(false)},
      {"progressive.jpg", "jpeg", jpeg(true)},
      {"raw.nrrd", "nrrd", nrrd("raw", "little", bytes16)},
      {"gzip.nrrd", "nrrd", nrrd("gzip", "big", bytes16)},
      {"placed.nrrd", "nrrd", placed_nrrd("raw") + middle()},
      {"text.nrrd", "nrrd", nrrd("text", "little", "1 2 3 4 5 6 7 8\n")},
      {"hex.nrrd", "nrrd", nrrd("hex", "little", "0001000200030004000500060007ABcd\n")},
      {"plain.mha", "mha", meta("", "LOCAL") + middle()},
      {"packed.mha", "mha",
       meta("CompressedData = True\nCompressedDataSize = " + std::to_string(deflated(middle()).size()) + "\n",
            "LOCAL") +
           deflated(middle())},
      {"plain.nii", "nii", nifti()},
      {"packed.nii.gz", "nii", deflated(nifti(), 15 + 16)},
      {"plain.mrc", "mrc", mrc()},
      {"voxels.out", "out", "0.5\n3\n1 0 2\n0 0 0\n1 1 2\n"},
      {"hand.swc", "swc",
       "# c\n1 1 0 0 0 2 -1\n2 1 0 2 0 2 1\n4 3 3 0 0 .5 3\n3 3 2 0 0 1 2\n5 3 2 1e0 0 1 3 7\n9 2 8 0 0 1 0\n10 2 9 0 "
       "0 1 9\n"},
      {"hand.rsml", "rsml",
       "<rsml xmlns:po='p'><metadata><unit>mm</unit><resolution>2</resolution></metadata><scene><plant id='1'><root "
       "id='1'>"
       "<geometry><polyline><point x='0' y='0' z='0'/><point x='4' y='0'/></polyline></geometry><properties><a "
       "value='1'/>"
       "</properties><functions><function domain='polyline' name='diameter'><sample value='2'/><sample value='1'/>"
       "</function><function domain='uniform' name='age'><sample value='2'/></function></functions><root po:k='b'>"
       "<geometry><polyline><Point x='1' y='1'/><Point x='1' y='3'/></polyline></geometry><functions><functions "
       "domain='length' name='radius'><sample position='0'>1</sample><sample position='1'>2</sample></functions>"
       "</functions></root></root></plant></scene></rsml>"},
  };
  for (SmallFile& file : tiff_files()) files.push_back(std::move(file));
  return files;
}

}  // namespace quench::small_files
