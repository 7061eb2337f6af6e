// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "quench/error.h"
#include "quench/tree.h"
#include "tree/course.h"
#include "tree/polyline_network.h"
#include "tree/spurs.h"

namespace quench {
namespace {

tree::Network network_of_graph(const CurveGraph& graph, const std::vector<std::vector<std::uint8_t>>& bridged) {
  if (graph.sheets > 0)
    throw Error(ErrorCode::usage, "a skeleton with sheets is not a tree; theta2 inf turns sheets into curves",
                "theta2");
  tree::Network network;
  for (const CurveGraph::Node& node : graph.nodes) network.nodes.push_back({node.point, node.radius});
  for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
    const CurveGraph::Branch& branch = graph.branches[b];
    network.links.push_back({branch.from, branch.to, branch.points, branch.radius,
                             b < bridged.size() ? bridged[b] : std::vector<std::uint8_t>(), 0, b});
  }
  return network;
}

// The network of a tree, and its root nodes.
std::pair<tree::Network, std::vector<tree::Start>> network_of_tree(Tree&& from) {
  tree::Network network;
  std::vector<tree::Start> starts;
  for (Tree::Plant& plant : from.plants) {
    starts.push_back({static_cast<std::uint32_t>(network.nodes.size()), std::move(plant)});
    network.nodes.push_back({starts.back().plant.root, 0});
  }
  std::vector<std::uint32_t> far;  // per branch the node at its far end
  for (std::uint32_t b = 0; b < from.branches.size(); ++b) {
    Tree::Branch& branch = from.branches[b];
    if (branch.points.empty()) throw Error(ErrorCode::usage, "a branch of a tree needs points");
    const std::uint32_t near = branch.parent == kNone ? starts.at(branch.plant).node : far.at(branch.parent);
    network.nodes[near].radius = std::max(network.nodes[near].radius, branch.radius[0]);
    if (branch.points.size() == 1) {  // a root node without branches
      far.push_back(near);
      continue;
    }
    far.push_back(static_cast<std::uint32_t>(network.nodes.size()));
    network.nodes.push_back({branch.points.back(), branch.radius.back()});
    network.links.push_back({near, far.back(), std::move(branch.points), std::move(branch.radius),
                             std::move(branch.bridged), branch.type, branch.source});
  }
  return {std::move(network), std::move(starts)};
}

// Courses of voxels end at the last of their places before the end of the medial axis: a quarter of a voxel before it
// in the mean.
constexpr double kTipVoxels = 0.25;

// Moves tips on by so much, in the direction that their courses have over their last radius.
void grow_tips(Tree& tree, double voxel) {
  std::vector<std::uint8_t> goes_on(tree.branches.size(), 0);
  for (const Tree::Branch& branch : tree.branches)
    if (branch.parent != kNone) goes_on[branch.parent] = 1;
  for (std::size_t b = 0; b < tree.branches.size(); ++b) {
    if (goes_on[b]) continue;
    tree::Course course;
    course.append(tree.branches[b]);
    Vec3& tip = tree.branches[b].points.back();
    const Vec3 along = tip - course.point_at(std::max(0.0, course.length() - std::max(voxel, course.radius().back())));
    if (along.norm() > 0) tip += kTipVoxels * voxel * along.normalized();
  }
}

Tree finished(tree::Network& network, std::span<const tree::Start> known, const HierarchyOptions& options,
              bool medial) {
  const std::vector<tree::Start> starts = tree::rooted(network, known, options);
  Tree tree = tree::directed(network, starts);
  while (options.voxel > 0 && tree::drop_spurs(tree, options.voxel) > 0) {
    const auto [rest, roots] = network_of_tree(std::move(tree));
    tree = tree::directed(rest, roots);
  }
  grow_tips(tree, options.voxel);
  tree.down = options.down.normalized();
  tree.rule = options.rule;
  tree::build_axes(tree, options, medial);
  return tree;
}

}  // namespace

Tree tree_of(const Repaired& repaired, const HierarchyOptions& options, Context* context) {
  checkpoint(context, "hierarchy", 0);
  tree::Network network = network_of_graph(repaired.graph, repaired.bridged);
  Tree tree = finished(network, {}, options, true);
  checkpoint(context, "hierarchy", 1);
  return tree;
}

Tree with_hierarchy(Tree from, const HierarchyOptions& options) {
  const Coordinates coordinates = from.coordinates;
  std::string foreign = std::move(from.foreign);
  auto [network, starts] = network_of_tree(std::move(from));
  Tree tree = finished(network, starts, options, false);
  tree.coordinates = coordinates;
  tree.foreign = std::move(foreign);
  return tree;
}

}  // namespace quench
