// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "program.h"

// quench reconstruct: voxels and meshes of axes, what is said of them, and what is refused.

using namespace quench::testing_program;

namespace program_reconstruct_test {

class Reconstruct : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    folder.write("mask.npy", npy_box(9, 8, 7, 2));
    folder.write("cube.off", cube_off());
  }
  bool reports(const std::string& file, const std::string& what) { return bytes(file).find(what) != std::string::npos; }
};

TEST_F(Reconstruct, BallsOfTheWholeCoreAreTheVoxelsAgain) {
  works({"core", "mask.npy", "--lambda", "0", "-o", "a.vtp"});
  works({"voxelize", "mask.npy", "-o", "voxels.nrrd"});
  const Outcome with = works({"reconstruct", "a.vtp", "--shape", "mask.npy", "-o", "b.nrrd", "--json", "b.json"});
  EXPECT_NE(with.err.find("volume: 0 % missing, 0 % added"), std::string::npos) << with.err;
  EXPECT_EQ(bytes("b.nrrd"), bytes("voxels.nrrd"));
  EXPECT_TRUE(reports("b.json", "\"missing\": 0.0")) << bytes("b.json");
  EXPECT_TRUE(reports("b.json", "\"surface\": \"voxels\""));
  EXPECT_TRUE(reports("b.json", "\"kind\": \"balls\""));
  works({"reconstruct", "a.vtp", "-o", "c.nrrd"});  // AXIS knows its grid
  EXPECT_EQ(bytes("c.nrrd"), bytes("voxels.nrrd"));
}

TEST_F(Reconstruct, MeshesAreClosedAndKnowTheirDistance) {
  works({"core", "cube.off", "--resolution", "24", "-o", "a.vtp"});
  const Outcome out =
      works({"reconstruct", "a.vtp", "--envelope", "--shape", "cube.off", "-o", "b.ply", "--json", "b.json"});
  EXPECT_NE(out.err.find("balls, cones and slabs"), std::string::npos) << out.err;
  EXPECT_NE(out.err.find("components/tunnels/cavities 1/0/0, of the axis 1/0/0, of the shape 1/0/0"), std::string::npos)
      << out.err;
  EXPECT_TRUE(reports("b.json", "\"surface\": \"mesh\""));
  EXPECT_TRUE(reports("b.ply", "distance"));
  const Outcome info = works({"info", "b.ply"});
  EXPECT_NE((info.out + info.err).find("closed_2_manifold: true"), std::string::npos) << info.out << info.err;
  works({"reconstruct", "a.vtp", "--envelope", "-o", "c.obj"});
  works({"convert", "a.vtp", "a.ma"});
  works({"reconstruct", "a.ma", "--envelope", "--resolution", "30", "-o", "d.vtp"});  // of any program
  works({"reconstruct", "a.ma", "-o", "e.nrrd", "--shape", "cube.off", "--resolution", "16"});
}

TEST_F(Reconstruct, SaysWhatIsCutOff) {
  folder.write("one.ma", "2 1 0\nv 0 0 0 3\nv 12 0 0 3\ne 0 1\n");
  const Outcome out = works({"reconstruct", "one.ma", "--envelope", "--shape", "mask.npy", "-o", "b.nrrd"});
  EXPECT_NE(out.err.find("lie beyond the grid of the shape"), std::string::npos) << out.err;
  works({"reconstruct", "one.ma", "--resolution", "20", "-o", "c.nrrd"});
}

TEST_F(Reconstruct, RefusesWhatHasNoSolid) {
  works({"core", "mask.npy", "-o", "a.vtp"});
  refuses(2, {"'no.stl'", ".nrrd .zarr", ".ply .obj .vtp"}, {"reconstruct", "a.vtp", "-o", "no.stl"});
  refuses(3, {"'cube.off' is a mesh, not a medial axis"}, {"reconstruct", "cube.off", "-o", "no.nrrd"});
  refuses(1, {"'there.off' does not exist"}, {"reconstruct", "a.vtp", "--shape", "there.off", "-o", "no.nrrd"});
  refuses(2, {"--threshold"}, {"reconstruct", "a.vtp", "--threshold", "1", "-o", "no.nrrd"});
  refuses(2, {"'a.vtp'"}, {"reconstruct", "a.vtp", "-o", "a.vtp"});
  folder.write("point.ma", "1 0 0\nv 1 2 3 0\n");
  refuses(3, {"one point"}, {"reconstruct", "point.ma", "-o", "no.nrrd"});
}

}  // namespace program_reconstruct_test
