// SPDX-License-Identifier: Apache-2.0
// Damaged files: whatever is done to a small valid file, reading gives valid data or an Error.
#include <gtest/gtest.h>

#include <random>

#include "io/formats.h"
#include "poly_samples.h"

namespace quench {
namespace {

using testing_files::bytes_of;
using testing_files::Folder;
using testing_files::mixed_sample;

struct Format {
  const char* name;
  PolyData (*read)(const io::FileText&);
  std::string valid;
};

PolyData small_sample() {
  PolyData data = mixed_sample();
  data.point_data.resize(2);
  data.cell_data.resize(1);
  data.field_data.resize(2);
  return data;
}

std::string written(const std::string& name) {
  const Folder folder;
  io::write_poly_data(folder / name, small_sample());
  return bytes_of(folder / name);
}

std::string with_reversed_numbers() {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty short z\n"
      "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float uv\nend_header\n";
  bytes.append({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  bytes.append({3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1, 0, 0, 0, 0});
  return bytes;
}

/// VTP as text and as inline base64, uncompressed.
std::string vtp(bool base64) {
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

std::string stl(bool binary) {
  if (!binary)
    return "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
           "endsolid a\n";
  std::string bytes(80, ' ');
  bytes.append({2, 0, 0, 0});
  for (int i = 0; i < 100; ++i) bytes += static_cast<char>(i % 50 < 48 ? i % 60 : 0);
  return bytes;
}

std::vector<Format> formats() {
  return {
      {"written.ply", io::read_ply, written("a.ply")},
      {"big.ply", io::read_ply, with_reversed_numbers()},
      {"text.ply", io::read_ply,
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty uchar m\nelement face 1\n"
       "property list uchar int vertex_index\nproperty float m\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 1 7\n3 0 1 2 0.5\n"},
      {"written.obj", io::read_obj, written("a.obj")},
      {"hand.obj", io::read_obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//2 -1\nl 1 2 \\\n 3\np 1\n"},
      {"hand.off", io::read_off, "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n2 0 1\n"},
      {"text.stl", io::read_stl, stl(false)},
      {"binary.stl", io::read_stl, stl(true)},
      {"hand.ma", io::read_ma, "3 1 1\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 .5\ne 0 1\nf 0 1 2\n"},
      {"written.vtp", io::read_vtp, written("a.vtp")},
      {"text.vtp", io::read_vtp, vtp(false)},
      {"base64.vtp", io::read_vtp, vtp(true)},
  };
}

/// Valid data or an input error; anything else fails the test.
bool is_handled(const Format& format, std::string bytes, const std::string& how) {
  try {
    format.read({format.name, std::move(bytes)}).validate();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::input) {
      ADD_FAILURE() << format.name << ", " << how << ": " << error.what();
      return false;
    }
  } catch (const std::exception& error) {
    ADD_FAILURE() << format.name << ", " << how << ": " << error.what();
    return false;
  }
  return true;
}

TEST(Hostile, ValidFilesAreRead) {
  for (const Format& format : formats()) {
    SCOPED_TRACE(format.name);
    const PolyData data = format.read({format.name, format.valid});
    data.validate();
    EXPECT_GT(data.poly_count(), 0u);
  }
}

TEST(Hostile, EveryTruncation) {
  for (const Format& format : formats())
    for (std::size_t size = 0; size < format.valid.size(); ++size)
      if (!is_handled(format, format.valid.substr(0, size), "cut to " + std::to_string(size))) break;
}

TEST(Hostile, EveryByteChanged) {
  for (const Format& format : formats())
    for (std::size_t at = 0; at < format.valid.size(); ++at) {
      const char old = format.valid[at];
      for (int value : {0, 255, old ^ 1, old ^ 128, old + 1, int{' '}, int{'\n'}, int{'9'}, int{'-'}, int{'"'}}) {
        std::string bytes = format.valid;
        bytes[at] = static_cast<char>(value);
        if (!is_handled(format, std::move(bytes), "byte " + std::to_string(at) + " = " + std::to_string(value))) break;
      }
    }
}

TEST(Hostile, PiecesRemovedRepeatedAndSwapped) {
  std::mt19937 random(7);
  for (const Format& format : formats())
    for (int round = 0; round < 1000; ++round) {
      std::string bytes = format.valid;
      for (int edit = 1 + static_cast<int>(random() % 3); edit > 0 && !bytes.empty(); --edit) {
        const std::size_t from = random() % bytes.size(), size = random() % 20, to = random() % bytes.size();
        const std::string part = bytes.substr(from, size);
        switch (random() % 3) {
          case 0:
            bytes.erase(from, size);
            break;
          case 1:
            bytes.insert(to, part);
            break;
          default:
            bytes.replace(to, size, part);
        }
      }
      if (!is_handled(format, std::move(bytes), "edit " + std::to_string(round))) break;
    }
}

}  // namespace
}  // namespace quench
