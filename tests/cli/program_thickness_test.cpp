// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "program.h"
#include "quench/io.h"

// quench thickness: what it writes, and what it refuses.

using namespace quench::testing_program;
using quench::io::read_record;
using quench::io::read_volume;

namespace program_thickness_test {

class Thickness : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    folder.write("plate.npy", npy_box(30, 30, 8, 2));
    folder.write("cube.off", cube_off());
  }
  nlohmann::json json(const std::string& file) { return nlohmann::json::parse(bytes(file)); }
};

TEST_F(Thickness, AsVolumeAndTables) {
  works({"thickness", "plate.npy", "--correction", "0", "-o", "t.nrrd", "--csv", "t.csv", "--histogram", "h.csv",
         "--json", "t.json"});
  const auto volume = read_volume(folder / "t.nrrd"), shape = read_volume(folder / "plate.npy");
  EXPECT_EQ(volume.grid.dims, shape.grid.dims);
  const auto& values = std::get<std::vector<float>>(volume.samples);
  const auto& inside = std::get<std::vector<std::uint8_t>>(shape.samples);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(values[i] > 0, inside[i] > 0);
    sum += static_cast<double>(values[i]);
    count += inside[i] > 0;
  }
  const auto report = json("t.json")["thickness"];
  EXPECT_EQ(report["voxels"], count);
  EXPECT_EQ(report["uncovered"], 0);
  EXPECT_NEAR(report["mean"].get<double>(), sum / count, 1e-5);
  EXPECT_EQ(bytes("t.csv").substr(0, 13), "count,mean,sd");
  EXPECT_EQ(bytes("h.csv").substr(0, 20), "from,to,count,share,");
  EXPECT_EQ(json("t.json")["parameters"]["correction"], 0);
  works({"thickness", "plate.npy", "-o", "c.nii.gz", "--threads", "3", "--json", "c.json"});
  EXPECT_NEAR(json("c.json")["thickness"]["mean"].get<double>(), sum / count + 1, 1e-5);
  works({"thickness", "plate.npy", "--balls", "vertices", "--correction", "0", "--json", "v.json"});
  EXPECT_LE(json("v.json")["thickness"]["mean"].get<double>(), sum / count + 1e-6);
}

TEST_F(Thickness, OfPoresAndInAMask) {
  works({"thickness", "plate.npy", "--invert", "-o", "p.npy"});
  const auto pores = read_volume(folder / "p.npy"), shape = read_volume(folder / "plate.npy");
  const auto& values = std::get<std::vector<float>>(pores.samples);
  const auto& inside = std::get<std::vector<std::uint8_t>>(shape.samples);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i] > 0, inside[i] == 0);
  works({"thickness", "cube.off", "--resolution", "20", "--invert", "-o", "q.npy"});
  works({"thickness", "plate.npy", "--mask", "p.npy", "-o", "none.tif", "--json", "m.json"});
  EXPECT_EQ(json("m.json")["thickness"]["voxels"], 0);
  refuses(2, {"--mask", "34 x 34 x 12"}, {"thickness", "plate.npy", "--mask", "q.npy"});
}

TEST_F(Thickness, OnTheSurface) {
  works({"thickness", "cube.off", "--resolution", "32", "--surface", "s.ply", "--png", "s.png", "--json", "s.json"});
  const quench::Record surface = read_record(folder / "s.ply"), mesh = read_record(folder / "cube.off");
  EXPECT_EQ(surface.points.size(), mesh.points.size());
  for (const char* name : {"thickness", "across_x", "across_y", "across_z"})
    EXPECT_TRUE(quench::find_array(surface.point_data, name)) << name;
  EXPECT_EQ(bytes("s.png").substr(1, 3), "PNG");
  EXPECT_EQ(json("s.json")["surface"]["points"], mesh.points.size());
  EXPECT_FALSE(json("s.json").contains("thickness"));
  works({"thickness", "plate.npy", "--surface", "s.vtp", "-o", "both.npy"});
}

TEST_F(Thickness, OfTheBallsOfAnAxis) {
  works({"core", "plate.npy", "--surface", "voxels", "-o", "core.vtp"});
  works({"thickness", "plate.npy", "--axis", "core.vtp", "--json", "a.json", "-o", "a.npy"});
  works({"thickness", "plate.npy", "--json", "w.json", "-o", "w.npy"});
  const auto pruned = read_volume(folder / "a.npy"), whole = read_volume(folder / "w.npy");
  const auto &a = std::get<std::vector<float>>(pruned.samples), &w = std::get<std::vector<float>>(whole.samples);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE(a[i], w[i]);
  EXPECT_EQ(json("w.json")["thickness"]["uncovered"], 0);
  EXPECT_EQ(json("a.json")["input"]["axis"], "core.vtp");
}

TEST_F(Thickness, WhatIsRefused) {
  refuses(2, {"'t.vol'", ".nrrd"}, {"thickness", "plate.npy", "-o", "t.vol"});
  refuses(2, {"'smooth'", ".ply"}, {"thickness", "plate.npy", "--surface", "smooth"});
  refuses(2, {"--csv", ".csv"}, {"thickness", "plate.npy", "--csv", "t.txt"});
  refuses(2, {"two outputs", "a.csv"}, {"thickness", "plate.npy", "--csv", "a.csv", "--histogram", "a.csv"});
  refuses(2, {"--invert"}, {"thickness", "plate.npy", "--invert", "--png", "a.png"});
  refuses(2, {"--balls"}, {"thickness", "plate.npy", "--balls", "some"});
  refuses(1, {"'no.nrrd'"}, {"thickness", "plate.npy", "--mask", "no.nrrd"});
}

}  // namespace program_thickness_test
