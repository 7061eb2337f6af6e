// SPDX-License-Identifier: Apache-2.0
// Trees in files: what is written is read by tree/describe_tree.py, which knows the formats from their specifications.
#include <gtest/gtest.h>

#include <limits>

#include "data.h"
#include "tree_facts.h"

namespace quench {
namespace tree_files_test {

using namespace testing_trees;

Tree::Branch branch(std::uint32_t parent, std::uint32_t axis, std::uint32_t plant, std::vector<Vec3> points,
                    std::vector<double> radius) {
  Tree::Branch b;
  b.parent = parent;
  b.axis = axis;
  b.plant = plant;
  b.points = std::move(points);
  b.radius = std::move(radius);
  return b;
}

/// Two plants. The first: a main axis in two branches, a lateral from its fork, one of that from the tip of the
/// lateral, one from its base, and one from the root node; a gap. The second: a soma with two main axes.
Tree hand_built() {
  Tree tree;
  tree.branches = {
      branch(kNone, 0, 0, {{0, 0, 0}, {0, 0, -1}, {0, 0.1, -2}}, {1, 0.9, 0.8}),
      branch(0, 0, 0, {{0, 0.1, -2}, {0, 0, -3.3}}, {0.8, 0.5}),
      branch(0, 1, 0, {{0, 0.1, -2}, {1, 0, -2}, {2, 0, -2}}, {0.8, 0.2, 0.125}),
      branch(2, 2, 0, {{2, 0, -2}, {3, 1. / 3, -2}}, {0.125, 0.1}),
      branch(0, 3, 0, {{0, 0.1, -2}, {-1, 0, -2}}, {0.8, 0.3}),
      branch(kNone, 4, 0, {{0, 0, 0}, {1, 1, 0}}, {1, 0.25}),
      branch(kNone, 5, 1, {{9, 0, 0}, {9, 0, 5}}, {2, 0.5}),
      branch(kNone, 6, 1, {{9, 0, 0}, {9, 5, 0}}, {2, 0.5}),
  };
  tree.branches[2].bridged = {0, 1};
  tree.branches[2].type = 2;
  tree.branches[1].order = tree.branches[2].order = tree.branches[4].order = tree.branches[3].order = 1;
  tree.branches[0].strahler = 2;
  const auto axis = [&](std::uint32_t parent, std::uint32_t level, std::uint32_t plant,
                        std::vector<std::uint32_t> branches, std::vector<std::uint32_t> children, double position) {
    Tree::Axis a;
    a.parent = parent;
    a.level = level;
    a.plant = plant;
    a.children = std::move(children);
    a.position = position;
    for (const std::uint32_t b : branches) {
      const Tree::Branch& from = tree.branches[b];
      const std::ptrdiff_t skip = a.points.empty() ? 0 : 1;
      a.points.insert(a.points.end(), from.points.begin() + skip, from.points.end());
      a.radius.insert(a.radius.end(), from.radius.begin() + skip, from.radius.end());
    }
    a.branches = std::move(branches);
    tree.axes.push_back(std::move(a));
  };
  const double fork = 1 + Vec3(0, 0.1, -1).norm();
  axis(kNone, 0, 0, {0, 1}, {4, 1}, 0);
  axis(0, 1, 0, {2}, {3, 2}, fork);
  axis(1, 2, 0, {3}, {}, Vec3(1, 0.1, 0).norm() + 1);
  axis(1, 2, 0, {4}, {}, 0);
  axis(0, 1, 0, {5}, {}, 0);
  axis(kNone, 0, 1, {6}, {}, 0);
  axis(kNone, 0, 1, {7}, {}, 0);
  tree.axes[0].label = "a <main> & \"root\"";
  tree.plants = {{.root = {0, 0, 0}, .main_axis = 0, .soma = {}, .label = "maize, 1", .foreign = {}},
                 {.root = {9, 0, 0}, .main_axis = 5, .soma = 2., .label = {}, .foreign = {}}};
  tree.coordinates.units = "mm";
  return tree;
}

TEST(TreeFiles, EveryFormatHoldsTheTree) {
  const TemporaryFolder folder;
  const Tree tree = hand_built();
  expect_sound(tree);
  expect_all_formats(tree, folder);
  const auto swc = described(folder, "a.swc");
  EXPECT_EQ(swc.at("somas"), "1");
  EXPECT_EQ(swc.at("types"), "1:1,2:2,3:9");
  const auto rsml = described(folder, "a.rsml");
  EXPECT_EQ(rsml.at("unit"), "mm");
  EXPECT_EQ(rsml.at("labels"), "a <main> & \"root\"");
  EXPECT_EQ(rsml.at("found"), "bridged:1,diameter:7,length:7,level:7,parent-node:4,swc-type:1");
  const auto mtg = described(folder, "a.mtg");
  EXPECT_EQ(mtg.at("plants"), "2");
  EXPECT_EQ(mtg.at("names"), "maize__1|a__main_____root_");
  EXPECT_EQ(described(folder, "a.graphml").at("kinds"), "fork:1,root:1,soma:1,tip:6,tip_of_axis:1");
  if (Facts vtp = described(folder, "a.vtp"); !vtp.empty()) {
    EXPECT_EQ(vtp.at("branches"), "8");
    EXPECT_EQ(vtp.at("strahler"), "2");
  }
}

TEST(TreeFiles, RsmlIsReadAsItWasWritten) {
  const TemporaryFolder folder;
  io::write_rsml(folder / "a.rsml", hand_built());
  bool known = false;
  const Tree first = io::read_tree(folder / "a.rsml", &known);
  EXPECT_TRUE(known);
  expect_sound(first);
  const Measures m = measures_of(first), made = measures_of(hand_built());
  EXPECT_EQ(m.nodes, made.nodes);
  EXPECT_NEAR(m.length, made.length, 1e-12);
  EXPECT_NEAR(m.bridged, made.bridged, 1e-12);
  EXPECT_EQ(first.axes[0].label, "a <main> & \"root\"");
  EXPECT_EQ(first.plants[0].label, "maize, 1");
  io::write_rsml(folder / "b.rsml", first);
  io::write_rsml(folder / "c.rsml", io::read_tree(folder / "b.rsml"));
  EXPECT_EQ(text_of(folder / "b.rsml"), text_of(folder / "c.rsml"));
  expect_all_formats(first, folder);
}

// As where a thick parent's tube hides the beginning.
TEST(TreeFiles, CoursesMayBeginLaterThanTheirBranches) {
  const TemporaryFolder folder;
  Tree tree = hand_built();
  tree.axes[1].points = {{0, 0, -1}, {2, 0, -2}};
  tree.axes[1].radius = {0.2, 0.125};
  tree.axes[1].position = 1.01;
  io::write_rsml(folder / "a.rsml", tree);
  described(folder, "a.rsml");  // samples are as many as points
  const Tree again = io::read_tree(folder / "a.rsml");
  EXPECT_EQ(again.axes[1].points, (std::vector<Vec3>{{0, 0, -1}, {0.4, 0, -1.2}, {2, 0, -2}}));  // a lateral is joined
  EXPECT_EQ(again.axes[1].position, 1);
  EXPECT_NEAR(measures_of(again).bridged, Vec3(2, 0, -1).norm() + Vec3(0.4, -0.1, 0.8).norm(), 1e-12);
  const std::string text = text_of(folder / "a.rsml");
  const std::size_t root = text.find("<root id=\"1\">"), parent = text.find("<parent-node", root);
  EXPECT_EQ(text.substr(parent, 24), "<parent-node value=\"2\" /");
}

TEST(TreeFiles, ALaterSiblingMayBearAnAxis) {
  const TemporaryFolder folder;
  Tree tree = hand_built();
  std::swap(tree.axes[1], tree.axes[2]);
  tree.branches[2].axis = 2;
  tree.branches[3].axis = 1;
  tree.axes[1].parent = 0;
  tree.axes[1].level = 1;
  tree.axes[3].parent = 2;
  io::write_mtg(folder / "a.mtg", tree);
  EXPECT_EQ(described(folder, "a.mtg").at("nodes"), std::to_string(measures_of(tree).nodes));
}

TEST(TreeFiles, SwcIsReadAsItWasWritten) {
  const TemporaryFolder folder;
  io::write_swc(folder / "a.swc", hand_built(), 2);
  bool known = true;
  const Tree tree = io::read_tree(folder / "a.swc", &known);
  EXPECT_FALSE(known);
  expect_sound(tree, false);
  const Measures m = measures_of(tree), made = measures_of(hand_built());
  EXPECT_EQ(m.nodes, made.nodes);
  EXPECT_EQ(m.tips, made.tips);
  EXPECT_EQ(m.forks, made.forks);
  EXPECT_NEAR(m.length, made.length, 1e-12);
  EXPECT_NEAR(m.frusta, made.frusta, 1e-12);
  ASSERT_EQ(tree.plants.size(), 2u);
  EXPECT_FALSE(tree.plants[0].soma);
  EXPECT_EQ(tree.plants[1].soma, 2.);
  io::write_swc(folder / "b.swc", tree);
  const Tree again = io::read_tree(folder / "b.swc");
  expect_same(tree, again);
  for (const int type : {0, 256, -1}) EXPECT_THROW(io::write_swc(folder / "c.swc", tree, type), Error);
  EXPECT_THROW(io::write_rsml(folder / "c.rsml", tree), Error);  // it has no axes
  EXPECT_THROW(io::write_mtg(folder / "c.mtg", tree), Error);
}

TEST(TreeFiles, TraitsOfAxesAreProperties) {
  const TemporaryFolder folder;
  const Tree tree = hand_built();
  Table table;
  table.rows = tree.axes.size();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  table.columns = {{"mean_radius", "mm", "", std::vector<double>{1, nan, 0.1, 2, 3, 4, 5}},
                   {"children", "", "", std::vector<std::int64_t>{2, 2, 0, 0, 0, 0, 0}},
                   {"class of it", "", "", std::vector<std::string>{"main", "<a>", "", "d", "e", "f", "g"}}};
  io::write_rsml(folder / "a.rsml", tree, &table);
  const auto facts = described(folder, "a.rsml");
  EXPECT_NE(facts.at("found").find("children:7,class_of_it:6"), std::string::npos) << facts.at("found");
  EXPECT_NE(facts.at("found").find("mean_radius:6"), std::string::npos);
  table.rows = 1;
  EXPECT_THROW(io::write_rsml(folder / "b.rsml", tree, &table), Error);
}

TEST(TreeFiles, LastModifiedIsThatOfReproducibleBuilds) {
  const TemporaryFolder folder;
  setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  io::write_rsml(folder / "a.rsml", hand_built());
  unsetenv("SOURCE_DATE_EPOCH");
  io::write_rsml(folder / "b.rsml", hand_built());
  EXPECT_EQ(described(folder, "a.rsml").at("last_modified"), "2023-11-14T22:13:20");
  EXPECT_EQ(described(folder, "b.rsml").at("last_modified"), "none");
}

TEST(TreeFiles, TablesAreCsv) {
  const TemporaryFolder folder;
  Table table;
  table.rows = 2;
  table.columns = {{"length", "mm", "", std::vector<double>{0.1, std::numeric_limits<double>::quiet_NaN()}},
                   {"of, what", "", "", std::vector<std::string>{"a \"b\"", "c,d"}},
                   {"axis", "", "", std::vector<std::int64_t>{-1, 7}},
                   {"ratio", "", "", std::vector<double>{1e300, std::numeric_limits<double>::infinity()}}};
  io::write_table(folder / "t.csv", table);
  EXPECT_EQ(text_of(folder / "t.csv"),
            "length [mm],\"of, what\",axis,ratio\n0.1,\"a \"\"b\"\"\",-1,1e+300\n,\"c,d\",7,inf\n");
}

TEST(TreeData, FilesHoldWhatTheirTablesSay) {
  REQUIRE_DATA("trees/bean-basal.rsml");
  const TemporaryFolder folder;
  struct Neuron {
    const char* file;
    std::size_t nodes, tips, forks;
    double length, thinnest, thickest;
    bool soma;
  };
  for (const Neuron& n : {Neuron{"trees/neuron_1734350788.swc", 4465, 618, 599, 266476.9, 10, 375, false},
                          Neuron{"trees/ds_1_cell_390.swc", 1022, 76, 69, 480.619, 0.05, 3.05, true},
                          Neuron{"trees/neurom_test_morph.swc", 29, 14, 13, 1610.206, 1.5, 6, true}}) {
    SCOPED_TRACE(n.file);
    const Tree tree = io::read_tree(data_file(n.file));
    expect_sound(tree, false);
    const Measures m = measures_of(tree);
    EXPECT_EQ(tree.plants.size(), 1u);
    EXPECT_EQ(m.nodes, n.nodes);
    EXPECT_EQ(m.tips, n.tips);
    EXPECT_EQ(m.forks, n.forks);
    EXPECT_NEAR(m.length, n.length, 1e-6 * n.length);
    EXPECT_EQ(tree.plants[0].soma.has_value(), n.soma);
    double low = 1e9, high = 0;
    for (const Tree::Branch& b : tree.branches)
      for (const double radius : b.radius) {
        low = std::min(low, radius);
        high = std::max(high, radius);
      }
    EXPECT_EQ(low, n.thinnest);
    EXPECT_EQ(high, n.thickest);
    expect_all_formats(with_hierarchy(tree, {}), folder);
  }
  struct Roots {
    const char* file;
    std::size_t axes;
    std::uint32_t depth;
    double length;
    const char* unit;
    bool flat, thick;
  };
  // Of the 556 roots of anagallis five are a single point on their parents, and no axes.
  for (const Roots& r : {Roots{"trees/anagallis.rsml", 551, 4, 281.0049, "", false, true},
                         Roots{"trees/arabidopsis-simple_with_diameter.rsml", 5, 3, 1713.530, "pixel", true, true},
                         Roots{"trees/bean-basal.rsml", 15, 3, 2846.280, "pixel", true, true},
                         Roots{"trees/cplantbox_Faba_day10_reconstructed.rsml", 112, 4, 304.590, "cm", false, true},
                         Roots{"trees/cplantbox_B-23_Fichtl.rsml", 123, 4, 1239.773, "cm", false, true}}) {
    SCOPED_TRACE(r.file);
    const Tree tree = io::read_tree(data_file(r.file));
    expect_sound(tree);
    const Measures m = measures_of(tree);
    EXPECT_EQ(tree.plants.size(), 1u);
    EXPECT_EQ(tree.axes.size(), r.axes);
    EXPECT_EQ(m.by_level.size(), r.depth);
    EXPECT_NEAR(m.length - m.bridged, r.length, 2e-6 * r.length);
    EXPECT_NEAR(std::get<std::vector<double>>(traits_of(tree).sample.find("total_length")->values)[0], r.length,
                2e-6 * r.length);
    EXPECT_EQ(tree.coordinates.units, r.unit);
    EXPECT_EQ(tree.coordinates.y_down, r.flat);
    EXPECT_EQ(m.frusta > 0, r.thick);
    expect_all_formats(tree, folder);
    io::write_rsml(folder / "again.rsml", io::read_tree(folder / "a.rsml"));
    EXPECT_TRUE(text_of(folder / "again.rsml") == text_of(folder / "a.rsml"));
  }
}

}  // namespace tree_files_test
}  // namespace quench
