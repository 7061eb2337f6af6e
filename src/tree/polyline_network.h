// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/csr.h"
#include "quench/tree.h"

namespace quench::tree {

/// Polylines between nodes without loops, without direction: what a rooted tree is made of.
struct Network {
  struct Node {
    Vec3 point;
    double radius = 0;
  };
  struct Link {
    std::uint32_t from = 0, to = 0;
    std::vector<Vec3> points;  ///< at least two; the first and the last are those of the nodes
    std::vector<double> radius;
    std::vector<std::uint8_t> bridged;  ///< per segment, or empty
    int type = 0;
    std::uint32_t source = kNone;
  };
  std::vector<Node> nodes;
  std::vector<Link> links;

  base::Csr<std::uint32_t> links_at_nodes() const;
  std::uint32_t other_end(std::uint32_t link, std::uint32_t node) const {
    return links[link].from == node ? links[link].to : links[link].from;
  }
};

/// Which tree a node is part of; trees are numbered by their first nodes. Throws Error(usage) where there is a loop.
struct Components {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> of_node;
};
Components components_of(const Network& network);

/// A root node, and what is known of its plant.
struct Start {
  std::uint32_t node = 0;
  Tree::Plant plant;
};

/// One root node per component, largest component first, those of HierarchyOptions::roots before all others. With a
/// soma, what lies inside of it has become its root node: `network` is changed, and so are components. `known`: root
/// nodes of components, where there are any, instead of those the rule would choose.
std::vector<Start> rooted(Network& network, std::span<const Start> known, const HierarchyOptions& options);

/// Branches and plants from their root nodes on, with their orders; no axes. A node of two links is none, unless their
/// types differ. Children of a fork come in the order of the length of all that follows, the largest first.
Tree directed(const Network& network, std::span<const Start> starts);

/// Branches by the branch they begin at.
base::Csr<std::uint32_t> children_of(const Tree& tree);

double length_of(std::span<const Vec3> points);

/// Per branch the child that continues it; kNone at tips.
std::vector<std::uint32_t> continuations(const Tree& tree, AxisRule rule);
/// Of branches that begin at the same root node, the one that the main axis begins with.
std::uint32_t main_branch(const Tree& tree, std::span<const std::uint32_t> at_root, AxisRule rule);

/// How thick a child is where it leaves a fork: the mean radius over the first `reach` of the thickest way on from its
/// base, through further forks. Where a way ends before, the rest counts 0: a stub of a thick tube is no thick child.
double thickness_behind(const Tree& tree, const base::Csr<std::uint32_t>& children, std::uint32_t branch, double reach);
/// That reach, in radii of the ball of the fork: half of it lies outside of the ball.
inline constexpr double kThicknessReach = 2;

/// Fills in axes, and Branch::axis. `medial`: courses are those of a medial axis, which run inside of the parent's tube
/// where a child leaves it: there they become straight, and a child that leaves a branch inside the tube of an older
/// axis is a child of that one.
void build_axes(Tree& tree, const HierarchyOptions& options, bool medial);

}  // namespace quench::tree
