// SPDX-License-Identifier: Apache-2.0
// Surfaces and medial axes in files: dialects of each format, what is refused, real meshes, radii.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "data.h"
#include "poly_samples.h"

namespace quench {
namespace io_surface_test {

using testing_files::code_of;
using testing_files::expect_same;
using testing_files::Folder;
using testing_files::read_bytes;
using testing_files::refusal;
using testing_files::values_of;
using testing_files::write_bytes;

template <class T>
void append_bytes(std::string& bytes, T value, bool big = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof value);
  if (big) std::reverse(raw, raw + sizeof value);
  bytes.append(raw, sizeof value);
}

TEST(Files, EmptyOnesAreSaidToBe) {
  const auto expect_empty = [](const std::string& name, const std::string& sentence) {
    EXPECT_TRUE(sentence.ends_with(name + "' is empty")) << sentence;
  };
  for (const std::string name : {"a.ply", "a.obj", "a.off", "a.stl", "a.vtp", "a.ma"})
    expect_empty(name, refusal(name, ""));
  const Folder folder;
  for (const std::string name : {"a.npy", "a.vol", "a.sof", "a.png", "a.nrrd", "a.nii.gz", "a.mha", "a.mrc", "a.tif"}) {
    write_bytes(folder / name, "");
    std::string sentence;
    EXPECT_EQ(code_of([&] { io::read_volume(folder / name); }, &sentence), ErrorCode::input) << name;
    expect_empty(name, sentence);
  }
}

// --- PLY -----------------------------------------------------------------------------------------------------------

TEST(Ply, TextWithEveryPart) {
  const Record data = read_bytes("a.ply",
                                 "ply\r\nformat ascii 1.0\r\ncomment x y\r\nobj_info z\r\nelement vertex 4\r\n"
                                 "property uchar red\r\nproperty float x\r\nproperty double y\r\nproperty int z\r\n"
                                 "property list uchar float extra\r\nproperty double radius\r\n"
                                 "element material 2\r\nproperty int a\r\nproperty list int int b\r\n"
                                 "element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n"
                                 "property uint level\r\nproperty int mark\r\n"
                                 "element face 2\r\nproperty short mark\r\nproperty list uchar uint vertex_index\r\n"
                                 "property float lambda\r\nelement nothing 4000000000\r\nend_header\r\n"
                                 "9 0.1 2 3 2 0.5 0.5 1.5\r\n8 1 0 0 0 2.5\r\n7 0 1 0 0 3.5\r\n6 0 0 1 0 4.5\r\n"
                                 "1 0\r\n2 2 5 6\r\n3 2 4000000000 -7\r\n5 3 0 1 2 0.25\r\n6 4 0 1 2 3 0.5\r\n");
  ASSERT_EQ(data.points.size(), 4u);
  EXPECT_EQ(data.points[0], Vec3(0.1, 2, 3));
  EXPECT_EQ(values_of<std::uint8_t>(data.point_data, "red"), (std::vector<std::uint8_t>{9, 8, 7, 6}));
  EXPECT_EQ(values_of<double>(data.point_data, "radius"), (std::vector<double>{1.5, 2.5, 3.5, 4.5}));
  EXPECT_EQ(data.point_data.size(), 2u);
  EXPECT_EQ(data.lines, (std::vector<std::array<std::uint32_t, 2>>{{3, 2}}));
  EXPECT_EQ(data.poly_corners, (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 3}));
  EXPECT_EQ(values_of<std::int64_t>(data.cell_data, "level"), (std::vector<std::int64_t>{4000000000, 0, 0}));
  EXPECT_EQ(values_of<std::int32_t>(data.cell_data, "mark"), (std::vector<std::int32_t>{-7, 5, 6}));
  EXPECT_EQ(values_of<float>(data.cell_data, "lambda"), (std::vector<float>{0, 0.25f, 0.5f}));
}

TEST(Ply, BinaryOfBothOrdersAndAllTypes) {
  for (bool big : {false, true}) {
    std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                        "_endian 1.0\nelement vertex 3\nproperty char x\nproperty uchar y\nproperty short z\n"
                        "property ushort a\nproperty int b\nproperty uint c\nproperty float d\nproperty double e\n"
                        "element face 1\nproperty list ushort short vertex_indices\nend_header\n";
    for (int v = 0; v < 3; ++v) {
      append_bytes<std::int8_t>(bytes, static_cast<std::int8_t>(-100 - v), big);
      append_bytes<std::uint8_t>(bytes, static_cast<std::uint8_t>(200 + v), big);
      append_bytes<std::int16_t>(bytes, static_cast<std::int16_t>(-30000 - v), big);
      append_bytes<std::uint16_t>(bytes, 60000, big);
      append_bytes<std::int32_t>(bytes, -2000000000, big);
      append_bytes<std::uint32_t>(bytes, 4000000000u, big);
      append_bytes<float>(bytes, 0.1f, big);
      append_bytes<double>(bytes, 0.1, big);
    }
    append_bytes<std::uint16_t>(bytes, 3, big);
    for (std::int16_t c : {2, 1, 0}) append_bytes(bytes, c, big);
    const Record data = read_bytes("a.ply", bytes);
    EXPECT_EQ(data.points[2], Vec3(-102, 202, -30002)) << big;
    EXPECT_EQ(values_of<std::int32_t>(data.point_data, "a")[0], 60000);
    EXPECT_EQ(values_of<std::int32_t>(data.point_data, "b")[0], -2000000000);
    EXPECT_EQ(values_of<std::int64_t>(data.point_data, "c")[0], 4000000000);
    EXPECT_EQ(values_of<float>(data.point_data, "d")[0], 0.1f);
    EXPECT_EQ(values_of<double>(data.point_data, "e")[0], 0.1);
    EXPECT_EQ(data.poly_corners, (std::vector<std::uint32_t>{2, 1, 0}));
    bytes[bytes.size() - 2] = bytes[bytes.size() - 1] = 3;
    EXPECT_NE(refusal("a.ply", bytes).find("byte"), std::string::npos);
  }
}

TEST(Ply, Refusals) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
  const std::string rest = "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(read_bytes("a.ply", head + rest + points + "3 0 1 2\n").poly_count(), 1u);
  for (const char* face : {"0", "3 0 1 3", "3 0 -1 2", "3 0 1.5 2", "3 0 1", "-1", "300 0 1 2", "x"})
    EXPECT_NE(refusal("a.ply", head + rest + points + face).find("line 13"), std::string::npos) << face;
  EXPECT_NE(refusal("a.ply", head + rest + "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n").find("line 10"), std::string::npos);
  refusal("a.ply", head + rest + "0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2\n");
  refusal("a.ply", head + "end_header\n0 0\n0 0\n0 0\n");
  refusal("a.ply", head + "property float x\nend_header\n");
  refusal("a.ply", head + "property half z\nend_header\n");
  refusal("a.ply", "ply\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
  refusal("a.ply", "ply\nformat ascii 1.0\nend_header\n");
  refusal("a.ply", "");
}

TEST(Ply, HugeCountsAllocateNothing) {
  for (const char* format : {"ascii", "binary_little_endian"})
    for (const char* element : {"vertex", "face", "edge", "other"})
      for (const char* count : {"4294967296", "9223372036854775807", "4000000000"})
        refusal("a.ply", std::string("ply\nformat ") + format + " 1.0\nelement " + element + " " + count +
                             "\nproperty float x\nproperty float y\nproperty float z\nproperty int vertex1\n"
                             "property int vertex2\nproperty list int int vertex_indices\nend_header\n1 2 3\n");
}

// --- VTP ---------------------------------------------------------------------------------------------------------

TEST(Vtp, PiecesAreJoinedWithTheirCellData) {
  const auto array = [](const char* type, const char* name, const char* text) {
    return std::string("<DataArray type='") + type + "' Name='" + name + "' format='ascii'>" + text + "</DataArray>";
  };
  const auto piece = [&](const char* verts, const char* rows) {
    return "<Piece NumberOfPoints='2' NumberOfVerts='1' NumberOfLines='1'><PointData>" + array("Int8", "p", verts) +
           array("Bit", "bits", "1 0") + "</PointData><CellData>" + array("Float32", "c", rows) +
           "</CellData><Points><DataArray type='Float32' NumberOfComponents='3'>0 0 0 1 1 "
           "1</DataArray></Points><Verts>" +
           array("Int32", "connectivity", "1") + array("UInt8", "offsets", "1") + "</Verts><Lines>" +
           array("UInt64", "connectivity", "0 1") + array("Int64", "offsets", "2") + "</Lines></Piece>";
  };
  const Record data = read_bytes("a.vtp", "<VTKFile type='PolyData'><PolyData>" + piece("1 -2", "1 2") +
                                              piece("3 4", "3 nan") + "</PolyData></VTKFile>");
  EXPECT_EQ(data.points.size(), 4u);
  EXPECT_EQ(data.verts, (std::vector<std::uint32_t>{1, 3}));
  EXPECT_EQ(data.lines, (std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {2, 3}}));
  EXPECT_EQ(values_of<std::int32_t>(data.point_data, "p"), (std::vector<std::int32_t>{1, -2, 3, 4}));
  const std::vector<float> rows = values_of<float>(data.cell_data, "c");
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[1], 3.0f);
  EXPECT_EQ(rows[2], 2.0f);
  EXPECT_TRUE(std::isnan(rows[3]));
}

TEST(Vtp, Refusals) {
  refusal("a.vtp", "");
  refusal("a.vtp", "<a/>");
  const std::string body = "<PolyData><Piece NumberOfPoints='0'/></PolyData></VTKFile>";
  EXPECT_TRUE(read_bytes("a.vtp", "<VTKFile type='PolyData'>" + body).points.empty());
  for (const char* attributes :
       {"type='UnstructuredGrid'", "type='PolyData' byte_order='BigEndian'",
        "type='PolyData' compressor='vtkLZ4DataCompressor'", "type='PolyData' header_type='UInt16'"})
    refusal("a.vtp", std::string("<VTKFile ") + attributes + ">" + body);
  refusal("a.vtp", "<VTKFile type='PolyData'></VTKFile>");
  refusal("a.vtp", "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='4000000000'/></PolyData></VTKFile>");
}

// --- OBJ, OFF, STL, MA ---------------------------------------------------------------------------------------------

TEST(Obj, Dialects) {
  const Record data = read_bytes("a.obj",
                                 "\xEF\xBB\xBF# comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\n"
                                 "v 0 1 0 0.5 0.5 0.5\r\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3/1 # triangle\n"
                                 "f -3 -2 -1\nv\t+1e0  .5 -2.\nf 1 2 \\\n 4\\\r\n 3\nl 1/1 2 3 4\nf 1 2\nf 4\np 2 3\n"
                                 "f 5 6 7\nv 5 5 5\nv 6 6 6\nv 7 7 7\nusemtl y\ns off\n");
  EXPECT_EQ(data.points.size(), 7u);
  EXPECT_EQ(data.points[3], Vec3(1, 0.5, -2));
  EXPECT_EQ(data.poly_offsets, (std::vector<std::uint32_t>{0, 3, 6, 10, 13}));
  EXPECT_EQ(data.poly_corners, (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 0, 1, 3, 2, 4, 5, 6}));
  EXPECT_EQ(data.lines, (std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {1, 2}, {2, 3}, {0, 1}}));
  EXPECT_EQ(data.verts, (std::vector<std::uint32_t>{3, 1, 2}));
  EXPECT_EQ(read_bytes("a.obj", "v 0 0 0\rv 1 1 1\rl 1 2\r").lines.size(), 1u);
}

TEST(Obj, Refusals) {
  for (const char* line : {"f 0 1 2", "f 1 2 4", "f -4 1 2", "f a b c", "f", "l 1", "v 1 2", "v 1 2 nan", "v 1 2 x",
                           "v 1 2 1e400", "f 1 2 99999999999999999999", "f / / /"})
    EXPECT_NE(refusal("a.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\n") + line).find("line 4"), std::string::npos)
        << line;
  refusal("a.obj", "");
  refusal("a.obj", "<html>");
}

TEST(Off, Dialects) {
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  for (const char* head : {"OFF\n4 2 0\n", "OFF 4 2 0\n", "# c\nOFF # c\n\n# c\n4 2 5\n", "4 2 0\n", "OFF\n4 2\n"}) {
    const Record data = read_bytes("a.off", head + body + "3 0 1 2\n\n# c\n4 0 1 3 2 255 0 0 # colour\n");
    EXPECT_EQ(data.points.size(), 4u) << head;
    EXPECT_EQ(data.poly_corners, (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 3, 2})) << head;
  }
  for (const char* head : {"COFF", "NOFF", "CNOFF", "STOFF", "STCNOFF"})
    EXPECT_EQ(read_bytes("a.off", std::string(head) + "\n3 1 0\n0 0 0 1 2 3 4\n1 0 0 1 2 3 4\n0 1 0 1 2 3 4\n3 0 1 2\n")
                  .points[2],
              Vec3(0, 1, 0));
  const Record mixed = read_bytes("a.off", "OFF 3 3 0\n0 0 0\n1 0 0\n0 1 0\n1 2\n3 0 1 2\n2 0 1");
  EXPECT_EQ(mixed.verts, (std::vector<std::uint32_t>{2}));
  EXPECT_EQ(mixed.lines.size(), 1u);
}

TEST(Off, Refusals) {
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  for (const char* face : {"3 0 1 3", "3 0 1 -1", "3 0 1", "0", "-3 0 1 2", "", "99999999999 0"})
    refusal("a.off", head + face);
  for (const char* text : {"", "OFF", "OFF BINARY\n", "4OFF 1 1 1", "PLY", "OFF 4000000000 4000000000 0\n0 0 0\n",
                           "OFF -1 0 0", "OFF 1 0 0\n0 0\n", "OFF 1 0 0\n0 0 inf\n"})
    refusal("a.off", text);
}

std::string binary_stl(const std::string& head, const std::vector<float>& numbers) {
  std::string bytes = head;
  bytes.resize(80, ' ');
  append_bytes(bytes, static_cast<std::uint32_t>(numbers.size() / 9));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i % 9 == 0) bytes.append(12, '\0');
    append_bytes(bytes, numbers[i]);
    if (i % 9 == 8) bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Stl, BinaryAndTextWeldToTheSame) {
  const Record binary = read_bytes("a.stl", binary_stl("solid but binary", {0, 0, 0, 1, 0, 0, 0, 1, 0,  //
                                                                            1, 0, 0, 1, 1, 0, -0.0f, 1, 0}));
  const Record text = read_bytes(
      "a.STL",
      "SOLID a name\n facet normal 0 0 nan\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   VERTEX 0 1 0\n"
      "  endloop\n endfacet\nfacet\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
      "a\n");
  EXPECT_EQ(binary.points.size(), 4u);
  EXPECT_EQ(binary.poly_corners, (std::vector<std::uint32_t>{0, 1, 2, 1, 3, 2}));
  expect_same(binary, text);
}

TEST(Stl, TextKeepsDoublePrecision) {
  EXPECT_EQ(read_bytes("a.stl",
                       "solid\nfacet normal 0 0 0\nouter loop\nvertex 0.1 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                       "endfacet\nendsolid\nsolid\nendsolid\n")
                .points[0][0],
            0.1);
}

TEST(Stl, Refusals) {
  const std::string good = binary_stl("head", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  refusal("a.stl", good.substr(0, good.size() - 1));
  refusal("a.stl", "");
  refusal("a.stl", "solid\n");
  refusal("a.stl", "solid\nvertex 0 0 0\nendsolid\n");
  refusal("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n");
  refusal("a.stl", binary_stl("head", {0, 0, 0, 1, 0, 0, 0, std::nanf(""), 0}));
}

TEST(Ma, Dialects) {
  const Record data = read_bytes("a.ma",
                                 "# c\n4 2 2\nv 0 0 0 1\nv 1 0 0 2 0\nv 0 1 0 3\nv 0 0 1 4\ne 0 1\ne 3 2\n"
                                 "f 0 1 2\nf 0 1 2 3\n");
  EXPECT_EQ(data.lines.size(), 2u);
  EXPECT_EQ(data.poly_corners.size(), 7u);
  EXPECT_EQ(values_of<double>(data.point_data, "radius"), (std::vector<double>{1, 2, 3, 4}));
  refusal("a.ma", "2 1 0\nv 0 0 0 1\nv 1 0 0 1\n");
  refusal("a.ma", "2 1 0\nv 0 0 0 1\nv 1 0 0 1\ne 0 2\n");
  refusal("a.ma", "2 0 0\nv 0 0 0 1\nv 1 0 0\n");
  refusal("a.ma", "99999999999999 0 0\n");
}

TEST(Radii, Refusals) {
  const Folder folder;
  for (const char* text : {"", "2\n0 0 0 1\n", "1\n0 0 0\n", "1\n0 0 0 -1\n", "x\n", "-1\n", "1\n0 0 0 nan\n"}) {
    write_bytes(folder / "a.r", text);
    EXPECT_EQ(code_of([&] { io::read_radii(folder / "a.r", {Vec3(0, 0, 0)}); }), ErrorCode::input) << text;
  }
  EXPECT_EQ(code_of([&] { io::read_radii(folder / "none.r", {}); }), ErrorCode::failed);
}

TEST(Radii, RepeatedPlacesAndBruteForceAgree) {
  const Folder folder;
  std::string text = "3000\n";
  std::vector<Vec3> places, queries;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p(i % 10, i / 10 % 10, (i * 7) % 5);
    places.push_back(p);
    text += std::to_string(i % 10) + " " + std::to_string(i / 10 % 10) + " " + std::to_string((i * 7) % 5) + " " +
            std::to_string(i % 10 + 100 * (i / 10 % 10) + 10000 * ((i * 7) % 5)) + "\n";
    queries.push_back(p + Vec3(0.004, -0.003, 0.005));
  }
  write_bytes(folder / "a.r", text);
  const std::vector<double> radii = io::read_radii(folder / "a.r", queries);
  for (std::size_t i = 0; i < places.size(); ++i)
    ASSERT_EQ(radii[i], places[i][0] + 100 * places[i][1] + 10000 * places[i][2]);
}

// --- other formats, real data --------------------------------------------------------------------------------------

TEST(Assimp, ReadsWeldedMeshes) {
  const std::string text =
      "xof 0303txt 0032\nMesh m {\n 6;\n 0;0;0;,\n 1;0;0;,\n 0;1;0;,\n 1;0;0;,\n 1;1;0;,\n 0;1;0;;\n 2;\n 3;0,1,2;,\n"
      " 3;3,4,5;;\n}\n";
  const Folder folder;
  write_bytes(folder / "a.x", text);
  Record data;
  try {
    data = io::read_record(folder / "a.x");
  } catch (const Error& error) {
    if (std::string(error.what()).find("without Assimp") == std::string::npos) FAIL() << error.what();
    GTEST_SKIP() << error.what();
  }
  EXPECT_EQ(data.points.size(), 4u);
  EXPECT_EQ(data.poly_count(), 2u);
  refusal("b.dae", "<html>no mesh</html>");
}

struct RealMesh {
  const char* name;
  std::size_t points, faces;
};

class RealMeshes : public testing::TestWithParam<RealMesh> {};

TEST_P(RealMeshes, HaveTheirCounts) {
  REQUIRE_DATA(GetParam().name);
  const Record data = io::read_record(data_file(GetParam().name));
  data.validate();
  EXPECT_EQ(data.points.size(), GetParam().points);
  EXPECT_EQ(data.poly_count(), GetParam().faces);
}

INSTANTIATE_TEST_SUITE_P(
    All, RealMeshes,
    testing::Values(RealMesh{"meshes/bunny_closed.off", 37706, 75408}, RealMesh{"meshes/armadillo.off", 36725, 73446},
                    RealMesh{"meshes/fertility.off", 17827, 35666}, RealMesh{"meshes/elk.off", 24013, 48026},
                    RealMesh{"meshes/neptune.off", 14814, 29636}, RealMesh{"meshes/octopus.off", 7130, 14256},
                    RealMesh{"meshes/vessel.off", 49698, 99392}, RealMesh{"meshes/fandisk.off", 6475, 12946},
                    RealMesh{"meshes/block.off", 2132, 4272}, RealMesh{"meshes/casting.off", 5096, 10224},
                    RealMesh{"meshes/abc_00000802.obj", 10740, 21492}, RealMesh{"meshes/kitten.obj", 9447, 18894},
                    RealMesh{"meshes/lucy.ply", 49987, 99970}, RealMesh{"meshes/bunny_holes.ply", 35947, 69451},
                    RealMesh{"meshes/truck.obj", 2956, 4770}, RealMesh{"meshes/neuron_1734350788.ply", 17369, 35106},
                    RealMesh{"references/bunny7_lambda0.025.ply", 14353, 27318}));

TEST(RealRadii, PublishedRadiiMatchThePublishedVertices) {
  REQUIRE_DATA("references/bunny7_lambda0.025.ply");
  REQUIRE_DATA("references/bunny7_burn.tsv");
  const Record data = io::read_record(data_file("references/bunny7_lambda0.025.ply"));
  const std::vector<double> radii = io::read_radii(data_file("references/bunny7_lambda0.025.r"), data.points);
  ASSERT_EQ(radii.size(), 14353u);
  // The burn table has the radii in the order of the mesh.
  std::ifstream table(data_file("references/bunny7_burn.tsv"));
  std::string header;
  std::getline(table, header);
  std::size_t vertex = 0, rows = 0;
  double radius = 0, slow = 0, fast = 0;
  for (; table >> vertex >> radius >> slow >> fast; ++rows)
    ASSERT_NEAR(radii[vertex], radius, 1e-4 * radius) << "vertex " << vertex;
  EXPECT_EQ(rows, radii.size());
}

}  // namespace io_surface_test
}  // namespace quench
