// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "data.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "quench/voxelize.h"

// Real meshes, read here by the least that serves (files of known form; triangles only).

namespace quench {
namespace voxelize_meshes_test {

TriangleMesh read_off(std::istream& in) {
  TriangleMesh mesh;
  std::string word;
  std::size_t points = 0, faces = 0, edges = 0, corners = 0;
  in >> word >> points >> faces >> edges;
  mesh.points.resize(points);
  mesh.triangles.resize(faces);
  for (Vec3& p : mesh.points) in >> p[0] >> p[1] >> p[2];
  for (auto& t : mesh.triangles) {
    in >> corners >> t[0] >> t[1] >> t[2];
    EXPECT_EQ(corners, 3u);
    std::getline(in, word);
  }
  return mesh;
}

TriangleMesh read_obj(std::istream& in) {
  TriangleMesh mesh;
  std::string line, word;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    words >> word;
    if (line.starts_with("v ")) {
      Vec3 p;
      words >> p[0] >> p[1] >> p[2];
      mesh.points.push_back(p);
    } else if (line.starts_with("f ")) {
      std::vector<std::uint32_t> corners;
      while (words >> word) corners.push_back(static_cast<std::uint32_t>(std::stoul(word)) - 1);
      for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

TriangleMesh read_ply(std::istream& in) {
  TriangleMesh mesh;
  std::string line;
  bool binary = false;
  while (std::getline(in, line) && line != "end_header") {
    if (line.starts_with("format binary")) binary = true;
    if (line.starts_with("element vertex ")) mesh.points.resize(std::stoul(line.substr(15)));
    if (line.starts_with("element face ")) mesh.triangles.resize(std::stoul(line.substr(13)));
  }
  for (Vec3& p : mesh.points) {
    if (binary) {
      std::array<float, 3> f{};
      in.read(reinterpret_cast<char*>(f.data()), sizeof f);
      p = Vec3(f[0], f[1], f[2]);
    } else {
      in >> p[0] >> p[1] >> p[2];
      std::getline(in, line);
    }
  }
  for (auto& t : mesh.triangles) {
    if (binary) {
      EXPECT_EQ(in.get(), 3);
      in.read(reinterpret_cast<char*>(t.data()), sizeof t);
    } else {
      in >> line >> t[0] >> t[1] >> t[2];
    }
  }
  return mesh;
}

TriangleMesh read(const std::string& name) {
  std::ifstream in(data_file(name.c_str()), std::ios::binary);
  const TriangleMesh mesh = name.ends_with(".off")   ? read_off(in)
                            : name.ends_with(".obj") ? read_obj(in)
                                                     : read_ply(in);
  EXPECT_FALSE(in.bad());
  return mesh;
}

double signed_volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]]));
  return sum / 6;
}

struct Known {
  const char* name;
  std::int64_t euler;  // of the surface
  double volume;
};

// As listed in the README of the data.
class ClosedMeshes : public testing::TestWithParam<Known> {};

TEST_P(ClosedMeshes, VolumeAndTopologyAreThoseOfTheMesh) {
  const Known& known = GetParam();
  REQUIRE_DATA(known.name);
  const TriangleMesh mesh = read(known.name);
  const double volume = signed_volume(mesh);
  EXPECT_NEAR(volume, known.volume, 1e-3 * std::abs(known.volume));
  for (const std::int64_t resolution : {64, 128}) {
    VoxelizeOptions options;
    options.resolution = resolution;
    const Voxelization matched = voxelize(mesh, options);
    matched.shape.validate();
    EXPECT_EQ(topology(matched.shape).betti, (std::array<std::int64_t, 3>{1, 1 - known.euler / 2, 0})) << resolution;
    EXPECT_FALSE(matched.topology_changed) << matched.topology_difference;
    options.topology = TopologyRule::voxels;
    const Voxelization result = voxelize(mesh, options);
    result.shape.validate();
    if (matched.repair) {  // few voxels
      EXPECT_LT(matched.repair->added + matched.repair->removed, result.shape.voxel_count() / 20) << resolution;
    }
    EXPECT_TRUE(result.surface.manifold);
    EXPECT_EQ(2 * result.surface.euler, known.euler);
    EXPECT_EQ(result.surface.components, 1);
    const double h = result.shape.grid().spacing[0];
    // Plates of a few voxels gain or lose up to a layer of them.
    const double found = static_cast<double>(result.shape.voxel_count()) * h * h * h;
    EXPECT_NEAR(found / std::abs(volume), 1, resolution == 64 ? 0.1 : 0.05);
    const Topology t = topology(result.shape);
    const bool same = t.betti[0] + t.betti[2] == 1 && t.betti[1] == 1 - known.euler / 2;
    EXPECT_EQ(result.topology_changed, !same);
    EXPECT_EQ(result.topology_difference.empty(), same);
    if (!same) std::cout << known.name << " at " << resolution << ": " << result.topology_difference << '\n';
  }
}

INSTANTIATE_TEST_SUITE_P(
    Data, ClosedMeshes,
    testing::Values(Known{"meshes/bunny_closed.off", 2, 0.1992}, Known{"meshes/armadillo.off", 2, 0.06885},
                    Known{"meshes/fertility.off", -6, 0.0546}, Known{"meshes/elk.off", 0, 0.1053},
                    Known{"meshes/neptune.off", -4, 0.01312}, Known{"meshes/octopus.off", 2, 0.01211},
                    Known{"meshes/vessel.off", 2, 0.007544}, Known{"meshes/fandisk.off", 2, 0.1404},
                    Known{"meshes/block.off", -4, 7396}, Known{"meshes/casting.off", -16, -0.03391},
                    Known{"meshes/abc_00000802.obj", -6, 1.256e4}, Known{"meshes/kitten.obj", 0, 0.1209},
                    Known{"meshes/lucy.ply", 2, 8.167e7}),
    [](const auto& parameter) {
      const std::string name = std::filesystem::path(parameter.param.name).stem().string();
      return name;
    });

struct Defective {
  const char* name;
  std::int64_t open_edges, components;  // of the surface
  double low, high;                     // volume of the shape
  double largest;                       // share of its largest part, at least
  double winding, doubtful;             // shares of its voxels, at most
};

class DefectiveMeshes : public testing::TestWithParam<Defective> {};

// The bunny's holes are all in its base: the volume is that of the closed one, brought to its size. The truck is a body
// with five wheels and small parts, open below; the neuron encloses what its faces say, much of it thinner than a
// voxel.
TEST_P(DefectiveMeshes, BecomeTheirShapes) {
  const Defective& known = GetParam();
  REQUIRE_DATA(known.name);
  const TriangleMesh mesh = read(known.name);
  for (const FillRule fill : {FillRule::nonzero, FillRule::automatic}) {
    VoxelizeOptions options;
    options.resolution = 96;
    options.fill = fill;
    const Voxelization v = voxelize(mesh, options);
    v.shape.validate();
    const double h = v.shape.grid().spacing[0], volume = static_cast<double>(v.shape.voxel_count()) * h * h * h;
    EXPECT_GT(volume, known.low);
    EXPECT_LT(volume, known.high);
    EXPECT_FALSE(v.sound);
    EXPECT_FALSE(v.topology_known);
    EXPECT_EQ(v.defects.open_edges, known.open_edges);
    EXPECT_EQ(v.surface.components, known.components);
    EXPECT_LE(v.defects.winding_share, known.winding);
    EXPECT_LE(v.defects.doubtful_share, known.doubtful);
    EXPECT_TRUE(defects_text(v).starts_with("the mesh is not closed (" + std::to_string(known.open_edges)))
        << defects_text(v);
    ForegroundOptions largest;
    largest.largest_component = true;
    const auto part = static_cast<double>(clean(v.shape, largest).voxel_count());
    EXPECT_GE(part / static_cast<double>(v.shape.voxel_count()), known.largest);
  }
}

INSTANTIATE_TEST_SUITE_P(Data, DefectiveMeshes,
                         testing::Values(Defective{"meshes/bunny_holes.ply", 223, 1, 7.4e-4, 7.7e-4, 1, 0.05, 0.02},
                                         Defective{"meshes/truck.obj", 1388, 50, 0.35, 0.45, 0.9, 0.8, 0.2},
                                         Defective{"meshes/neuron_1734350788.ply", 6, 14, 0.9e9, 1.6e9, 0.02, 0, 0}),
                         [](const auto& parameter) {
                           return std::filesystem::path(parameter.param.name).stem().string();
                         });

TEST(VoxelizeAuto, FindsTheTunnelsOfFertility) {
  REQUIRE_DATA("meshes/fertility.off");
  const Voxelization result = voxelize_auto(read("meshes/fertility.off"));
  EXPECT_FALSE(result.topology_changed) << result.topology_difference;
  EXPECT_EQ(topology(result.shape).betti, (std::array<std::int64_t, 3>{1, 4, 0}));
}

}  // namespace voxelize_meshes_test
}  // namespace quench
