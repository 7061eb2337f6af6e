// SPDX-License-Identifier: Apache-2.0
#include "io/tree/tree_samples.h"

#include <fmt/format.h>

#include <algorithm>

#include "quench/error.h"

namespace quench::io {
namespace {

/// The type of most points; ties: the least. The point a branch begins at is its parent's.
int type_of_most(std::vector<int>& types) {
  std::sort(types.begin(), types.end());
  int best = 0;
  std::ptrdiff_t most = 0;
  for (auto begin = types.begin(); begin != types.end();) {
    const auto end = std::upper_bound(begin, types.end(), *begin);
    if (end - begin > most) {
      most = end - begin;
      best = *begin;
    }
    begin = end;
  }
  return best;
}

}  // namespace

Tree tree_of_samples(std::span<const TreeSample> samples, std::vector<std::uint32_t>* plant_of_root) {
  const auto n = static_cast<std::uint32_t>(samples.size());
  std::vector<std::uint32_t> children(n, 0), only_child(n, kNone), branch_of(n, kNone), plant_of(n, kNone);
  for (std::uint32_t s = 0; s < n; ++s)
    if (const std::uint32_t parent = samples[s].parent; parent != kNone) {
      ++children[parent];
      only_child[parent] = s;
    }
  const auto ends_branch = [&](std::uint32_t s) {
    return samples[s].parent == kNone || children[s] != 1 || samples[only_child[s]].axis != samples[s].axis;
  };
  Tree tree;
  if (plant_of_root) plant_of_root->clear();
  std::vector<std::vector<int>> types;
  for (std::uint32_t s = 0; s < n; ++s) {
    const TreeSample& sample = samples[s];
    if (sample.parent == kNone) {
      if (children[s] > 0) {
        plant_of[s] = static_cast<std::uint32_t>(tree.plants.size());
        tree.plants.push_back({.root = sample.point, .main_axis = 0, .soma = {}, .label = {}, .foreign = {}});
      }
      if (plant_of_root) plant_of_root->push_back(plant_of[s]);
      continue;
    }
    plant_of[s] = plant_of[sample.parent];
    branch_of[s] = branch_of[sample.parent];
    if (ends_branch(sample.parent)) {
      const TreeSample& base = samples[sample.parent];
      branch_of[s] = static_cast<std::uint32_t>(tree.branches.size());
      Tree::Branch& branch = tree.branches.emplace_back();
      types.emplace_back();
      branch.parent = branch_of[sample.parent];
      branch.plant = plant_of[s];
      branch.axis = sample.axis == kNone ? 0 : sample.axis;
      branch.points.push_back(base.point);
      branch.radius.push_back(sample.base_radius.value_or(base.radius));
    }
    Tree::Branch& branch = tree.branches[branch_of[s]];
    branch.points.push_back(sample.point);
    branch.radius.push_back(sample.radius);
    types[branch_of[s]].push_back(sample.type);
    if (sample.bridged) branch.bridged.resize(branch.points.size() - 2, 0);
    if (sample.bridged || !branch.bridged.empty()) branch.bridged.push_back(sample.bridged);
  }
  for (std::size_t b = 0; b < types.size(); ++b) tree.branches[b].type = type_of_most(types[b]);
  return tree;
}

std::vector<std::uint32_t> children_of_branches(const Tree& tree) {
  std::vector<std::uint32_t> children(tree.branches.size(), 0);
  for (const Tree::Branch& branch : tree.branches)
    if (branch.parent != kNone) ++children[branch.parent];
  return children;
}

void number_branches(Tree& tree) {
  const std::vector<std::uint32_t> children = children_of_branches(tree);
  for (Tree::Branch& branch : tree.branches)
    branch.order = branch.parent == kNone ? 0 : tree.branches[branch.parent].order + (children[branch.parent] > 1);
  // Of the children: the largest number, and how many have it.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> largest(tree.branches.size(), {0, 0});
  for (std::size_t b = tree.branches.size(); b-- > 0;) {
    Tree::Branch& branch = tree.branches[b];
    branch.strahler = children[b] == 0 ? 1 : largest[b].first + (largest[b].second > 1);
    if (branch.parent == kNone) continue;
    auto& [number, count] = largest[branch.parent];
    count = branch.strahler > number ? 1 : count + (branch.strahler == number);
    number = std::max(number, branch.strahler);
  }
}

void require_axes(const Tree& tree, const char* format) {
  if (tree.axes.empty())
    throw Error(ErrorCode::usage,
                fmt::format("a tree without axes cannot be written as {}; find its axes first", format));
}

}  // namespace quench::io
