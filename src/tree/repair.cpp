// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/union_find.h"
#include "quench/tree.h"
#include "tree/repair_bridges.h"
#include "tree/repair_model.h"
#include "tree/repair_result.h"

namespace quench {
namespace {

using tree::Bridge;
using tree::Choice;
using tree::Contact;
using tree::ForestEdge;
using tree::Joint;
using tree::Model;

constexpr double kLeastPlant = 0.2;    // length of a plant that is cut off another one, over the mean of all
constexpr double kMostOfTouching = 2;  // gain of what may be a touching: no piece, no continuation
constexpr double kWorth = 2;           // cost of a bridge that a unit of length is worth

class Repairing {
 public:
  Repairing(const Model& model, const RepairOptions& options, const GreyValues* grey, Context* context)
      : model_(model), options_(options), grey_(grey), context_(context) {
    vertices_ = static_cast<std::uint32_t>(model.arms.size() + model.joints.size());
  }

  Repaired run() {
    choice_.contacts = tree::contacts_of(model_);
    checkpoint(context_, "repair", 0.2);
    std::vector<Bridge> bridges;
    const bool gaps = options_.rule == RepairRule::gaps || options_.rule == RepairRule::all;
    if (gaps && options_.plants > 0) bridges = tree::bridges_of(model_, options_.reach, grey_, context_);
    checkpoint(context_, "repair", 0.6);
    choose(std::move(bridges));
    checkpoint(context_, "repair", 0.8);
    Repaired repaired = tree::result_of(model_, choice_);
    checkpoint(context_, "repair", 1);
    return repaired;
  }

 private:
  void choose(std::vector<Bridge> bridges) {
    const bool loops_stay = options_.rule == RepairRule::gaps;
    std::vector<ForestEdge> edges;
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p)
      edges.push_back(
          {2 * p, 2 * p + 1, model_.pieces[p].bar ? std::numeric_limits<double>::infinity() : model_.pieces[p].gain});
    for (const Contact& contact : choice_.contacts) edges.push_back(contact.edge);
    for (const Bridge& bridge : bridges) edges.push_back({bridge.ends[0].vertex, bridge.ends[1].vertex, -bridge.cost});
    std::vector<double> worth = worth_of_vertices();
    for (double& w : worth) w *= kWorth;
    std::vector<std::uint32_t> marked = marked_vertices(worth);
    std::vector<std::uint8_t> kept = tree::spanning_forest(vertices_, edges, marked, worth);
    if (options_.roots.empty() && !loops_stay)
      while (!marked.empty() && marked.size() < options_.plants && part_plants(edges, worth, marked, kept)) {
      }

    base::UnionFind trees(vertices_);
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (kept[e]) trees.unite(edges[e].a, edges[e].b);
    const auto first_contact = static_cast<std::ptrdiff_t>(model_.pieces.size());
    const auto first_bridge = first_contact + static_cast<std::ptrdiff_t>(choice_.contacts.size());
    choice_.piece.assign(kept.begin(), kept.begin() + first_contact);
    choice_.contact.assign(kept.begin() + first_contact, kept.begin() + first_bridge);
    if (loops_stay) {
      std::ranges::fill(choice_.piece, std::uint8_t{1});
      std::ranges::fill(choice_.contact, std::uint8_t{1});
    }
    for (std::size_t i = 0; i < bridges.size(); ++i)
      if (kept[static_cast<std::size_t>(first_bridge) + i]) choice_.bridges.push_back(std::move(bridges[i]));
    choice_.left_out.assign(vertices_, 0);
    if (marked.empty()) return;
    std::vector<char> stays(vertices_, 0);
    for (const std::uint32_t v : marked) stays[trees.find(v)] = 1;
    for (std::uint32_t v = 0; v < vertices_; ++v) choice_.left_out[v] = stays[trees.find(v)] ? 0 : 1;
  }

  // Cuts the cheapest contact between two parts that are both as long as a plant may be; false: there is none.
  bool part_plants(const std::vector<ForestEdge>& edges, const std::vector<double>& worth,
                   std::vector<std::uint32_t>& marked, std::vector<std::uint8_t>& kept) const {
    std::vector<std::uint32_t> order, above;
    std::vector<std::size_t> edge_above(vertices_, edges.size());
    walk_forest(edges, kept, marked, order, above, edge_above);
    std::vector<double> below = worth, whole(vertices_, 0);
    double sum = 0;
    for (const std::uint32_t v : order) sum += worth[v];
    for (auto v = order.rbegin(); v != order.rend(); ++v)
      if (above[*v] != kNone) below[above[*v]] += below[*v];
    for (const std::uint32_t v : order) whole[v] = above[v] == kNone ? below[v] : whole[above[v]];
    const double least = kLeastPlant * sum / options_.plants;
    std::uint32_t best = kNone;
    for (const std::uint32_t v : order) {
      if (above[v] == kNone || below[v] < least || whole[v] - below[v] < least) continue;
      const double gain = edges[edge_above[v]].gain;
      if (gain < kMostOfTouching && (best == kNone || gain < edges[edge_above[best]].gain)) best = v;
    }
    if (best == kNone) return false;
    kept[edge_above[best]] = 0;
    marked.push_back(best);
    return true;
  }

  // The vertices of the trees of the marked ones, each after the one above it.
  void walk_forest(const std::vector<ForestEdge>& edges, const std::vector<std::uint8_t>& kept,
                   const std::vector<std::uint32_t>& marked, std::vector<std::uint32_t>& order,
                   std::vector<std::uint32_t>& above, std::vector<std::size_t>& edge_above) const {
    std::vector<std::vector<std::pair<std::uint32_t, std::size_t>>> next(vertices_);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if (!kept[e]) continue;
      next[edges[e].a].push_back({edges[e].b, e});
      next[edges[e].b].push_back({edges[e].a, e});
    }
    above.assign(vertices_, kNone);
    order = marked;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (const auto& [v, e] : next[order[i]]) {
        if (e == edge_above[order[i]]) continue;
        above[v] = order[i];
        edge_above[v] = e;
        order.push_back(v);
      }
  }

  // Lengths; a speck has its diameter.
  std::vector<double> worth_of_vertices() const {
    std::vector<double> worth(vertices_, 0);
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) {
      const tree::Piece& piece = model_.pieces[p];
      if (!piece.bar) {
        worth[2 * p] += 0.5 * piece.length;
        worth[2 * p + 1] += 0.5 * piece.length;
      } else if (!piece.link) {
        worth[vertex_at(piece.node[0])] += piece.length;
      }
    }
    for (std::uint32_t j = 0; j < model_.joints.size(); ++j)
      if (model_.joints[j].arms.empty()) worth[tree::vertex_of_joint(model_, j)] += 2 * model_.joints[j].radius;
    return worth;
  }
  std::uint32_t vertex_at(std::uint32_t node) const {
    const std::uint32_t j = model_.joint_of[node];
    const Joint& joint = model_.joints[j];
    if (joint.arms.empty()) return tree::vertex_of_joint(model_, j);
    for (const std::uint32_t arm : joint.arms)
      if (model_.piece_of(arm).node[arm % 2] == node) return arm;
    return joint.arms.front();
  }

  // One vertex in each tree that is wanted: nearest to the root nodes that are given, or of the components of most
  // worth.
  std::vector<std::uint32_t> marked_vertices(const std::vector<double>& worth) const {
    std::vector<std::uint32_t> marked;
    if (model_.nodes.empty()) return marked;
    for (const Vec3& root : options_.roots) {
      const auto nearest = std::ranges::min_element(
          model_.nodes, {}, [&](const CurveGraph::Node& node) { return (node.point - root).squaredNorm(); });
      marked.push_back(vertex_at(static_cast<std::uint32_t>(nearest - model_.nodes.begin())));
    }
    if (!options_.roots.empty() || options_.plants == 0) return marked;
    std::vector<double> sum(model_.components, 0);
    std::vector<std::uint32_t> vertex(model_.components, kNone);
    for (std::uint32_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      const std::uint32_t component = model_.component[joint.nodes.front()];
      if (vertex[component] == kNone) vertex[component] = vertex_at(joint.nodes.front());
      for (const std::uint32_t arm : joint.arms) sum[component] += worth[arm];
      sum[component] += worth[tree::vertex_of_joint(model_, j)];
    }
    std::vector<std::uint32_t> order(model_.components);
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return sum[a] > sum[b]; });
    for (std::size_t i = 0; i < order.size() && i < options_.plants; ++i) marked.push_back(vertex[order[i]]);
    return marked;
  }

  const Model& model_;
  const RepairOptions& options_;
  const GreyValues* grey_;
  Context* context_;
  std::uint32_t vertices_;
  Choice choice_;
};

}  // namespace

const char* name_of(TreeEdit::Kind kind) {
  switch (kind) {
    case TreeEdit::Kind::cut_loop:
      return "cut_loop";
    case TreeEdit::Kind::cut_touching:
      return "cut_touching";
    case TreeEdit::Kind::cut_crossing:
      return "cut_crossing";
    case TreeEdit::Kind::bridge:
      return "bridge";
    case TreeEdit::Kind::left_out:
      return "left_out";
  }
  return "";
}

Repaired repaired(const CurveGraph& graph, const RepairOptions& options, const GreyValues* grey, Context* context) {
  const Model model = tree::model_of(graph, options.voxel);
  Repaired result;
  if (options.rule == RepairRule::off) {
    result.graph = graph;
    result.bridged.resize(graph.branches.size());
  } else {
    result = Repairing(model, options, grey, context).run();
  }
  result.components_before = graph.components;
  result.loops_before = static_cast<std::uint32_t>(model.pieces.size() + model.components - model.nodes.size());
  return result;
}

}  // namespace quench
