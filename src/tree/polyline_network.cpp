// SPDX-License-Identifier: Apache-2.0
#include "tree/polyline_network.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/union_find.h"
#include "quench/error.h"

namespace quench::tree {

double length_of(std::span<const Vec3> points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

base::Csr<std::uint32_t> Network::links_at_nodes() const {
  return base::Csr<std::uint32_t>::group(nodes.size(), [&](const auto& emit) {
    for (std::uint32_t l = 0; l < links.size(); ++l) {
      emit(links[l].from, l);
      emit(links[l].to, l);
    }
  });
}

Components components_of(const Network& network) {
  base::UnionFind sets(network.nodes.size());
  for (const Network::Link& link : network.links)
    if (!sets.unite(link.from, link.to))
      throw Error(ErrorCode::usage, "a graph with loops is not a tree; repair it first", "repair");
  Components components;
  components.of_node.resize(network.nodes.size());
  for (std::uint32_t n = 0; n < network.nodes.size(); ++n) {
    const std::uint32_t first = sets.find(n);  // the smallest of its set
    components.of_node[n] = first == n ? components.count++ : components.of_node[first];
  }
  return components;
}

base::Csr<std::uint32_t> children_of(const Tree& tree) {
  return base::Csr<std::uint32_t>::group(tree.branches.size(), [&](const auto& emit) {
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b)
      if (tree.branches[b].parent != kNone) emit(tree.branches[b].parent, b);
  });
}

namespace {

// Walks the network away from the root nodes.
class Directing {
 public:
  Directing(const Network& network, std::span<const Start> starts)
      : network_(network), starts_(starts), links_at_(network.links_at_nodes()), below_(network.links.size(), 0) {}

  Tree run() {
    for (std::uint32_t p = 0; p < starts_.size(); ++p) {
      tree_.plants.push_back(starts_[p].plant);
      tree_.plants.back().root = network_.nodes[starts_[p].node].point;
      measure(starts_[p].node);
      walk(p);
    }
    number_orders();
    return std::move(tree_);
  }

 private:
  struct Next {
    std::uint32_t link, node, parent;  // the link is left at that node
  };

  // Per link the length of it and of all behind it, seen from the root node.
  void measure(std::uint32_t root) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> order{{root, kNone}};  // node and the link it was reached by
    for (std::size_t i = 0; i < order.size(); ++i)
      for (const std::uint32_t l : links_at_[order[i].first])
        if (l != order[i].second) order.push_back({network_.other_end(l, order[i].first), l});
    for (std::size_t i = order.size(); i-- > 1;) {
      const auto [node, link] = order[i];
      below_[link] = length_of(network_.links[link].points);
      for (const std::uint32_t l : links_at_[node])
        if (l != link) below_[link] += below_[l];
    }
  }

  void walk(std::uint32_t plant) {
    const std::uint32_t root = starts_[plant].node;
    std::vector<Next> open;
    push(open, root, kNone, kNone);
    if (open.empty()) {
      Tree::Branch& alone = add(plant, kNone);
      alone.points = {network_.nodes[root].point};
      alone.radius = {network_.nodes[root].radius};
    }
    while (!open.empty()) {
      const Next next = open.back();
      open.pop_back();
      const auto id = static_cast<std::uint32_t>(tree_.branches.size());
      Tree::Branch& branch = add(plant, next.parent);
      branch.type = network_.links[next.link].type;
      branch.source = network_.links[next.link].source;
      std::uint32_t link = next.link, node = next.node;
      while (true) {
        append(branch, network_.links[link], network_.links[link].from == node);
        node = network_.other_end(link, node);
        const auto around = links_at_[node];
        if (around.size() != 2) break;
        const std::uint32_t on = around[0] == link ? around[1] : around[0];
        if (network_.links[on].type != branch.type) break;
        link = on;
      }
      push(open, node, link, id);
    }
  }
  // The links that leave a node, so that the one with the most behind it is on top.
  void push(std::vector<Next>& open, std::uint32_t node, std::uint32_t came_by, std::uint32_t parent) const {
    const std::size_t first = open.size();
    for (const std::uint32_t l : links_at_[node])
      if (l != came_by) open.push_back({l, node, parent});
    std::stable_sort(open.begin() + static_cast<std::ptrdiff_t>(first), open.end(),
                     [&](const Next& a, const Next& b) { return below_[a.link] < below_[b.link]; });
  }
  Tree::Branch& add(std::uint32_t plant, std::uint32_t parent) {
    Tree::Branch& branch = tree_.branches.emplace_back();
    branch.plant = plant;
    branch.parent = parent;
    return branch;
  }
  static void append(Tree::Branch& branch, const Network::Link& link, bool forward) {
    const std::size_t count = link.points.size();
    const std::size_t had = branch.points.empty() ? 0 : branch.points.size() - 1;  // segments
    if (!link.bridged.empty() || !branch.bridged.empty()) branch.bridged.resize(had, 0);
    for (std::size_t i = branch.points.empty() ? 0 : 1; i < count; ++i) {
      const std::size_t at = forward ? i : count - 1 - i;
      branch.points.push_back(link.points[at]);
      branch.radius.push_back(link.radius[at]);
    }
    if (link.bridged.empty() && branch.bridged.empty()) return;
    for (std::size_t s = 0; s + 1 < count; ++s)
      branch.bridged.push_back(link.bridged.empty() ? 0 : link.bridged[forward ? s : count - 2 - s]);
  }

  void number_orders() {
    std::vector<std::uint32_t> most(tree_.branches.size(), 0), as_large(tree_.branches.size(), 0);
    for (std::size_t b = tree_.branches.size(); b-- > 0;) {
      Tree::Branch& branch = tree_.branches[b];
      branch.strahler = most[b] == 0 ? 1 : most[b] + (as_large[b] > 1 ? 1 : 0);
      const std::uint32_t p = branch.parent;
      if (p == kNone) continue;
      if (branch.strahler > most[p]) {
        most[p] = branch.strahler;
        as_large[p] = 0;
      }
      if (branch.strahler == most[p]) ++as_large[p];
    }
    for (Tree::Branch& branch : tree_.branches)
      branch.order = branch.parent == kNone ? 0 : tree_.branches[branch.parent].order + 1;
  }

  const Network& network_;
  std::span<const Start> starts_;
  base::Csr<std::uint32_t> links_at_;
  std::vector<double> below_;
  Tree tree_;
};

}  // namespace

Tree directed(const Network& network, std::span<const Start> starts) { return Directing(network, starts).run(); }

}  // namespace quench::tree
