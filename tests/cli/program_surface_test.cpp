// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "program.h"

// --surface: what points and radii are fitted to, what is written of it, and where it cannot be had.

using namespace quench::testing_program;

namespace program_surface_test {

class SurfaceOption : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::string grey;
    for (int z = 0; z < 16; ++z)
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
          const double inside = 5 - std::hypot(x - 7.3, y - 7.6, z - 7.45);
          grey += static_cast<char>(std::lround(100 + 40 * std::clamp(inside, -1.0, 1.0)));
        }
    folder.write("grey.npy", npy(16, 16, 16, grey));
    folder.write("mask.npy", npy_box(5, 6, 7, 2));
    folder.write("cube.off", cube_off());
  }
};

TEST_F(SurfaceOption, GreyValuesAreTheDefaultAndAreVerified) {
  const Outcome core = works({"core", "grey.npy", "--threshold", "100", "-o", "a.vtp"});
  EXPECT_NE(core.err.find("grey values"), std::string::npos) << core.err;
  works({"core", "grey.npy", "--threshold", "100", "--surface", "grey", "-o", "b.vtp"});
  works({"core", "grey.npy", "--threshold", "100", "--surface", "voxels", "-o", "c.vtp"});
  EXPECT_EQ(bytes("a.vtp"), bytes("b.vtp"));
  EXPECT_NE(bytes("a.vtp"), bytes("c.vtp"));
  EXPECT_NE(bytes("a.vtp").find("voxel_radius"), std::string::npos);
  EXPECT_EQ(bytes("c.vtp").find("voxel_radius"), std::string::npos);
  for (const char* file : {"a.vtp", "c.vtp"}) works({"verify", "grey.npy", file});  // with the surface of the file
}

TEST_F(SurfaceOption, MasksHaveASmoothSurfaceOnRequest) {
  works({"core", "mask.npy", "-o", "a.vtp"});
  works({"core", "mask.npy", "--surface", "voxels", "-o", "b.vtp"});
  works({"core", "mask.npy", "--surface", "smooth", "-o", "c.vtp"});
  EXPECT_EQ(bytes("a.vtp"), bytes("b.vtp"));
  EXPECT_NE(bytes("c.vtp").find("voxel_radius"), std::string::npos);
  works({"verify", "mask.npy", "c.vtp"});
}

TEST_F(SurfaceOption, SurfacesAreWritten) {
  works({"voxelize", "grey.npy", "--threshold", "100", "-o", "a.nrrd", "--surface-file", "a.ply"});
  works({"voxelize", "grey.npy", "--threshold", "100", "-o", "b.nrrd"});
  EXPECT_EQ(bytes("a.nrrd"), bytes("b.nrrd"));
  const Outcome info = works({"info", "a.ply"});
  EXPECT_NE((info.out + info.err).find("closed_2_manifold: true"), std::string::npos) << info.out << info.err;
  refuses(2, {"no surface but that of its voxels", "--surface smooth"},
          {"voxelize", "mask.npy", "-o", "no.nrrd", "--surface-file", "no.ply"});
  refuses(2, {"'no.stl'", ".ply, .obj or .vtp"},
          {"voxelize", "mask.npy", "-o", "no.nrrd", "--surface-file", "no.stl", "--surface", "smooth"});
  refuses(2, {"'no.nrrd'"}, {"voxelize", "grey.npy", "-o", "no.nrrd", "--surface-file", "no.nrrd"});
}

TEST_F(SurfaceOption, WhatCannotBeHadIsRefused) {
  refuses(2, {"at most two values", "'smooth' or 'voxels'"},
          {"core", "mask.npy", "--threshold", "1", "--surface", "grey", "-o", "no.vtp"});
  refuses(2, {"only a threshold"}, {"core", "mask.npy", "--label", "1", "--surface", "grey", "-o", "no.vtp"});
  refuses(2, {"a volume is not a mesh"}, {"core", "mask.npy", "--surface", "mesh", "-o", "no.vtp"});
  refuses(2, {"a mesh has no grey values"}, {"core", "cube.off", "--surface", "grey", "-o", "no.vtp"});
  refuses(2, {"--surface", "rough"}, {"core", "cube.off", "--surface", "rough", "-o", "no.vtp"});
}

}  // namespace program_surface_test
