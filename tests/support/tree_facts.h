// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "quench/error.h"
#include "quench/graph.h"
#include "quench/tree.h"
#include "temporary_folder.h"

/// What tests of trees in files share: measures of a tree, and those that tests/io/tree/describe_tree.py finds in
/// files.
namespace quench::testing_trees {

using Facts = std::map<std::string, std::string>;

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What the independent readers find in each of the files; nothing without Python.
inline std::map<std::string, Facts> described(const TemporaryFolder& folder, const std::vector<std::string>& names) {
  const auto script = std::filesystem::path(__FILE__).parent_path() / "../io/tree/describe_tree.py";
  std::string command = fmt::format("/usr/bin/python3 -B '{}'", script.string());
  for (const std::string& name : names) command += fmt::format(" '{}'", (folder / name).string());
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string text;
  for (std::array<char, 4096> block; const std::size_t got = std::fread(block.data(), 1, block.size(), pipe);)
    text.append(block.data(), got);
  const int status = pclose(pipe);
  if (WEXITSTATUS(status) == 127) return {};
  EXPECT_EQ(status, 0) << text;
  std::map<std::string, Facts> all;
  std::istringstream lines(text);
  Facts* facts = nullptr;
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(0, line.find(' ')), value = line.substr(line.find(' ') + 1);
    if (name == "file")
      facts = &all[value];
    else if (facts)
      (*facts)[name] = value;
  }
  return all;
}

/// Of one file.
inline Facts described(const TemporaryFolder& folder, const std::string& name) {
  return described(folder, std::vector<std::string>{name})[name];
}

struct Measures {
  std::size_t nodes = 0, tips = 0, forks = 0;
  double length = 0, bridged = 0, moment = 0, frusta = 0;
  double node_frusta = 0;  ///< where every node has one radius: a branch begins with that of its parent
  std::map<std::uint32_t, double> by_level;
};

inline Measures measures_of(const Tree& tree) {
  Measures m;
  m.nodes = tree.plants.size();
  std::vector<int> children(tree.branches.size(), 0), at_root(tree.plants.size(), 0);
  std::vector<double> root_radius(tree.plants.size(), -1);
  for (const Tree::Branch& branch : tree.branches) {
    ++(branch.parent == kNone ? at_root[branch.plant] : children[branch.parent]);
    m.nodes += branch.points.size() - 1;
    if (double& radius = root_radius[branch.plant]; radius < 0)
      radius = tree.plants[branch.plant].soma.value_or(branch.radius[0]);
    const double base = branch.parent == kNone ? root_radius[branch.plant] : tree.branches[branch.parent].radius.back();
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const Vec3 &a = branch.points[i - 1], &b = branch.points[i];
      const double step = (b - a).norm();
      m.length += step;
      if (!branch.bridged.empty() && branch.bridged[i - 1]) m.bridged += step;
      m.moment += step * Vec3(1, 2, 3).dot((a + b) / 2);
      m.frusta += step * (branch.radius[i - 1] + branch.radius[i]) / 2;
      m.node_frusta += step * ((i == 1 ? base : branch.radius[i - 1]) + branch.radius[i]) / 2;
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
inline void expect_sound(const Tree& tree, bool axes = true) {
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
    if (axis.points.size() < course.size()) {  // what joins it to its parent is no part of it
      ASSERT_EQ(tree.branches[axis.branches[0]].bridged.at(0), 1);
      course.erase(course.begin());
    }
    ASSERT_EQ(axis.points, course);
    ASSERT_EQ(axis.radius.size(), axis.points.size());
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

inline void expect_number(const Facts& facts, const std::string& name, double value) {
  ASSERT_TRUE(facts.contains(name)) << name;
  EXPECT_NEAR(std::stod(facts.at(name)), value, 1e-9 * (1 + std::abs(value))) << name;
}

inline void expect_measures(const Facts& facts, const Tree& tree, bool levels, bool nodes) {
  const Measures m = measures_of(tree);
  EXPECT_EQ(facts.at("trees"), std::to_string(tree.plants.size()));
  EXPECT_EQ(facts.at("nodes"), std::to_string(m.nodes));
  EXPECT_EQ(facts.at("tips"), std::to_string(m.tips));
  EXPECT_EQ(facts.at("forks"), std::to_string(m.forks));
  expect_number(facts, "length", m.length);
  expect_number(facts, "moment", m.moment);
  expect_number(facts, "frusta", nodes ? m.node_frusta : m.frusta);
  if (!levels) return;
  for (const auto& [level, length] : m.by_level) expect_number(facts, fmt::format("length_of_level_{}", level), length);
}

/// Writes the tree in every format and has it described.
inline void expect_all_formats(const Tree& tree, const TemporaryFolder& folder) {
  io::write_swc(folder / "a.swc", tree);
  io::write_centerlines(folder / "a.vtp", tree);
  io::write_graphml(folder / "a.graphml", tree);
  std::vector<std::string> names{"a.swc", "a.vtp", "a.graphml"};
  if (!tree.axes.empty()) {
    io::write_rsml(folder / "a.rsml", tree);
    io::write_mtg(folder / "a.mtg", tree);
    names.insert(names.end(), {"a.rsml", "a.mtg"});
  }
  for (const auto& [name, facts] : described(folder, names)) {
    SCOPED_TRACE(name);
    if (facts.empty() && name == "a.vtp") continue;  // no VTK here
    ASSERT_TRUE(facts.contains("length"));
    expect_measures(facts, tree, !tree.axes.empty() && name != "a.swc", name != "a.rsml" && name != "a.graphml");
    if (facts.contains("axes")) {
      EXPECT_EQ(facts.at("axes"), std::to_string(tree.axes.size()));
    }
  }
}

inline Tree read_text(const TemporaryFolder& folder, const std::string& name, const std::string& text,
                      bool* known = nullptr) {
  std::ofstream(folder / name, std::ios::binary) << text;
  return io::read_tree(folder / name, known);
}

inline std::string refusal(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  try {
    read_text(folder, name, text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::input) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "read: " << text.substr(0, 200);
  return "";
}

/// The same branches, axes and plants.
inline void expect_same(const Tree& a, const Tree& b) {
  ASSERT_EQ(a.branches.size(), b.branches.size());
  for (std::size_t i = 0; i < a.branches.size(); ++i) {
    const Tree::Branch &x = a.branches[i], &y = b.branches[i];
    EXPECT_EQ(x.parent, y.parent);
    EXPECT_EQ(x.axis, y.axis);
    EXPECT_EQ(x.plant, y.plant);
    EXPECT_EQ(x.points, y.points);
    ASSERT_EQ(x.radius.size(), y.radius.size());
    for (std::size_t k = 0; k < x.radius.size(); ++k) EXPECT_NEAR(x.radius[k], y.radius[k], 1e-14 * x.radius[k]);
    EXPECT_EQ(x.bridged, y.bridged);
    EXPECT_EQ(x.type, y.type);
  }
  ASSERT_EQ(a.axes.size(), b.axes.size());
  for (std::size_t i = 0; i < a.axes.size(); ++i) {
    EXPECT_EQ(a.axes[i].parent, b.axes[i].parent);
    EXPECT_EQ(a.axes[i].label, b.axes[i].label);
    EXPECT_EQ(a.axes[i].points, b.axes[i].points);
    EXPECT_NEAR(a.axes[i].position, b.axes[i].position, 1e-12 * (1 + a.axes[i].position));
  }
  ASSERT_EQ(a.plants.size(), b.plants.size());
  for (std::size_t i = 0; i < a.plants.size(); ++i) EXPECT_EQ(a.plants[i].root, b.plants[i].root);
  EXPECT_EQ(a.coordinates.units, b.coordinates.units);
}

}  // namespace quench::testing_trees
