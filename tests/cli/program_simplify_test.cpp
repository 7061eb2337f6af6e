// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "program.h"
#include "quench/axis.h"
#include "quench/io.h"

// `quench simplify` and `quench smooth`.

using namespace quench;
using namespace quench::testing_program;

namespace program_simplify_test {

class Simplify : public ProgramTest {
 protected:
  void SetUp() override {
    works({"sample", "fin-on-board", "--fineness", "0.3", "-o", "shape.ply"});
    works({"core", "shape.ply", "--resolution", "64", "-o", "core.vtp"});
    core_ = medial_axis_of(io::read_record(folder / "core.vtp"));
  }
  MedialAxis axis(const std::string& name) { return medial_axis_of(io::read_record(folder / name)); }
  nlohmann::json json(const std::string& name) { return nlohmann::json::parse(bytes_of(folder / name)); }

  MedialAxis core_;
};

TEST_F(Simplify, WritesAnAxisOfTheTopologyInEveryFormat) {
  works({"simplify", "core.vtp", "--vertices", "60", "--shape", "shape.ply", "-o", "s.vtp", "--json", "s.json",
         "--levels", "l.csv"});
  const MedialAxis few = axis("s.vtp");
  EXPECT_EQ(few.points.size(), 60u);
  EXPECT_EQ(topology(few.complex), topology(core_.complex));
  const auto report = json("s.json");
  EXPECT_EQ(report["simplified"]["vertices"], 60);
  EXPECT_EQ(report["parameters"]["boundary"], "mesh");
  const double side = report["errors"]["longest_side"];
  EXPECT_LT(report["errors"]["boundary_from_envelope"]["either_side"]["mean"], 0.01 * side);
  EXPECT_GE(report["errors"]["envelope_from_boundary"]["outside"]["largest"], 0.0);
  const std::string levels = bytes_of(folder / "l.csv");
  EXPECT_TRUE(levels.starts_with("vertices,edges,triangles,mean,"));

  works({"simplify", "core.vtp", "--vertices", "60", "--shape", "shape.ply", "-o", "s.ma", "--threads", "1"});
  for (const char* name : {"s.ply", "s.obj"}) works({"simplify", "s.vtp", "--vertices", "60", "-o", name});
  const MedialAxis again = axis("s.ma");
  EXPECT_EQ(again.points, few.points);
  EXPECT_EQ(again.radius, few.radius);
  EXPECT_EQ(again.complex.edges, few.complex.edges);
  EXPECT_EQ(again.complex.face_count(), few.complex.face_count());
}

TEST_F(Simplify, MaListsEverySideOfATriangleBeforeIt) {
  works({"simplify", "core.vtp", "--vertices", "40", "-o", "s.ma"});
  std::istringstream file(bytes_of(folder / "s.ma"));
  std::size_t vertices = 0, edges = 0, triangles = 0;
  file >> vertices >> edges >> triangles;
  std::set<std::set<int>> known;
  std::string key;
  for (std::size_t v = 0; v < vertices; ++v) {
    double x, y, z, r;
    ASSERT_TRUE(file >> key >> x >> y >> z >> r);
    ASSERT_EQ(key, "v");
  }
  for (std::size_t e = 0; e < edges; ++e) {
    int i, j;
    ASSERT_TRUE(file >> key >> i >> j);
    ASSERT_EQ(key, "e");
    EXPECT_TRUE(known.insert({i, j}).second);
  }
  EXPECT_GT(triangles, 0u);
  for (std::size_t f = 0; f < triangles; ++f) {
    int i, j, k;
    ASSERT_TRUE(file >> key >> i >> j >> k);
    ASSERT_EQ(key, "f");
    EXPECT_TRUE(known.contains({i, j}) && known.contains({j, k}) && known.contains({i, k}));
  }
  EXPECT_FALSE(file >> key);
}

TEST_F(Simplify, MeetsAnError) {
  works({"simplify", "core.vtp", "--error", "5%", "-o", "s.vtp", "--json", "s.json"});
  const auto report = json("s.json");
  const double side = report["errors"]["longest_side"];
  EXPECT_LE(report["errors"]["boundary_from_envelope"]["either_side"]["largest"], 0.05 * side);
  EXPECT_EQ(report["parameters"]["boundary"], "envelope");
  EXPECT_LT(axis("s.vtp").points.size(), core_.points.size() / 4);
}

TEST_F(Simplify, RefusesWhatItCannotDo) {
  refuses(2, {"--vertices"}, {"simplify", "core.vtp", "--vertices", "0", "-o", "s.vtp"});
  refuses(2, {"--error"}, {"simplify", "core.vtp", "--error", "-1", "-o", "s.vtp"});
  refuses(2, {"--levels", ".csv"}, {"simplify", "core.vtp", "--levels", "l.txt", "-o", "s.vtp"});
  refuses(2, {".swc"}, {"simplify", "core.vtp", "-o", "s.swc"});
  refuses(1, {"none.ply"}, {"simplify", "core.vtp", "--shape", "none.ply", "-o", "s.vtp"});
}

TEST_F(Simplify, SmoothMovesNoFartherThanAsked) {
  works({"smooth", "core.vtp", "-o", "s.vtp", "--json", "s.json"});
  const MedialAxis smooth = axis("s.vtp");
  ASSERT_EQ(smooth.complex.edges, core_.complex.edges);
  const auto report = json("s.json");
  const double most = report["parameters"]["most"];
  double moved = 0;
  for (std::size_t v = 0; v < smooth.points.size(); ++v)
    moved = std::max(moved, (smooth.points[v] - core_.points[v]).norm());
  EXPECT_GT(moved, 0);
  EXPECT_LE(moved, most * (1 + 1e-9));
  EXPECT_NEAR(report["smoothed"]["largest_move"], moved, 1e-12);
  works({"smooth", "core.vtp", "--most", "0", "-o", "same.vtp"});
  EXPECT_EQ(axis("same.vtp").points, core_.points);
  refuses(2, {"--iterations"}, {"smooth", "core.vtp", "--iterations", "-1", "-o", "t.vtp"});
}

}  // namespace program_simplify_test
