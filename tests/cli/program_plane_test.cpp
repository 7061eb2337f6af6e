// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "program.h"

// `quench run` of files of several polygons.

using namespace quench::testing_program;

namespace program_plane_test {

std::string feature(const std::string& geometry, const std::string& more) {
  return R"({"type":"Feature",)" + more + R"("geometry":)" + geometry + "}";
}
std::string rectangle(int x, int width, int height) {
  const std::string left = std::to_string(x), right = std::to_string(x + width), top = std::to_string(height);
  return R"({"type":"Polygon","coordinates":[[[)" + left + ",0],[" + right + ",0],[" + right + "," + top + "],[" +
         left + "," + top + "]]]}";
}
std::string collection(const std::string& features) {
  return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

class ManyPolygons : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const std::string bad = feature("null", R"("id":"lost, found","properties":{"name":"none"},)");
    folder.write("mixed.geojson",
                 collection(feature(rectangle(1000, 30, 10), R"("id":7,"properties":{"name":"A","length":5},)") + "," +
                            bad + "," + feature(rectangle(2000, 10, 40), R"("properties":{"deep":[{"x":1.50}]},)")));
    folder.write("bad.geojson", collection(bad + "," + bad));
    folder.write("none.geojson", collection(""));
    folder.write("damaged.geojson", bytes("mixed.geojson").substr(0, bytes("mixed.geojson").size() - 60));
  }
  void has(const std::string& name, const std::string& text) {
    EXPECT_NE(bytes(name).find(text), std::string::npos) << name << " has no " << text << ":\n" << bytes(name);
  }
};

TEST_F(ManyPolygons, HaveTheirResultsInOneRun) {
  const Outcome run = works({"run", "mixed.geojson", "-o", "out", "--resolution", "64"});
  EXPECT_NE(run.err.find("warning: 1 of 3 features cannot be used"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("it has no geometry"), std::string::npos) << run.err;
  for (const char* file : {"out/skeleton.geojson", "out/skeleton.svg", "out/branches.csv", "out/features.csv",
                           "out/report.json", "out/picture.png"})
    EXPECT_TRUE(exists(file)) << file;
  has("out/features.csv", "\n0,7,");
  has("out/features.csv", "\n1,\"lost, found\",,,,,,,,,,,,'mixed.geojson': feature 1: it has no geometry,none,\n");
  has("out/skeleton.geojson", R"("name":"A","polygon_length":5,"feature":0,"feature_id":7,)");
  has("out/skeleton.geojson", R"("deep":[{"x":1.5}],"feature":2,)");
  has("out/report.json", R"("failed": 1)");
  has("out/branches.csv", "\n2,0,");
}

TEST_F(ManyPolygons, AreNotOverwritten) {
  works({"run", "mixed.geojson", "-o", "out", "--resolution", "32", "--no-view", "--no-picture"});
  refuses(2, {"skeleton.geojson", "--overwrite"}, {"run", "mixed.geojson", "-o", "out", "--resolution", "64"});
  const std::string before = bytes("out/features.csv");
  works({"run", "mixed.geojson", "-o", "out", "--resolution", "64", "--overwrite", "--no-view", "--no-picture"});
  EXPECT_NE(bytes("out/features.csv"), before);
}

TEST_F(ManyPolygons, OneCanBeChosen) {
  works({"run", "mixed.geojson", "--feature", "2", "-o", "one", "--resolution", "64", "--no-view", "--no-picture"});
  EXPECT_FALSE(exists("one/features.csv"));
  refuses(3, {"feature 1", "no geometry"}, {"run", "mixed.geojson", "--feature", "1", "-o", "out"});
  refuses(3, {"no feature 3", "it holds 3"}, {"run", "mixed.geojson", "--feature", "3", "-o", "out"});
  refuses(2, {"several polygons", "--feature"}, {"core", "mixed.geojson", "-o", "a.vtp"});
}

TEST_F(ManyPolygons, RefusalsLeaveNothing) {
  refuses(3, {"none of the 2 features", "no geometry"}, {"run", "bad.geojson", "-o", "out"});
  refuses(3, {"holds no polygons"}, {"run", "none.geojson", "-o", "out"});
  refuses(3, {"damaged"}, {"run", "damaged.geojson", "-o", "out", "--resolution", "32"});
}

TEST_F(ManyPolygons, NotesAreCounted) {
  std::string many;
  for (int k = 0; k < 1100; ++k)  // the hole is thinner than a pixel
    many +=
        (k == 0 ? "" : ",") +
        feature(R"({"type":"Polygon","coordinates":[[[0,0],[20,0],[20,20],[0,20]],[[5,1],[6,1],[6,1.01],[5,1.01]]]})",
                "");
  folder.write("many.geojson", collection(many));
  const Outcome run = works({"run", "many.geojson", "-o", "out", "--resolution", "16", "--no-view", "--no-picture"});
  EXPECT_NE(run.err.find("note: 1100 notes of features in"), std::string::npos) << run.err;
}

}  // namespace program_plane_test
