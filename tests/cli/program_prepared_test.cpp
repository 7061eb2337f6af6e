// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "program.h"

// --blur, --median, --interpolate, --close, --connectivity and the rules of --threshold: said, recorded, taken back.

using namespace quench::testing_program;

namespace program_prepared_test {

class Prepared : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::mt19937 random(1);
    std::string grey, label;
    // A slanted tube of 150 in 50 with noise, of which a piece touches the rest in an edge only.
    for (int z = 0; z < 20; ++z)
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 22; ++x) {
          const double inside = 3.5 - std::hypot(y - 8.3 - 0.1 * x, z - 9.6);
          const double noise = static_cast<double>(random() % 17) - 8;
          grey += static_cast<char>(std::lround(100 + 50 * std::clamp(inside, -1.0, 1.0) + noise));
        }
    for (int z = 0; z < 5; ++z)
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 22; ++x) label += static_cast<char>(std::hypot(x - 10.0 - z, y - 9.0) < 6 - z ? 5 : x % 3);
    folder.write("grey.npy", npy(22, 18, 20, grey));
    folder.write("label.npy", npy(22, 18, 5, label));
    std::string steps(27, '\0');
    for (const int at : {0, 4, 8}) steps[static_cast<std::size_t>(at)] = 90;
    folder.write("steps.npy", npy(3, 3, 3, steps));
    folder.write("cube.off", cube_off());
  }
  /// Whether a result verifies and is drawn without its options given again.
  void expect_taken_back(const std::string& volume, const std::string& result) {
    works({"verify", volume, result});
    works({"view", result, "--shape", volume, "-o", result + ".html"});
  }
};

TEST_F(Prepared, IsRecordedAndTakenBack) {
  const Outcome core = works({"core", "grey.npy", "--median", "1", "--blur", "0.8", "--threshold", "auto", "--close",
                              "1", "--connectivity", "26", "-o", "a.vtp"});
  for (const char* text :
       {"medians of 3 x 3 x 3 voxels", "blurred with a Gaussian of 0.8 voxels", "(edges)", "closed:"})
    EXPECT_NE(core.err.find(text), std::string::npos) << text << '\n' << core.err;
  EXPECT_EQ(core.err.find("joined:"), std::string::npos) << "there is nothing to join\n" << core.err;
  const std::string file = works({"info", "a.vtp"}).out;
  for (const char* name : {"median", "blur", "threshold", "close", "connectivity"})
    EXPECT_NE(file.find(name), std::string::npos) << name << '\n' << file;
  expect_taken_back("grey.npy", "a.vtp");
}

TEST_F(Prepared, HysteresisIsRecordedAndTakenBack) {
  works({"core", "grey.npy", "--threshold", "100,140", "-o", "a.vtp"});
  expect_taken_back("grey.npy", "a.vtp");
  works({"core", "grey.npy", "--threshold", "otsu", "-o", "b.vtp"});
  expect_taken_back("grey.npy", "b.vtp");
}

TEST_F(Prepared, LabelsOfThickSlicesBecomeSmooth) {
  works({"core", "label.npy", "--label", "5", "--spacing", "1,1,4", "--interpolate", "-o", "a.vtp"});
  expect_taken_back("label.npy", "a.vtp");
  const Outcome run = works({"run", "label.npy", "--label", "5", "--spacing", "1,1,4", "--interpolate", "-o", "out"});
  EXPECT_NE(run.err.find("interpolated by signed distances to cubes: 22 x 18 x 5"), std::string::npos) << run.err;
  EXPECT_NE(bytes("out/report.json").find("\"prepared\""), std::string::npos);
}

TEST_F(Prepared, VoxelsThatTouchAreJoined) {
  const Outcome apart = works({"voxelize", "steps.npy", "--threshold", "50", "-o", "a.nrrd"});
  EXPECT_NE(apart.err.find("3 components"), std::string::npos) << apart.err;
  const Outcome joined =
      works({"voxelize", "steps.npy", "--threshold", "50", "--connectivity", "26", "-o", "b.nrrd", "--json", "-"});
  EXPECT_NE(joined.out.find("\"joined\""), std::string::npos) << joined.out;
  EXPECT_NE(joined.out.find("\"components_joined\": 2"), std::string::npos) << joined.out;
}

TEST_F(Prepared, ThreadsDoNotMatter) {
  for (const char* threads : {"1", "3"})
    works({"voxelize", "grey.npy", "--threshold", "auto", "--blur", "1", "--median", "1", "--close", "2",
           "--connectivity", "26", "--threads", threads, "-o", std::string(threads) + ".nrrd"});
  EXPECT_EQ(bytes("1.nrrd"), bytes("3.nrrd"));
}

TEST_F(Prepared, InfoShowsAHistogramAndProposesThresholds) {
  const Outcome info = works({"info", "grey.npy"});
  for (const char* text : {"histogram: ", "####", "thresholds:", "edges: value ", "otsu: value ", "--threshold, e.g. "})
    EXPECT_NE(info.out.find(text), std::string::npos) << text << '\n' << info.out;
  const Outcome json = works({"info", "grey.npy", "--json"});
  for (const char* text : {"\"histogram\": {", "\"counts\": [", "\"thresholds\": {", "\"reason\": "})
    EXPECT_NE(json.out.find(text), std::string::npos) << text << '\n' << json.out;
  // The proposal is what auto takes.
  const std::size_t at = info.out.find("edges: value ") + 13;
  const std::string value = info.out.substr(at, info.out.find(',', at) - at);
  works({"voxelize", "grey.npy", "--threshold", value, "-o", "a.nrrd"});
  works({"voxelize", "grey.npy", "--threshold", "auto", "-o", "b.nrrd"});
  EXPECT_EQ(bytes("a.nrrd"), bytes("b.nrrd"));
}

// A box, and specks of which each touches it, or none does.
std::string npy_with_specks(int box, int specks, bool touching, bool plane = false) {
  const int nx = box + 2 + 4 * specks, n = box + 4;
  std::string samples(static_cast<std::size_t>(nx * n * (plane ? 1 : n)), '\0');
  const auto put = [&](int x, int y, int z) {
    if (plane && z > 0) return;
    samples[static_cast<std::size_t>(x + nx * (y + n * z))] = '\1';
  };
  const int length = touching ? 4 * specks : box;
  for (int x = 1; x <= length; ++x)
    for (int y = 1; y <= box; ++y)
      for (int z = 0; z < box; ++z) put(x, y, z);
  for (int i = 0; i < specks; ++i)
    if (touching)
      put(2 + 4 * i, box + 1, box);  // at an edge of the bar
    else
      put(box + 3 + 4 * i, 1, 0);
  return npy(nx, n, plane ? 1 : n, samples);
}

TEST_F(Prepared, SpecksAreNotedWhereSomethingHelps) {
  const auto note = [&](const std::string& file, std::vector<std::string> options) {
    options.insert(options.begin(), {"voxelize", file, "-o", "a.nrrd", "--overwrite"});
    const std::string said = works(options).err;
    const std::size_t at = said.find("note: ");
    return at == said.npos ? std::string() : said.substr(at, said.find('\n', at) - at);
  };
  folder.write("loose.npy", npy_with_specks(10, 12, false));
  folder.write("touching.npy", npy_with_specks(10, 12, true));
  folder.write("few.npy", npy_with_specks(10, 8, false));
  folder.write("small.npy", npy_with_specks(3, 12, false));
  folder.write("image.npy", npy_with_specks(20, 12, false, true));
  const std::string loose = "note: 12 of the 13 components have fewer than 30 voxels, together 1% of the shape; ";
  EXPECT_EQ(note("loose.npy", {}), loose + "--min-component 30 drops them");
  EXPECT_EQ(note("loose.npy", {"--min-component", "30"}), "");
  EXPECT_EQ(note("few.npy", {}), "");
  EXPECT_EQ(note("small.npy", {}), "");  // much of the shape
  EXPECT_EQ(note("touching.npy", {}),
            "note: 12 of the 13 components have fewer than 30 voxels, together 0.2% of the shape; --min-component 30 "
            "drops them, --connectivity 26 joins 12 that touch others");
  EXPECT_EQ(note("touching.npy", {"--connectivity", "26"}), "");
  EXPECT_EQ(note("image.npy", {"--dimension", "2"}),
            "note: 12 of the 13 components have fewer than 30 pixels, together 3% of the shape; --min-component 30 "
            "drops them");
}

TEST_F(Prepared, RefusesWhatMakesNoSense) {
  const auto no = [&](const std::vector<std::string>& said, std::vector<std::string> options) {
    options.insert(options.begin(), {"core", "grey.npy", "-o", "no.vtp"});
    refuses(2, said, options);
  };
  no({"--threshold"}, {"--threshold", "automatic"});
  no({"--threshold"}, {"--threshold", "20,"});
  no({"lower one is given first"}, {"--threshold", "120,100"});
  no({"inverted"}, {"--threshold", "100,120", "--invert"});
  no({"--threshold and --label"}, {"--threshold", "auto", "--label", "3"});
  no({"--blur"}, {"--threshold", "100", "--blur", "101"});
  no({"--median"}, {"--threshold", "100", "--median", "17"});
  no({"--connectivity"}, {"--threshold", "100", "--connectivity", "18"});
  no({"--close"}, {"--threshold", "100", "--close", "65"});
  no({"label", "no grey values"}, {"--label", "100", "--blur", "1"});
  const Outcome mesh =
      works({"core", "cube.off", "--resolution", "9", "--blur", "1", "--connectivity", "26", "-o", "a.vtp"});
  EXPECT_NE(mesh.err.find("note: --blur, --connectivity are for volumes"), std::string::npos) << mesh.err;
}

}  // namespace program_prepared_test
