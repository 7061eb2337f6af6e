// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "quench/axis.h"
#include "quench/error.h"
#include "quench/io.h"
#include "temporary_folder.h"

// One rule in all formats for what they call a face: with one corner it is a point, with two a line.

namespace quench {
namespace io_faces_test {

using Corners = std::vector<std::uint32_t>;

class Faces : public testing::Test {
 protected:
  TemporaryFolder folder;

  Record read(const std::string& name, const std::string& text) { return io::read_record(folder.write(name, text)); }
  /// Three points; a point, a line and a triangle, in whatever order the file has them.
  void expect_one_of_each(const Record& data) {
    EXPECT_EQ(data.points.size(), 3u);
    EXPECT_EQ(data.verts, (Corners{2}));
    EXPECT_EQ(data.lines, (std::vector<std::array<std::uint32_t, 2>>{{0, 1}}));
    EXPECT_EQ(data.poly_corners, (Corners{0, 1, 2}));
    EXPECT_NO_THROW(data.validate());
    EXPECT_EQ(to_triangle_mesh(data).triangles.size(), 1u) << "points and lines are no part of a surface";
  }
  void expect_refused(const std::string& name, const std::string& text) {
    try {
      read(name, text);
      ADD_FAILURE() << name << ": a face without corners was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::input) << error.what();
      EXPECT_NE(std::string(error.what()).find("corner"), std::string::npos) << error.what();
    }
  }
};

TEST_F(Faces, Obj) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_one_of_each(read("a.obj", points + "f 3\nf 1 2 3\nf 1 2\n"));
  expect_refused("b.obj", points + "f\n");
}

TEST_F(Faces, Off) {
  const std::string points = "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n";
  expect_one_of_each(read("a.off", points + "1 2\n3 0 1 2\n2 0 1\n"));
  expect_refused("b.off", points + "0\n3 0 1 2\n2 0 1\n");
}

const std::string ply_head =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n";
const std::string ply_points = "0 0 0\n1 0 0\n0 1 0\n";

TEST_F(Faces, Ply) {
  const std::string head =
      ply_head + "element face 3\nproperty list uchar int vertex_indices\nend_header\n" + ply_points;
  expect_one_of_each(read("a.ply", head + "1 2\n3 0 1 2\n2 0 1\n"));
  expect_refused("b.ply", head + "0\n3 0 1 2\n2 0 1\n");
}

// Values of cells go with their cells, whatever the order of the file is: points, lines, then polygons.
TEST_F(Faces, PlyWithValuesPerCell) {
  const std::string faces =
      "element face 3\nproperty list uchar int vertex_indices\nproperty int a\nproperty double b\n";
  const std::string edges =
      "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty int a\nproperty int c\n";
  const std::string face_rows = "1 2 10 0.5\n3 0 1 2 11 1.5\n2 0 1 12 2.5\n", edge_row = "1 2 20 7\n";
  const std::string faces_first = ply_head + faces + edges + "end_header\n" + ply_points + face_rows + edge_row;
  const std::string edges_first = ply_head + edges + faces + "end_header\n" + ply_points + edge_row + face_rows;
  for (const bool first : {false, true}) {
    const Record data = read("c.ply", first ? faces_first : edges_first);
    ASSERT_NO_THROW(data.validate());
    ASSERT_EQ(data.lines.size(), 2u);
    const std::size_t own = data.lines[0] == std::array<std::uint32_t, 2>{1, 2} ? 0 : 1;  // the edge of the file
    std::vector<double> a{10, 12, 12, 11}, b{0.5, 2.5, 2.5, 1.5}, c{0, 0, 0, 0};
    a[1 + own] = 20;
    b[1 + own] = 0;
    c[1 + own] = 7;
    EXPECT_EQ(find_array(data.cell_data, "a")->numbers(), a);
    EXPECT_EQ(find_array(data.cell_data, "b")->numbers(), b);
    EXPECT_EQ(find_array(data.cell_data, "c")->numbers(), c);
  }
}

std::string vtp(const std::string& polys, const std::string& offsets, int count) {
  return "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"3\" "
         "NumberOfPolys=\"" +
         std::to_string(count) +
         "\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0"
         "</DataArray></Points><CellData><DataArray type=\"Int32\" Name=\"a\" format=\"ascii\">10 11 12</DataArray>"
         "</CellData><Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" +
         polys + "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" + offsets +
         "</DataArray></Polys></Piece></PolyData></VTKFile>\n";
}

TEST_F(Faces, Vtp) {
  const Record data = read("a.vtp", vtp("2 0 1 2 0 1", "1 4 6", 3));
  expect_one_of_each(data);
  EXPECT_EQ(find_array(data.cell_data, "a")->numbers(), (std::vector<double>{10, 12, 11}));
  expect_refused("b.vtp", vtp("2 0 1 2 0 1", "1 4 4", 3));
}

TEST_F(Faces, Ma) {
  const std::string points = "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\n";
  const Record data = read("a.ma", "3 0 3\n" + points + "f 2\nf 0 1 2\nf 0 1\n");
  expect_one_of_each(data);
  EXPECT_EQ(medial_axis_of(data).complex.face_count(), 1u);
  expect_refused("b.ma", "3 0 3\n" + points + "f\nf 0 1 2\nf 0 1\n");
}

#ifdef QUENCH_TESTS_HAVE_ASSIMP
TEST_F(Faces, ThroughAssimp) {
  const auto mesh = [](int mode, int first, int count) {
    return "{\"primitives\":[{\"mode\":" + std::to_string(mode) +
           ",\"attributes\":{\"POSITION\":" + std::to_string(first) + "}}]}" + (count ? "," : "");
  };
  const auto points = [](int offset, int count) {
    return "{\"bufferView\":0,\"byteOffset\":" + std::to_string(offset) +
           ",\"componentType\":5126,\"type\":\"VEC3\",\"count\":" + std::to_string(count) +
           ",\"min\":[0,0,0],\"max\":[1,1,0]}";
  };
  const Record data =
      read("a.gltf",
           "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
           "\"nodes\":[{\"mesh\":0},{\"mesh\":1},{\"mesh\":2}],\"meshes\":[" +
               mesh(4, 0, 1) + mesh(1, 1, 1) + mesh(0, 2, 0) + "],\"accessors\":[" + points(0, 3) + "," + points(0, 2) +
               "," + points(24, 1) +
               "],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
               "\"uri\":"
               "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}");
  expect_one_of_each(data);
}
#endif

}  // namespace io_faces_test
}  // namespace quench
