// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "program.h"
#include "program_arrays.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "quench/tree.h"

// `quench tree`.

using namespace quench::testing_program;
using Json = nlohmann::json;

namespace program_tree_test {

const std::vector<std::string> kFiles{"tree.swc",        "tree.rsml",  "tree.mtg",     "tree.graphml",
                                      "centerlines.vtp", "axes.csv",   "branches.csv", "traits.csv",
                                      "sholl.csv",       "depths.csv", "report.json"};

/// A table of a CSV file: its header and rows.
struct Csv {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;

  explicit Csv(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      (header.empty() ? header : rows.emplace_back()) = cells;
    }
  }
  /// The cells of the column of this name, whatever its unit.
  std::vector<std::string> column(const std::string& name) const {
    for (std::size_t c = 0; c < header.size(); ++c)
      if (header[c] == name || header[c].starts_with(name + " [")) {
        std::vector<std::string> cells;
        for (const auto& row : rows) cells.push_back(c < row.size() ? row[c] : "");
        return cells;
      }
    ADD_FAILURE() << "no column " << name;
    return {};
  }
};

class TreeProgram : public ProgramTest {
 protected:
  /// What is in a box of 40 x 14 x 60 voxels.
  void make_volume(const std::string& name, const std::function<int(int, int, int)>& value) {
    std::string samples;
    for (int z = 0; z < 60; ++z)
      for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 40; ++x) samples += static_cast<char>(value(x, y, z));
    folder.write(name, npy(40, 14, 60, samples));
  }
  /// A root along z, 7 thick, with a lateral, 3 thick, at z 40 .. 42.
  static bool in_root(int x, int y, int z) { return x >= 8 && x < 15 && y >= 3 && y < 10 && z >= 2 && z < 58; }
  static bool in_lateral(int x, int y, int z) { return x >= 12 && x < 37 && y >= 5 && y < 8 && z >= 40 && z < 43; }
  static bool in_plant(int x, int y, int z) { return in_root(x, y, z) || in_lateral(x, y, z); }
  void make_plant() { make_volume("plant.npy", in_plant); }

  Outcome tree(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "tree");
    return works(arguments);
  }
  double sum_of(const std::string& file, const std::string& column) const {
    double sum = 0;
    for (const std::string& cell : Csv(bytes(file)).column(column)) sum += std::stod(cell);
    return sum;
  }
  Json report(const std::string& dir) const { return Json::parse(bytes(dir + "/report.json")); }
  quench::Topology topology_of(const std::string& name) const {
    return topology(foreground(quench::io::read_volume(folder / name), {}));
  }
};

using Betti = std::array<std::int64_t, 3>;

TEST_F(TreeProgram, HelpNamesItsOptions) {
  const auto help = works({"tree", "--help"});
  for (const char* part :
       {"Example:\n  quench tree ", "--kind", "--root", "--plants", "--down", "--repair", "--reach", "--axes", "--soma",
        "--swc-type", "--columns", "--sholl-step", "--threshold", "--theta1", "--no-view", "--no-picture", "--shape"})
    EXPECT_TRUE(has(help.out, part)) << part;
  EXPECT_FALSE(has(help.out, "--theta2"));
}

TEST_F(TreeProgram, AShapeBecomesATree) {
  make_plant();
  const auto said = tree({"plant.npy", "-o", "out"});
  for (const std::string& file : kFiles) EXPECT_TRUE(exists("out/" + file)) << file;
  EXPECT_TRUE(exists("out/edits.csv") && exists("out/edited.nrrd") && exists("out/picture.png"));
  const Csv axes(bytes("out/axes.csv"));
  EXPECT_EQ(axes.column("level"), (std::vector<std::string>{"0", "1"}));
  const Json found = report("out");
  for (const char* section : {"input", "parameters", "shape", "core", "skeleton", "repair", "tree", "traits"})
    EXPECT_TRUE(found.contains(section)) << section;
  EXPECT_EQ(found["tree"]["axes_by_level"], Json({1, 1}));
  EXPECT_EQ(found["parameters"]["kind"], "root");
  EXPECT_EQ(found["repair"]["edited_shape"]["betti"], Json({1, 0, 0}));
  EXPECT_EQ(topology_of("out/edited.nrrd").betti, (Betti{1, 0, 0}));
  // 56 and 25 voxels, less about a radius at each tip and what is inside of the root.
  const double length = found["tree"]["length"];
  EXPECT_GT(length, 60);
  EXPECT_LT(length, 80);
  EXPECT_EQ(found["tree"]["down"], Json({0.0, 0.0, 1.0}));  // the thin lateral is above the middle of the thick root
  EXPECT_TRUE(has(said.err, "repair: nothing was to be done")) << said.err;
  EXPECT_TRUE(has(said.err, "2 axes (1 of level 0, 1 of level 1)")) << said.err;
}

TEST_F(TreeProgram, LabelsAreNoGreyValues) {
  make_volume("labels.npy", [](int x, int y, int z) {
    return in_root(x, y, z) ? 3 : in_lateral(x, y, z) ? 1 : y == 0 ? 2 : 0;
  });
  refuses(2, {"'labels.npy' holds the labels 0, 1, 2, 3: give the one of the tree as --label K"},
          {"tree", "labels.npy", "-o", "out"});
  EXPECT_FALSE(exists("out"));
  tree({"labels.npy", "-o", "out", "--label", "3", "--no-view", "--no-picture"});
  const std::string info = works({"info", "labels.npy"}).out;
  EXPECT_TRUE(has(info, "these are labels (0, 1, 2, 3); choose a shape with --label")) << info;
  EXPECT_FALSE(has(info, "thresholds:"));
}

TEST_F(TreeProgram, RefusesRootNodesFarAwayAndFoldersOfResults) {
  make_plant();
  refuses(2, {"--root '9999,9999,9999' is 1.7", "away from the tree, which reaches from"},
          {"tree", "plant.npy", "-o", "out", "--root", "9999,9999,9999", "--quiet"});
  tree({"plant.npy", "-o", "out", "--no-view", "--no-picture"});
  refuses(2, {"'out' is a folder of results; give 'out/tree.swc'"}, {"tree", "out", "-o", "more"});
  refuses(2, {"--root '0,0,-500' is"}, {"tree", "out/tree.swc", "-o", "more", "--root", "0,0,-500"});
}

TEST_F(TreeProgram, WhatAnEarlierRunLeftGoes) {
  make_plant();
  tree({"plant.npy", "-o", "out"});
  EXPECT_TRUE(exists("out/edits.csv") && exists("out/edited.nrrd") && exists("out/picture.png"));
  folder.write("out/notes.txt", "mine");
  folder.write("other.swc", "1 2 0 0 0 1 -1\n2 2 0 0 -5 1 1\n");
  tree({"other.swc", "-o", "out", "--overwrite", "--no-view", "--no-picture"});
  for (const char* file : {"edits.csv", "edited.nrrd", "view.html", "picture.png"})
    EXPECT_FALSE(exists("out/" + std::string(file))) << file;
  EXPECT_TRUE(exists("out/notes.txt") && exists("out/tree.swc"));
}

TEST_F(TreeProgram, SaysWhatIsNoTree) {
  make_volume("block.npy", [](int x, int y, int z) { return x > 1 && x < 30 && y > 1 && y < 10 && z > 1 && z < 50; });
  EXPECT_TRUE(has(tree({"block.npy", "-o", "block", "--no-view", "--no-picture"}).err,
                  "note: this does not look like a tree: the shape fills 100 % of its box"));
  make_plant();
  EXPECT_FALSE(has(tree({"plant.npy", "-o", "plant", "--no-view", "--no-picture"}).err, "look like a tree"));
}

TEST_F(TreeProgram, OptionsOfTheTree) {
  make_plant();
  tree({"plant.npy", "-o", "a", "--down", "-z", "--root", "11,6,2", "--columns", "toporoot", "--no-picture",
        "--no-view", "--swc-type", "custom"});
  const Json found = report("a");
  EXPECT_EQ(found["tree"]["down"], Json({0.0, 0.0, -1.0}));
  EXPECT_LT(found["tree"]["plants"][0]["root"][2].get<double>(), 8);
  EXPECT_TRUE(bytes("a/axes.csv").starts_with("Index,Level,Length,Geodesic depth,Average Radius,"));
  EXPECT_FALSE(exists("a/picture.png") || exists("a/view.html"));
  std::istringstream rows(bytes("a/tree.swc"));
  for (std::string row; std::getline(rows, row);)
    if (!row.starts_with('#')) {
      EXPECT_TRUE(has(row, " 5 ")) << row;
    }
}

TEST_F(TreeProgram, ATreeThatWasWrittenHasTheSameTraits) {
  make_plant();
  tree({"plant.npy", "-o", "a", "--no-picture", "--no-view"});
  tree({"a/tree.rsml", "-o", "b", "--no-picture", "--no-view", "--sholl-step", "10%"});
  const Json made = report("a"), again = report("b");
  for (const char* name : {"axes", "total_length", "length_level_1", "mean_radius", "volume", "surface", "depth"})
    EXPECT_NEAR(made["traits"][name].get<double>(), again["traits"][name].get<double>(),
                1e-9 * made["traits"][name].get<double>())
        << name;
  EXPECT_EQ(made["tree"]["length"], made["traits"]["total_length"]);
  EXPECT_EQ(again["tree"]["length"], again["traits"]["total_length"]);
}

TEST_F(TreeProgram, ABallThatHoldsTheTreeIsNoSoma) {
  folder.write("a.swc", "1 3 0 0 0 10 -1\n2 3 0 0 -1 1 1\n3 3 0 0 -2 1 2\n");
  const auto said = tree({"a.swc", "-o", "out", "--soma", "thickest"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(has(said.err, "is no soma")) << said.err;
  EXPECT_EQ(report("out")["tree"]["length"], 2.0);
}

TEST_F(TreeProgram, AGapIsBridged) {
  make_volume("gap.npy", [](int x, int y, int z) { return in_plant(x, y, z) && !(x >= 22 && x < 25); });
  const auto said = tree({"gap.npy", "-o", "out", "--no-picture", "--no-view"});
  EXPECT_TRUE(has(said.err, "curves: 2 components, 0 loops")) << said.err;
  EXPECT_TRUE(has(said.err, "repair: 1 bridge")) << said.err;
  const Csv edits(bytes("out/edits.csv"));
  EXPECT_EQ(edits.column("kind"), std::vector<std::string>{"bridge"});
  EXPECT_EQ(topology_of("out/edited.nrrd").betti, (Betti{1, 0, 0}));
  EXPECT_EQ(report("out")["tree"]["axes"], 2);
  EXPECT_EQ(report("out")["repair"]["bridge"]["count"], 1);
  // Every part a tree of its own.
  tree({"gap.npy", "-o", "two", "--plants", "0", "--no-picture", "--no-view"});
  EXPECT_EQ(report("two")["tree"]["plants"].size(), 2u);
  EXPECT_EQ(topology_of("two/edited.nrrd").betti, (Betti{2, 0, 0}));
}

TEST_F(TreeProgram, ALoopIsCut) {
  const auto in_ring = [](int x, int y, int z) {
    const bool arm = x >= 33 && x < 36 && y >= 5 && y < 8 && z >= 20 && z < 43;
    const bool back = x >= 12 && x < 36 && y >= 5 && y < 8 && z >= 20 && z < 23;
    return in_plant(x, y, z) || arm || back;
  };
  make_volume("loop.npy", in_ring);
  const auto said = tree({"loop.npy", "-o", "out", "--no-picture", "--no-view"});
  EXPECT_TRUE(has(said.err, "1 loop,")) << said.err;
  EXPECT_TRUE(has(said.err, "1 cut")) << said.err;
  EXPECT_EQ(topology_of("out/edited.nrrd").betti, (Betti{1, 0, 0}));
  refuses(2, {"loop", "--repair"}, {"tree", "loop.npy", "-o", "off", "--repair", "off", "--quiet"});
}

TEST_F(TreeProgram, CavitiesAreFilled) {
  make_volume("hollow.npy", [](int x, int y, int z) { return in_plant(x, y, z) && !(x == 11 && y == 6 && z == 12); });
  tree({"hollow.npy", "-o", "out", "--no-picture", "--no-view"});
  EXPECT_EQ(report("out")["shape"]["betti"], Json({1, 0, 0}));
  EXPECT_EQ(report("out")["tree"]["axes"], 2);
}

TEST_F(TreeProgram, OfAGreyVolumeTheProgramChoosesAThreshold) {
  make_volume("grey.npy",
              [](int x, int y, int z) { return in_plant(x, y, z) ? 90 + (x + y + z) % 5 : 10 + (x * y + z) % 7; });
  const auto said = tree({"grey.npy", "-o", "out", "--no-picture", "--no-view"});
  EXPECT_TRUE(has(said.err, "threshold ")) << said.err;
  EXPECT_EQ(report("out")["tree"]["axes"], 2);
  const double threshold = report("out")["parameters"]["threshold"];
  EXPECT_GT(threshold, 16);
  EXPECT_LE(threshold, 90);
}

TEST_F(TreeProgram, ResultsAreTreesToo) {
  make_plant();
  works({"run", "plant.npy", "-o", "run", "--theta2", "inf", "--theta1", "1r", "--no-view", "--no-picture"});
  tree({"plant.npy", "-o", "shape", "--no-picture", "--no-view"});
  for (const char* result : {"core", "skeleton"}) {
    const std::string out = fmt::format("of_{}", result), file = fmt::format("run/{}.vtp", result);
    tree({file, "-o", out, "--no-picture", "--no-view"});
    EXPECT_FALSE(exists(out + "/edited.nrrd"));
    EXPECT_EQ(report(out)["tree"]["axes"], 2);
    const double of_shape = report("shape")["tree"]["length"];
    tree({file, "--shape", "plant.npy", "-o", out + "_in_shape", "--no-picture", "--no-view"});
    if (file == "run/core.vtp") {  // the same curves; where the shape is not known they are smoothed less
      EXPECT_NEAR(report(out + "_in_shape")["tree"]["length"].get<double>(), of_shape, 1e-9);
      EXPECT_NEAR(report(out)["tree"]["length"].get<double>(), of_shape, 1);
    } else {
      EXPECT_NEAR(report(out)["tree"]["length"].get<double>(), of_shape, 0.5);
    }
    EXPECT_EQ(topology_of(out + "_in_shape/edited.nrrd").betti, (Betti{1, 0, 0}));
  }
}

TEST_F(TreeProgram, ATreeFromAFileIsMeasuredOnly) {
  make_plant();
  tree({"plant.npy", "-o", "out", "--no-picture", "--no-view"});
  for (const char* name : {"tree.swc", "tree.rsml"}) {
    const std::string again = std::string("again_") + (name + 5);
    const auto said = tree({std::string("out/") + name, "-o", again, "--theta1", "2r", "--no-picture", "--no-view"});
    EXPECT_TRUE(has(said.err, "note: --theta1 is ignored")) << said.err;
    for (const std::string& file : kFiles) EXPECT_TRUE(exists(again + "/" + file)) << file;
    EXPECT_FALSE(exists(again + "/edits.csv") || exists(again + "/edited.nrrd"));
    EXPECT_EQ(Csv(bytes(again + "/axes.csv")).column("level"), (std::vector<std::string>{"0", "1"}));
    // SWC has the branches of the tree, RSML its axes, which are straight through the tubes they leave.
    const double length = sum_of(name[5] == 's' ? "out/branches.csv" : "out/axes.csv", "length");
    EXPECT_NEAR(report(again)["tree"]["length"].get<double>(), length, 0.001);
  }
}

TEST_F(TreeProgram, ResultsDoNotDependOnThreads) {
  make_plant();
  tree({"plant.npy", "-o", "one", "--threads", "1", "--no-view"});
  tree({"plant.npy", "-o", "two", "--threads", "2", "--no-view"});
  for (const std::string& file : kFiles)
    if (file != "report.json") {
      EXPECT_EQ(bytes("one/" + file), bytes("two/" + file)) << file;
    }
  EXPECT_EQ(bytes("one/edited.nrrd"), bytes("two/edited.nrrd"));
  EXPECT_EQ(bytes("one/picture.png"), bytes("two/picture.png"));
}

TEST_F(TreeProgram, RefusesWhatIsNoTree) {
  make_plant();
  folder.write("image.pgm", "P2\n4 4\n1\n0 0 0 0\n0 1 1 0\n0 1 1 0\n0 0 0 0\n");
  folder.write("empty.swc", "# nothing\n");
  make_volume("empty.npy", [](int, int, int) { return 0; });
  works({"run", "plant.npy", "-o", "sheets", "--theta2", "0", "--no-view", "--no-picture"});
  refuses(2, {"'image.pgm' is of the plane", "quench run image.pgm"}, {"tree", "image.pgm", "-o", "o"});
  refuses(2, {"--plants", "--root"}, {"tree", "plant.npy", "-o", "o", "--plants", "2", "--root", "1,2,3"});
  refuses(2, {"--root '1,2' is not a point"}, {"tree", "plant.npy", "-o", "o", "--root", "1,2"});
  refuses(2, {"--down '0,0,0' is not a direction"}, {"tree", "plant.npy", "-o", "o", "--down", "0,0,0"});
  refuses(2, {"--kind"}, {"tree", "plant.npy", "-o", "o", "--kind", "oak"});
  refuses(2, {"--shape", "a shape itself"}, {"tree", "plant.npy", "-o", "o", "--shape", "plant.npy"});
  refuses(2, {"a skeleton with sheets"}, {"tree", "sheets/skeleton.vtp", "-o", "o"});
  refuses(3, {"empty.npy"}, {"tree", "empty.npy", "-o", "o"});
  refuses(3, {"empty.swc"}, {"tree", "empty.swc", "-o", "o"});
  refuses(1, {"'absent.nrrd' does not exist"}, {"tree", "absent.nrrd", "-o", "o"});
  std::filesystem::create_directory(folder / "o");
  folder.write("o/tree.swc", "mine");
  refuses(2, {"o/tree.swc' exists", "--overwrite"}, {"tree", "plant.npy", "-o", "o"});
}

TEST_F(TreeProgram, SeveralRootNodesMakeSeveralPlants) {
  const auto in_other = [](int x, int y, int z) { return x >= 28 && x < 34 && y >= 4 && y < 10 && z >= 2 && z < 58; };
  make_volume("two.npy", [&](int x, int y, int z) {  // the lateral of one touches the other
    return in_plant(x, y, z) || in_other(x, y, z);
  });
  tree({"two.npy", "-o", "out", "--root", "11,6,56", "--root", "31,7,56", "--no-picture", "--no-view"});
  const Json found = report("out");
  EXPECT_EQ(found["tree"]["plants"].size(), 2u);
  EXPECT_EQ(found["repair"]["edited_shape"]["betti"], Json({2, 0, 0}));
  EXPECT_EQ(topology_of("out/edited.nrrd").betti, (Betti{2, 0, 0}));
}

}  // namespace program_tree_test
