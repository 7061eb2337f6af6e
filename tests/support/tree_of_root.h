// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "quench/samples.h"
#include "quench/tree.h"

/// Trees whose branches are known, without the hierarchy and traits of the library.
namespace quench::testing_trees {

inline double length_of(const std::vector<Vec3>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

/// Strahler numbers and orders of branches whose parents come before them.
inline void number_branches(Tree& tree) {
  std::vector<std::vector<std::uint32_t>> children(tree.branches.size());
  for (std::uint32_t b = 0; b < tree.branches.size(); ++b)
    if (tree.branches[b].parent != kNone) {
      children[tree.branches[b].parent].push_back(b);
      tree.branches[b].order = tree.branches[tree.branches[b].parent].order + 1;
    }
  for (std::size_t b = tree.branches.size(); b-- > 0;) {
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t c : children[b]) numbers.push_back(tree.branches[c].strahler);
    std::sort(numbers.rbegin(), numbers.rend());
    if (!numbers.empty()) tree.branches[b].strahler = numbers[0] + (numbers.size() > 1 && numbers[0] == numbers[1]);
  }
}

/// The true tree of the built-in root: an axis per branch of the sample, cut where others leave it.
inline Tree tree_of_root(const Sample& root) {
  Tree tree;
  std::vector<std::vector<std::pair<std::int32_t, std::uint32_t>>> ends(root.branches.size());  // last point, branch
  for (std::uint32_t a = 0; a < root.branches.size(); ++a) {
    const RootBranch& from = root.branches[a];
    Tree::Axis axis;
    axis.points = from.points;
    axis.radius = from.radius;
    std::uint32_t parent = kNone;
    if (from.parent >= 0) {
      const auto p = static_cast<std::size_t>(from.parent);
      axis.parent = static_cast<std::uint32_t>(from.parent);
      axis.level = tree.axes[p].level + 1;
      const Vec3& fork = root.branches[p].points[static_cast<std::size_t>(from.parent_point)];
      if (axis.points[0] != fork) {
        axis.points.insert(axis.points.begin(), fork);
        axis.radius.insert(axis.radius.begin(), axis.radius.front());
      }
      for (const auto& [last, branch] : ends[p])
        if (last <= from.parent_point) parent = branch;
      tree.axes[p].children.push_back(a);
    }
    std::set<std::int32_t> cuts{static_cast<std::int32_t>(axis.points.size()) - 1};
    for (const RootBranch& other : root.branches)
      if (other.parent == static_cast<std::int32_t>(a) && other.parent_point > 0) {
        const auto shift = static_cast<std::int32_t>(axis.points.size() - from.points.size());
        cuts.insert(other.parent_point + shift);
      }
    std::int32_t begin = 0;
    for (const std::int32_t end : cuts) {
      Tree::Branch branch;
      branch.parent = parent;
      branch.axis = a;
      branch.points.assign(axis.points.begin() + begin, axis.points.begin() + end + 1);
      branch.radius.assign(axis.radius.begin() + begin, axis.radius.begin() + end + 1);
      parent = static_cast<std::uint32_t>(tree.branches.size());
      axis.branches.push_back(parent);
      ends[a].emplace_back(end - static_cast<std::int32_t>(axis.points.size() - from.points.size()), parent);
      tree.branches.push_back(std::move(branch));
      begin = end;
    }
    tree.axes.push_back(std::move(axis));
  }
  tree.plants.emplace_back().root = root.branches[0].points[0];
  number_branches(tree);
  return tree;
}

/// Tables of a few columns of each type.
inline Traits traits_of_root(const Tree& tree) {
  Traits traits;
  std::vector<double> lengths, radii, branch_lengths;
  std::vector<std::int64_t> numbers, parents, levels, branches;
  std::vector<std::string> classes;
  for (const Tree::Axis& axis : tree.axes) {
    numbers.push_back(static_cast<std::int64_t>(numbers.size()));
    parents.push_back(axis.parent == kNone ? -1 : static_cast<std::int64_t>(axis.parent));
    levels.push_back(axis.level);
    lengths.push_back(length_of(axis.points));
    radii.push_back(*std::max_element(axis.radius.begin(), axis.radius.end()));
    classes.push_back(axis.level == 0 ? "stem" : "level " + std::to_string(axis.level));
  }
  for (const Tree::Branch& branch : tree.branches) {
    branches.push_back(static_cast<std::int64_t>(branches.size()));
    branch_lengths.push_back(length_of(branch.points));
  }
  traits.axes = {{{"axis", "", "Number", numbers},
                  {"parent", "", "Axis it leaves; -1: none", parents},
                  {"level", "", "Level", levels},
                  {"class", "", "What it is", classes},
                  {"length", "mm", "Length from where it leaves its parent to its tip", lengths},
                  {"max_radius", "mm", "Largest radius", radii}},
                 lengths.size()};
  traits.branches = {{{"branch", "", "Number", branches}, {"length", "mm", "Length", branch_lengths}},
                     branch_lengths.size()};
  double total = 0;
  for (const double length : lengths) total += length;
  traits.sample = {
      {{"total_length", "mm", "Length of all axes", std::vector<double>{total}},
       {"axes", "", "Number of axes", std::vector<std::int64_t>{static_cast<std::int64_t>(lengths.size())}}},
      1};
  return traits;
}

}  // namespace quench::testing_trees
