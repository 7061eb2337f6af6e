// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "page_reader.h"
#include "program.h"
#include "quench/io.h"

// `quench view`, and the page of `quench run`.

using namespace quench::testing_program;
using quench::testing_page::Contents;
using quench::testing_page::read_page;

namespace program_view_test {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Whether the program was built with its page: it says so itself.
bool built_in(ProgramTest& test, Outcome (ProgramTest::*quench)(const std::vector<std::string>&)) {
  return !has((test.*quench)({"view", "absent.vtp"}).err, "without its interactive page");
}
#define REQUIRE_PAGE() \
  if (!built_in(*this, &ViewProgram::quench)) GTEST_SKIP() << "this quench was built without its interactive page"

class ViewProgram : public ProgramTest {
 public:
  using ProgramTest::quench;

 protected:
  void make_core() {
    folder.write("v.npy", npy_box(12, 9, 5, 2));
    works({"core", "v.npy", "--lambda", "0", "-o", "core.vtp"});
  }
  Contents page(const std::string& name) { return read_page(bytes(name)); }
};

TEST_F(ViewProgram, WithoutThePageItSaysSo) {
  if (built_in(*this, &ViewProgram::quench)) GTEST_SKIP() << "this quench has its interactive page built in";
  make_core();
  refuses(1, {"without its interactive page", "npm"}, {"view", "core.vtp"});
  works({"run", "v.npy", "-o", "out"});
  EXPECT_FALSE(exists("out/view.html"));
}

TEST_F(ViewProgram, RunWritesAPageOfEverything) {
  REQUIRE_PAGE();
  folder.write("cube shape.off", cube_off());
  const Outcome outcome = works({"run", "cube shape.off", "--resolution", "16", "-o", "out", "--json", "-"});
  EXPECT_TRUE(has(outcome.err, "out/view.html"));
  EXPECT_TRUE(has(outcome.out, "\"page\""));
  const Contents p = page("out/view.html");
  EXPECT_EQ(p.meta["title"], "cube shape");
  EXPECT_EQ(p.meta["command"], "quench run 'cube shape.off' --resolution 16 -o out --json -");
  EXPECT_EQ(p.meta["side"], 1.0);
  EXPECT_EQ(p.meta["voxel"], 1.0 / 16);
  EXPECT_EQ(p.meta["topology"]["euler"], 1);
  EXPECT_EQ(p.meta["files"]["core"], "out/core.vtp");
  EXPECT_EQ(p.meta["burning"]["propagation"], "segments");
  EXPECT_TRUE(p.meta["notes"].empty());
  EXPECT_FALSE(p.meta.contains("note"));
  EXPECT_NEAR(p.meta["floor"]["theta2"], 0.2 / 16, 1e-7);  // a fifth of a voxel
  EXPECT_EQ(p.meta["pruning"]["measure"], "detail");
  const double detail = std::sqrt(0.75) / 16;
  EXPECT_NEAR(p.meta["theta2"], 3 * detail, 1e-7);
  EXPECT_NEAR(p.meta["theta1"], 4.5 * detail, 1e-7);
  EXPECT_EQ(p.meta["theta1_radii"], 0.5);
  EXPECT_NEAR(p.meta["pruning"]["threshold"], detail, 1e-15);
  ASSERT_EQ(p.meta["measures"].size(), 1u);
  EXPECT_EQ(p.meta["measures"][0]["name"], "detail");
  EXPECT_NEAR(p.meta["measures"][0]["floor"], detail, 1e-7 * detail);
  EXPECT_LE(p.meta["measures"][0]["floor"], detail);
  EXPECT_FALSE(p.meta["floor"].contains("lambda"));
  for (const char* name :
       {"core/points", "core/face_level", "core/point/burn_time", "core/point/lambda", "skeleton/points",
        "skeleton/branch/length", "family/curve_edges", "family/medial_points", "simple/triangles", "simple/steps",
        "simple/errors", "shape/points", "shape/triangles", "shape/samples", "shape/point/thickness"})
    EXPECT_TRUE(p.has(name)) << name;
  EXPECT_EQ(p["shape/points"].size(), 24u);  // the mesh itself
  EXPECT_EQ(p["shape/samples"].size(), 60000u);
  for (const double x : p["shape/samples"]) EXPECT_TRUE(x >= -1e-6 && x <= 1 + 1e-6);
  const std::string core = bytes("out/core.vtp");
  works({"run", "cube shape.off", "--resolution", "16", "-o", "without", "--no-view"});
  EXPECT_FALSE(exists("without/view.html"));
  // The page of the run's own file is the same, but for what only the shape can tell.
  works({"view", "out/core.vtp"});
  const Contents again = page("out/core.html");
  EXPECT_EQ(again.meta["title"], "out");
  for (const auto& [name, values] : p.arrays)
    if (!name.starts_with("shape/") && !name.starts_with("simple/")) {
      const auto& others = again[name];
      ASSERT_EQ(values.size(), others.size()) << name;
      for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_TRUE(values[i] == others[i] || (std::isnan(values[i]) && std::isnan(others[i]))) << name << ' ' << i;
    }
  EXPECT_FALSE(again.has("shape/points"));
}

TEST_F(ViewProgram, EveryMeasureOfTheFileHasItsSlider) {
  REQUIRE_PAGE();
  make_core();
  quench::Record data = quench::io::read_record(folder / "core.vtp");
  for (auto* arrays : {&data.point_data, &data.cell_data})
    for (const char* name : {"lambda", "lambda_level"})
      if (const quench::DataArray* array = find_array(*arrays, name)) {
        quench::DataArray copy = *array;
        copy.name.replace(0, 6, "mine");
        arrays->push_back(std::move(copy));
      }
  for (quench::DataArray& array : data.field_data)
    if (array.name == "measures") std::get<std::vector<std::string>>(array.values).emplace_back("mine");
  quench::io::write_record(folder / "mine.vtp", data, {});
  works({"view", "mine.vtp"});
  const Contents p = page("mine.html");
  ASSERT_EQ(p.meta["measures"].size(), 2u);
  EXPECT_EQ(p.meta["measures"][1]["name"], "mine");
  EXPECT_EQ(p["core/face_level/mine"], p["core/face_level"]);
  EXPECT_EQ(p["core/point/mine"], p["core/point/lambda"]);
  works({"verify", "v.npy", "mine.vtp"});
  EXPECT_EQ(p.meta["pruning"]["measure"], "lambda");
  EXPECT_FALSE(p.meta.contains("state"));
}

TEST_F(ViewProgram, APageStartsWithAThresholdOfAMeasureThatItHas) {
  REQUIRE_PAGE();
  make_core();
  works({"view", "core.vtp", "--lambda", "2vox", "--layer", "core"});
  EXPECT_EQ(page("core.html").meta["state"], "layer=core&measure=lambda&threshold=2");
  const auto refuse = [&](const std::vector<std::string>& words, const std::string& file, const std::string& option) {
    refuses(2, words, {"view", file, option, "1vox", "-o", "refused.html"});
  };
  refuse({"--detail", "does not have", "lambda", "quench core --detail"}, "core.vtp", "--detail");
  works({"core", "v.npy", "-o", "clean.vtp"});
  works({"view", "clean.vtp", "--detail", "1.5abs"});
  EXPECT_EQ(page("clean.html").meta["state"], "measure=detail&threshold=1.5");
  refuse({"--lambda", "does not have", "detail"}, "clean.vtp", "--lambda");
  works({"skeleton", "core.vtp", "-o", "skeleton.vtp"});
  refuse({"--detail", "none in this page"}, "skeleton.vtp", "--detail");
  refuses(2, {"--detail excludes --lambda"}, {"view", "core.vtp", "--detail", "1vox", "--lambda", "1vox"});
}

TEST_F(ViewProgram, AShapeIsReadAsTheFileSays) {
  REQUIRE_PAGE();
  make_core();
  works({"view", "core.vtp", "--shape", "v.npy", "-o", "page.html", "--theta2", "2abs", "--theta1", "inf", "--color",
         "radius"});
  const Contents p = page("page.html");
  EXPECT_EQ(p["shape/sites"].size() / 3, std::size_t{13 * 10 * 6 - 11 * 8 * 4});
  EXPECT_EQ(p.meta["theta2"], 2);
  EXPECT_TRUE(p.meta["theta1"].is_null());
  EXPECT_EQ(p.meta["state"], "color=radius");
  EXPECT_EQ(p.meta["sites_to_world"].size(), 12u);
}

TEST_F(ViewProgram, AMeshIsFilledAsTheFileOrTheUserSays) {
  REQUIRE_PAGE();
  // Two boxes, one in the other: together they are solid or hollow.
  std::string off = "OFF\n16 24 0\n";
  for (const int size : {6, 2})
    for (int c = 0; c < 8; ++c)
      off += fmt::format("{} {} {}\n", c & 1 ? size : -size, c & 2 ? size : -size, c & 4 ? size : -size);
  for (const int b : {0, 8})
    for (const char* face : {"021", "123", "456", "657", "014", "415", "263", "367", "042", "246", "153", "357"})
      off += fmt::format("3 {} {} {}\n", b + face[0] - '0', b + face[1] - '0', b + face[2] - '0');
  folder.write("boxes.off", off);
  works({"core", "boxes.off", "--resolution", "12", "--fill", "evenodd", "-o", "hollow.vtp"});
  const auto sites = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"view", "hollow.vtp", "--shape", "boxes.off", "-o", "page.html", "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    works(arguments);
    return page("page.html")["shape/sites"].size();
  };
  const std::size_t hollow = sites({}), solid = sites({"--fill", "nonzero"});
  EXPECT_GT(hollow, solid);
  refuses(2, {"--fill", "--shape"}, {"view", "hollow.vtp", "--fill", "winding", "-o", "other.html"});
}

TEST_F(ViewProgram, BudgetsAndNotes) {
  REQUIRE_PAGE();
  make_core();
  const Outcome outcome = works({"view", "core.vtp", "--shape", "v.npy", "-o", "page.html", "--max-triangles", "1000"});
  const Contents p = page("page.html");
  std::size_t triangles = p["shape/triangles"].size() / 3;
  for (const std::string layer : {"core", "family"})
    triangles += p[layer + "/polygon_corners"].size() - 2 * (p[layer + "/polygon_offsets"].size() - 1);
  EXPECT_LE(triangles, 1000u);
  EXPECT_GE(p.meta["notes"].size(), 2u);
  for (const auto& note : p.meta["notes"]) EXPECT_TRUE(has(outcome.err, note)) << note;
  EXPECT_GT(p.meta["floor"]["theta2"], 0);
}

TEST_F(ViewProgram, TheSkeletonAskedForIsWholeWhateverTheBudget) {
  REQUIRE_PAGE();
  works({"sample", "fin-on-board", "--resolution", "32", "-o", "fin.nrrd"});
  works({"run", "fin.nrrd", "-o", "little", "--max-triangles", "1000", "--theta2", "3vox"});
  works({"run", "fin.nrrd", "-o", "all", "--theta2", "3vox"});
  const Contents little = page("little/view.html"), all = page("all/view.html");
  EXPECT_TRUE(has(little.meta["note"], "The sliders begin at theta2 = "));
  EXPECT_FALSE(all.meta.contains("note"));
  EXPECT_EQ(little.meta["theta2"], all.meta["theta2"]);
  EXPECT_GT(little.meta["floor"]["theta2"], little.meta["theta2"]);
  for (const auto& [name, values] : all.arrays)
    if (name.starts_with("skeleton/") && !name.starts_with("skeleton/point/")) {
      EXPECT_EQ(values, little[name]) << name;
    }
}

TEST_F(ViewProgram, OtherFilesAreShownAsTheyAre) {
  REQUIRE_PAGE();
  make_core();
  works({"skeleton", "core.vtp", "-o", "skeleton.vtp"});
  works({"view", "skeleton.vtp"});
  const Contents p = page("skeleton.html");
  EXPECT_TRUE(p.has("still/points"));
  EXPECT_TRUE(p.has("still/point/curve_burn_time"));
  EXPECT_FALSE(p.has("skeleton/points"));
  works({"view", "core.vtp", "skeleton.vtp", "-o", "both.html", "--layer", "still"});
  const Contents both = page("both.html");
  EXPECT_TRUE(both.has("still/points") && both.has("core/points") && both.has("skeleton/points"));
  EXPECT_EQ(both.meta["state"], "layer=still");
  folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 3 0\nl 1 2\nf 1 2 3\n");
  works({"view", "lines.obj"});
  EXPECT_EQ(page("lines.html").meta["side"], 3);
  folder.write("two.ma", "3 1 1\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 2\ne 0 1\nf 0 1 2\n");
  works({"view", "two.ma"});
  EXPECT_EQ(page("two.html")["still/point/radius"], (std::vector<double>{1, 1, 2}));
}

TEST_F(ViewProgram, ABurnedFileGivesTheSamePage) {
  REQUIRE_PAGE();
  make_core();
  works({"burn", "core.vtp", "-o", "burned.vtp"});
  const auto view = [&] {
    const Outcome outcome = works({"view", "burned.vtp", "-o", "page.html", "--verbose", "--overwrite"});
    return has(outcome.err, "the file is burned on ");
  };
  EXPECT_TRUE(view());
  const std::string once = bytes("page.html");
  quench::Record plain = quench::io::read_record(folder / "burned.vtp");
  std::erase_if(plain.field_data, [](const quench::DataArray& a) { return a.name.starts_with("sequence_"); });
  quench::io::write_record(folder / "burned.vtp", plain);
  EXPECT_FALSE(view());
  EXPECT_EQ(bytes("page.html"), once);
}

TEST_F(ViewProgram, RefusalsNameTheWayOut) {
  REQUIRE_PAGE();
  make_core();
  folder.write("cube.off", cube_off());
  refuses(3, {"cube.off", "quench run"}, {"view", "cube.off"});
  refuses(3, {"v.npy", "quench run"}, {"view", "v.npy"});
  refuses(1, {"absent.vtp", "does not exist"}, {"view", "absent.vtp"});
  refuses(2, {"one medial axis"}, {"view", "core.vtp", "core.vtp"});
  refuses(2, {"--camera"}, {"view", "core.vtp", "--camera", "1,2,3"});
  refuses(2, {"--size"}, {"view", "core.vtp", "--png", "a.png", "--size", "100"});
  refuses(2, {"--png", ".png"}, {"view", "core.vtp", "--png", "a.jpg"});
  refuses(2, {"--png a.png"}, {"view", "core.vtp", "-o", "a.png"});
  refuses(2, {"--theta2"}, {"view", "core.vtp", "--theta2", "-1"});
  refuses(2, {"--max-triangles"}, {"view", "core.vtp", "--max-triangles", "10"});
  refuses(2, {"--shape"}, {"view", "core.vtp", "--threshold", "1"});
  refuses(2, {"'hue'", "radius"}, {"view", "core.vtp", "--color", "hue"});
  refuses(2, {"no layer"}, {"view", "core.vtp", "--layer", "still"});
  works({"view", "core.vtp"});
  refuses(2, {"core.html", "--overwrite"}, {"view", "core.vtp"});
  works({"view", "core.vtp", "--overwrite", "--quiet"});
  refuses(2, {"input"}, {"view", "core.vtp", "-o", "core.vtp", "--overwrite"});
}

// A page that outgrows the disk leaves the old one, and nothing else.
TEST_F(ViewProgram, AFullDiskLeavesWhatWasThere) {
  REQUIRE_PAGE();
  make_core();
  works({"view", "core.vtp", "-o", "page.html"});
  const auto before = files();
  const Outcome outcome = wait(start({"view", "core.vtp", "-o", "page.html", "--overwrite"}, 100'000));
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "cannot write 'page.html'")) << outcome.err;
  EXPECT_EQ(files(), before);
}

TEST_F(ViewProgram, AnInterruptLeavesNothing) {
  REQUIRE_PAGE();
  folder.write("v.npy", npy_box(60, 50, 40, 2));
  works({"core", "v.npy", "--lambda", "0", "-o", "core.vtp"});
  const std::string core = bytes("core.vtp");
  const auto fifo = make_fifo("given.vtp");
  const auto before = files();
  const pid_t child = start({"view", "given.vtp", "--omega", "0.05vox"});
  const int to = open_to_write(fifo);
  for (std::size_t sent = 0; sent < core.size();) {
    const ssize_t now = write(to, core.data() + sent, core.size() - sent);
    ASSERT_GT(now, 0);
    sent += static_cast<std::size_t>(now);
  }
  close(to);  // it has all it needs, and burning takes seconds
  kill(child, SIGINT);
  const Outcome outcome = wait(child);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  EXPECT_EQ(files(), before);
}

/// Width and height of a PNG.
std::array<int, 2> size_of_png(const std::string& png) {
  EXPECT_TRUE(png.starts_with("\x89PNG"));
  const auto number = [&](std::size_t at) {
    int n = 0;
    for (std::size_t i = 0; i < 4; ++i) n = n << 8 | static_cast<unsigned char>(png[at + i]);
    return n;
  };
  return {number(16), number(20)};
}

TEST_F(ViewProgram, RunDrawsItsSkeleton) {
  folder.write("cube.off", cube_off());
  const Outcome outcome = works({"run", "cube.off", "--resolution", "16", "-o", "out", "--json", "-"});
  EXPECT_TRUE(has(outcome.err, "out/picture.png"));
  EXPECT_TRUE(has(outcome.out, "\"picture\""));
  EXPECT_EQ(size_of_png(bytes("out/picture.png")), (std::array{1600, 1000}));
  EXPECT_GT(bytes("out/picture.png").size(), 5000u) << "blank";
  // The same from its file, with or without a page beside it.
  works({"view", "out/core.vtp", "--shape", "cube.off", "--png", "again.png"});
  EXPECT_TRUE(bytes("again.png") == bytes("out/picture.png"));
  EXPECT_FALSE(exists("out/core.html"));
  works({"run", "cube.off", "--resolution", "16", "-o", "no_view", "--no-view"});
  EXPECT_FALSE(exists("no_view/view.html"));
  EXPECT_TRUE(bytes("no_view/picture.png") == bytes("out/picture.png"));
  works({"run", "cube.off", "--resolution", "16", "-o", "neither", "--no-view", "--no-picture"});
  EXPECT_FALSE(exists("neither/picture.png"));
}

TEST_F(ViewProgram, EveryOptionOfAPictureIsSeen) {
  folder.write("cube.off", cube_off());
  works({"core", "cube.off", "--resolution", "8", "--detail", "0.1vox", "-o", "core.vtp"});
  std::map<std::string, std::string> pictures;
  for (const std::string options :
       {"", "--layer core", "--layer core --color lambda", "--layer core --detail 3vox", "--color radius --theta2 0",
        "--color none", "--dark", "--camera 0,0,4,0.5,0.5,0.5,0,1,0", "--theta2 inf", "--theta1 inf", "--no-caption",
        "--axes", "--shape cube.off", "--size 320x240"}) {
    std::vector<std::string> words{"view", "core.vtp", "--png", "a.png", "--size", "320x200", "--overwrite"};
    std::istringstream in(options);
    for (std::string word; in >> word;) {
      if (word == "--size") words.erase(words.begin() + 4, words.begin() + 6);
      words.push_back(word);
    }
    works(words);
    const std::string png = bytes("a.png");
    EXPECT_EQ(size_of_png(png), (std::array{320, options == "--size 320x240" ? 240 : 200}));
    for (const auto& [other, drawn] : pictures) EXPECT_TRUE(png != drawn) << options << " and " << other;
    pictures[options] = png;
  }
  works({"view", "core.vtp", "--png", "b.png", "--size", "320x200", "--threads", "1"});
  EXPECT_TRUE(bytes("b.png") == pictures[""]);
}

TEST_F(ViewProgram, OtherFilesAreDrawnAsTheyAre) {
  folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 3 0\nl 1 2\nf 1 2 3\n");
  works({"view", "lines.obj", "--png", "lines.png"});
  EXPECT_GT(bytes("lines.png").size(), 5000u) << "blank";
  REQUIRE_PAGE();
  works({"view", "lines.obj", "-o", "both.html", "--png", "both.png"});
  EXPECT_TRUE(bytes("both.png") == bytes("lines.png"));
  EXPECT_TRUE(exists("both.html"));
  EXPECT_FALSE(exists("lines.html"));
}

}  // namespace program_view_test
