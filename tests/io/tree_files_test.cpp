// SPDX-License-Identifier: Apache-2.0
// Trees in files: what is written is read by tree/describe_tree.py, which knows the formats from their specifications.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "data.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "quench/tree.h"
#include "temporary_folder.h"

namespace quench {
namespace {

using Facts = std::map<std::string, std::string>;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What the independent readers find; nothing where they cannot run here.
std::optional<Facts> described(const std::filesystem::path& file) {
  const auto script = std::filesystem::path(__FILE__).parent_path() / "tree" / "describe_tree.py";
  const std::string command = fmt::format("/usr/bin/python3 -B '{}' '{}' 2>&1", script.string(), file.string());
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  for (std::array<char, 4096> block; const std::size_t got = std::fread(block.data(), 1, block.size(), pipe);)
    text.append(block.data(), got);
  const int status = pclose(pipe);
  if (WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127) return {};
  EXPECT_EQ(status, 0) << text;
  Facts facts;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    facts[line.substr(0, line.find(' '))] = line.substr(line.find(' ') + 1);
  return facts;
}

struct Measures {
  std::size_t nodes = 0, tips = 0, forks = 0;
  double length = 0, bridged = 0, moment = 0, frusta = 0;
  std::map<std::uint32_t, double> by_level;
};

Measures measures_of(const Tree& tree) {
  Measures m;
  m.nodes = tree.plants.size();
  std::vector<int> children(tree.branches.size(), 0), at_root(tree.plants.size(), 0);
  for (const Tree::Branch& branch : tree.branches) {
    ++(branch.parent == kNone ? at_root[branch.plant] : children[branch.parent]);
    m.nodes += branch.points.size() - 1;
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const Vec3 &a = branch.points[i - 1], &b = branch.points[i];
      const double step = (b - a).norm();
      m.length += step;
      if (!branch.bridged.empty() && branch.bridged[i - 1]) m.bridged += step;
      m.moment += step * Vec3(1, 2, 3).dot((a + b) / 2);
      m.frusta += step * (branch.radius[i - 1] + branch.radius[i]) / 2;
      if (!tree.axes.empty()) m.by_level[tree.axes[branch.axis].level] += step;
    }
  }
  for (const int count : children) {
    m.tips += count == 0;
    m.forks += count > 1;
  }
  for (const int count : at_root) m.forks += count > 1;
  return m;
}

/// Every relation that Tree promises.
void expect_sound(const Tree& tree, bool axes = true) {
  ASSERT_FALSE(tree.branches.empty());
  for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
    const Tree::Branch& branch = tree.branches[b];
    ASSERT_TRUE(branch.parent == kNone || branch.parent < b);
    ASSERT_LT(branch.plant, tree.plants.size());
    ASSERT_GE(branch.points.size(), 2u);
    ASSERT_EQ(branch.radius.size(), branch.points.size());
    ASSERT_TRUE(branch.bridged.empty() || branch.bridged.size() == branch.points.size() - 1);
    ASSERT_EQ(branch.points[0],
              branch.parent == kNone ? tree.plants[branch.plant].root : tree.branches[branch.parent].points.back());
    for (const Vec3& p : branch.points) ASSERT_TRUE(p.allFinite());
    for (const double radius : branch.radius) ASSERT_TRUE(radius >= 0 && std::isfinite(radius));
  }
  if (!axes) {
    EXPECT_TRUE(tree.axes.empty());
    return;
  }
  std::vector<int> times(tree.branches.size(), 0);
  for (std::uint32_t a = 0; a < tree.axes.size(); ++a) {
    const Tree::Axis& axis = tree.axes[a];
    ASSERT_TRUE(axis.parent == kNone || axis.parent < a);
    ASSERT_EQ(axis.level, axis.parent == kNone ? 0 : tree.axes[axis.parent].level + 1);
    std::vector<Vec3> course{tree.branches[axis.branches.at(0)].points[0]};
    for (const std::uint32_t b : axis.branches) {
      ++times[b];
      ASSERT_EQ(tree.branches[b].axis, a);
      ASSERT_EQ(tree.branches[b].points[0], course.back());
      course.insert(course.end(), tree.branches[b].points.begin() + 1, tree.branches[b].points.end());
    }
    ASSERT_EQ(axis.points, course);
    double before = 0;
    for (const std::uint32_t child : axis.children) {
      ASSERT_EQ(tree.axes[child].parent, a);
      ASSERT_GE(tree.axes[child].position, before);
      before = tree.axes[child].position;
    }
  }
  for (const int t : times) ASSERT_EQ(t, 1);
  for (const Tree::Plant& plant : tree.plants) ASSERT_EQ(tree.axes[plant.main_axis].parent, kNone);
}

void expect_number(const Facts& facts, const std::string& name, double value) {
  ASSERT_TRUE(facts.contains(name)) << name;
  EXPECT_NEAR(std::stod(facts.at(name)), value, 1e-9 * (1 + std::abs(value))) << name;
}

void expect_measures(const Facts& facts, const Tree& tree, bool levels) {
  const Measures m = measures_of(tree);
  EXPECT_EQ(facts.at("trees"), std::to_string(tree.plants.size()));
  EXPECT_EQ(facts.at("nodes"), std::to_string(m.nodes));
  EXPECT_EQ(facts.at("tips"), std::to_string(m.tips));
  EXPECT_EQ(facts.at("forks"), std::to_string(m.forks));
  expect_number(facts, "length", m.length);
  expect_number(facts, "moment", m.moment);
  expect_number(facts, "frusta", m.frusta);
  if (!levels) return;
  for (const auto& [level, length] : m.by_level) expect_number(facts, fmt::format("length_of_level_{}", level), length);
}

/// Writes the tree in every format and has it described.
void expect_all_formats(const Tree& tree, const TemporaryFolder& folder) {
  io::write_swc(folder / "a.swc", tree);
  io::write_centerlines(folder / "a.vtp", tree);
  io::write_graphml(folder / "a.graphml", tree);
  std::vector<const char*> names{"a.swc", "a.vtp", "a.graphml"};
  if (!tree.axes.empty()) {
    io::write_rsml(folder / "a.rsml", tree);
    io::write_mtg(folder / "a.mtg", tree);
    names.insert(names.end(), {"a.rsml", "a.mtg"});
  }
  for (const char* name : names) {
    SCOPED_TRACE(name);
    const std::optional<Facts> facts = described(folder / name);
    if (!facts) continue;
    ASSERT_TRUE(facts->contains("length"));
    expect_measures(*facts, tree, !tree.axes.empty() && std::string(name) != "a.swc");
    if (facts->contains("axes")) EXPECT_EQ(facts->at("axes"), std::to_string(tree.axes.size()));
  }
}

Tree read_text(const TemporaryFolder& folder, const std::string& name, const std::string& text, bool* known = nullptr) {
  std::ofstream(folder / name, std::ios::binary) << text;
  return io::read_tree(folder / name, known);
}

std::string refusal(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  try {
    read_text(folder, name, text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::input) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "read: " << text.substr(0, 200);
  return "";
}

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
  const auto swc = described(folder / "a.swc");
  EXPECT_EQ(swc->at("somas"), "1");
  EXPECT_EQ(swc->at("types"), "1:1,2:2,3:9");
  const auto rsml = described(folder / "a.rsml");
  EXPECT_EQ(rsml->at("unit"), "mm");
  EXPECT_EQ(rsml->at("labels"), "a <main> & \"root\"");
  EXPECT_EQ(rsml->at("found"), "bridged:1,diameter:7,length:7,level:7,parent-node:4,swc-type:1");
  const auto mtg = described(folder / "a.mtg");
  EXPECT_EQ(mtg->at("plants"), "2");
  EXPECT_EQ(mtg->at("names"), "maize__1|a__main_____root_");
  EXPECT_EQ(described(folder / "a.graphml")->at("kinds"), "fork:1,root:1,soma:1,tip:6,tip_of_axis:1");
  if (const auto vtp = described(folder / "a.vtp")) {
    EXPECT_EQ(vtp->at("branches"), "8");
    EXPECT_EQ(vtp->at("strahler"), "2");
  }
}

}  // namespace
}  // namespace quench
