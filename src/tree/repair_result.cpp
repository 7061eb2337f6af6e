// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_result.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/union_find.h"
#include "graph/branch_measures.h"
#include "tree/repair_drawing.h"

namespace quench::tree {
namespace {

class ResultBuilder {
 public:
  ResultBuilder(const Model& model, const Choice& choice)
      : model_(model), choice_(choice), groups_(model.arms.size()), ends_(model.arms.size()) {}

  Repaired build() {
    for (std::size_t c = 0; c < choice_.contacts.size(); ++c)
      if (choice_.contact[c]) groups_.unite(choice_.contacts[c].edge.a, choice_.contacts[c].edge.b);
    isolated_.assign(model_.joints.size(), kNone);
    for (std::uint32_t j = 0; j < model_.joints.size(); ++j) draw_joint(j);
    find_splits();
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) draw_piece(p);
    draw_bridges();
    list_left_out();
    Repaired repaired;
    drawing_.finish(repaired);
    repaired.edits = std::move(edits_);
    return repaired;
  }

 private:
  struct End {
    std::uint32_t node = kNone;  // of the drawing
    double begin = 0;            // how much of the piece is left away
    double thickest = 0;         // within the ball of the joint; 0: as it is
  };
  struct Group {
    std::vector<std::uint32_t> arms;
    std::vector<std::uint32_t> bars, nodes;  // the least part of the joint that connects them
    double radius = 0;
  };

  std::uint32_t vertex_of(std::uint32_t joint) const {
    const Joint& j = model_.joints[joint];
    return j.arms.empty() ? vertex_of_joint(model_, joint) : j.arms.front();
  }
  bool is_left_out(std::uint32_t joint) const { return choice_.left_out[vertex_of(joint)]; }

  std::vector<Group> groups_of(const Joint& joint) {
    std::vector<Group> groups;
    std::map<std::uint32_t, std::size_t> number;
    for (const std::uint32_t arm : joint.arms) {
      const auto [at, fresh] = number.try_emplace(groups_.find(arm), groups.size());
      if (fresh) groups.emplace_back();
      groups[at->second].arms.push_back(arm);
      groups[at->second].radius = std::max(groups[at->second].radius, model_.arms[arm].radius);
    }
    if (groups.empty()) groups.emplace_back();
    for (Group& group : groups) span(joint, group);
    return groups;
  }

  // Bars whose one end leads to no arm of the group go, from the outside in.
  void span(const Joint& joint, Group& group) const {
    group.nodes = joint.nodes;
    group.bars = joint.bars;
    if (group.arms.empty()) return;
    std::map<std::uint32_t, int> degree;
    for (const std::uint32_t arm : group.arms) degree[model_.piece_of(arm).node[arm % 2]] += 2;
    for (const std::uint32_t bar : group.bars)
      for (const std::uint32_t n : model_.pieces[bar].node) ++degree[n];
    for (bool changed = true; changed;) {
      changed = std::erase_if(group.bars, [&](std::uint32_t bar) {
                  const auto& node = model_.pieces[bar].node;
                  if (degree[node[0]] > 1 && degree[node[1]] > 1) return false;
                  for (const std::uint32_t n : node) --degree[n];
                  return true;
                }) > 0;
    }
    std::erase_if(group.nodes, [&](std::uint32_t n) { return degree[n] <= 0; });
  }

  void draw_joint(std::uint32_t j) {
    if (is_left_out(j)) return;
    const Joint& joint = model_.joints[j];
    std::vector<Group> groups = groups_of(joint);
    // The group that stays as it is: the thickest.
    const auto main =
        static_cast<std::size_t>(std::ranges::max_element(groups,
                                                          [](const Group& a, const Group& b) {
                                                            return std::pair(a.arms.size() > 1, a.radius) <
                                                                   std::pair(b.arms.size() > 1, b.radius);
                                                          }) -
                                 groups.begin());
    const bool whole = groups.size() == 1;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Group& group = groups[g];
      if (g != main && group.arms.size() == 1) {
        const std::uint32_t arm = group.arms.front();
        ends_[arm].begin = end_of_tip(arm);
        cut_tip(j, arm);
        continue;
      }
      std::map<std::uint32_t, std::uint32_t> number;
      for (const std::uint32_t n : group.nodes) {
        const CurveGraph::Node& node = model_.nodes[n];
        const double radius = whole ? node.radius : std::min(node.radius, std::max(group.radius, model_.finest));
        number[n] = drawing_.add_node(node.point, radius, node.vertex);
        if (joint.arms.empty()) isolated_[j] = number[n];
      }
      for (const std::uint32_t bar : group.bars) {
        const Piece& piece = model_.pieces[bar];
        Polyline course = piece.course;
        if (!whole)
          for (double& r : course.radius) r = std::min(r, std::max(group.radius, model_.finest));
        drawing_.add_line(std::move(course), number[piece.node[0]], number[piece.node[1]]);
      }
      for (const std::uint32_t arm : group.arms) {
        ends_[arm].node = number[model_.piece_of(arm).node[arm % 2]];
        if (!whole) ends_[arm].thickest = group.radius;
      }
      if (g != main) cut_pass(j, group, groups[main]);
    }
  }

  // A tip that touches ends at the neck: where it is thinnest about where it enters the ball of what it touches.
  double end_of_tip(std::uint32_t arm) const {
    const Piece& piece = model_.piece_of(arm);
    const std::vector<double> arc = piece.course.arc();
    const double skip = model_.arms[arm].skip, last = std::min(1.5 * skip, 0.5 * piece.length);
    double best = skip;
    const auto radius = [&](double s) {
      return place_on(piece.course, arc, arm % 2 == 0 ? s : piece.length - s).radius;
    };
    constexpr int kSteps = 8;
    for (int i = 0; i <= kSteps; ++i) {
      const double s = 0.5 * skip + (last - 0.5 * skip) * i / kSteps;
      if (s >= 0 && radius(s) < radius(best) * 0.95) best = s;
    }
    return best;
  }

  double cost_between(std::uint32_t joint, std::uint32_t arm) {
    double cost = 0;
    for (std::size_t c = first_contact(joint); c < choice_.contacts.size() && choice_.contacts[c].joint == joint; ++c) {
      const ForestEdge& edge = choice_.contacts[c].edge;
      if ((groups_.find(edge.a) == groups_.find(arm)) != (groups_.find(edge.b) == groups_.find(arm)))
        cost = std::max(cost, edge.gain);
    }
    return cost;
  }
  std::size_t first_contact(std::uint32_t joint) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(choice_.contacts, joint, {}, &Contact::joint) -
                                    choice_.contacts.begin());
  }

  void cut_tip(std::uint32_t joint, std::uint32_t arm) {
    const Piece& piece = model_.piece_of(arm);
    const double at = ends_[arm].begin;
    const PolylinePlace place = place_on(piece.course, piece.course.arc(), arm % 2 == 0 ? at : piece.length - at);
    edits_.push_back({TreeEdit::Kind::cut_touching, place.point, model_.nodes[piece.node[arm % 2]].point, place.radius,
                      at, cost_between(joint, arm)});
  }

  // Two passes that have a part of the joint in common cross; else they touch where a bar connects them.
  void cut_pass(std::uint32_t joint, const Group& group, const Group& main) {
    const auto in_main = [&](std::uint32_t n) { return std::ranges::binary_search(main.nodes, n); };
    const auto common = std::ranges::find_if(group.nodes, in_main);
    const bool crossing = common != group.nodes.end();
    TreeEdit edit;
    edit.kind = crossing ? TreeEdit::Kind::cut_crossing : TreeEdit::Kind::cut_touching;
    edit.from = model_.nodes[crossing ? *common : group.nodes.front()].point;
    edit.to = edit.from;
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t a : group.nodes)
      for (const std::uint32_t b : main.nodes) {
        const Vec3 &p = model_.nodes[a].point, &q = model_.nodes[b].point;
        if (crossing || (p - q).norm() >= nearest) continue;
        nearest = (p - q).norm();
        edit.from = p;
        edit.to = q;
      }
    edit.radius = group.radius;
    edit.length = crossing ? 0 : nearest;
    edit.cost = cost_between(joint, group.arms.front());
    edits_.push_back(edit);
  }

  void find_splits() {
    splits_.resize(model_.pieces.size());
    for (const Bridge& bridge : choice_.bridges)
      for (const BridgeEnd& end : bridge.ends)
        if (end.piece != kNone) splits_[end.piece].push_back({end.at, kNone});
    for (auto& splits : splits_) {
      std::ranges::sort(splits);
      splits.erase(std::unique(splits.begin(), splits.end()), splits.end());
    }
  }

  void draw_piece(std::uint32_t p) {
    const Piece& piece = model_.pieces[p];
    if (piece.bar || choice_.left_out[2 * p]) return;
    const End &from = ends_[2 * p], &to = ends_[2 * p + 1];
    Polyline course = piece.course;
    const std::vector<double> arc = course.arc();
    for (std::size_t i = 0; i < arc.size(); ++i) {
      if (from.thickest > 0 && arc[i] <= model_.arms[2 * p].skip)
        course.radius[i] = std::min(course.radius[i], from.thickest);
      if (to.thickest > 0 && piece.length - arc[i] <= model_.arms[2 * p + 1].skip)
        course.radius[i] = std::min(course.radius[i], to.thickest);
    }
    const double first = from.begin, last = piece.length - to.begin;
    if (choice_.piece[p]) {
      draw_part(p, course, first, from.node, last, to.node, 0, piece.length);
      return;
    }
    const PolylinePlace place = place_on(course, arc, piece.cut_at);
    const auto kind = piece.neck > 0 ? TreeEdit::Kind::cut_touching : TreeEdit::Kind::cut_loop;
    edits_.push_back({kind, place.point, place.point, place.radius, piece.length, piece.gain});
    if (piece.neck > 0 && splits_[p].empty()) return;  // it belongs to neither side
    draw_part(p, course, first, from.node, std::max(first, piece.cut_at), kNone, 0, piece.cut_at);
    draw_part(p, course, std::min(last, piece.cut_at), kNone, last, to.node, std::nextafter(piece.cut_at, piece.length),
              piece.length);
  }

  // From `begin` to `end`, divided where bridges end that belong to the part from `low` to `high` of the whole piece. A
  // node that is not there yet is a cut.
  void draw_part(std::uint32_t p, const Polyline& course, double begin, std::uint32_t from, double end,
                 std::uint32_t to, double low, double high) {
    end = std::max(begin, end);
    double at = begin;
    std::uint32_t last = from;
    const auto draw_to = [&](double next, std::uint32_t node) {
      Polyline part = part_of(course, at, next);
      if (last == kNone) last = drawing_.add_cut(part.points.front(), part.radius.front());
      if (node == kNone) node = drawing_.add_cut(part.points.back(), part.radius.back());
      drawing_.add_line(std::move(part), last, node);
      at = next;
      last = node;
    };
    for (auto& [place, node] : splits_[p]) {
      if (place < low || place > high || node != kNone) continue;
      const double s = std::clamp(place, begin, end);
      if (s <= at && last != kNone) {
        node = last;
      } else if (s >= end && to != kNone) {
        node = to;
      } else {
        const PolylinePlace there = place_on(course, course.arc(), s);
        node = drawing_.add_node(there.point, there.radius, kNone);
        if (s > at) draw_to(s, node);
        last = node;
      }
    }
    if (end > at) draw_to(end, to);
  }

  std::uint32_t node_of(const BridgeEnd& end) const {
    if (end.arm != kNone) return ends_[end.arm].node;
    if (end.joint != kNone) return isolated_[end.joint];
    const auto& splits = splits_[end.piece];
    return std::ranges::lower_bound(splits, std::pair{end.at, std::uint32_t{0}})->second;
  }

  void draw_bridges() {
    for (const Bridge& bridge : choice_.bridges) {
      if (choice_.left_out[bridge.ends[0].vertex]) continue;
      const std::uint32_t a = node_of(bridge.ends[0]), b = node_of(bridge.ends[1]);
      if (a == kNone || b == kNone) continue;
      drawing_.add_line(bridge.course, a, b);
      const std::vector<double>& radius = bridge.course.radius;
      edits_.push_back({TreeEdit::Kind::bridge, bridge.course.points.front(), bridge.course.points.back(),
                        std::min(radius.front(), radius.back()), bridge.course.length(), bridge.cost, bridge.grey});
    }
  }

  void list_left_out() {
    std::vector<TreeEdit> lost(model_.components);
    std::vector<char> is_lost(model_.components, 0);
    const auto add = [&](std::uint32_t node, double length) {
      const std::uint32_t component = model_.component[node];
      TreeEdit& edit = lost[component];
      const CurveGraph::Node& n = model_.nodes[node];
      if (!is_lost[component] || n.radius > edit.radius) {
        edit.from = edit.to = n.point;
        edit.radius = n.radius;
      }
      is_lost[component] = 1;
      edit.kind = TreeEdit::Kind::left_out;
      edit.length += length;
    };
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n)
      if (is_left_out(model_.joint_of[n])) add(n, 0);
    for (const Piece& piece : model_.pieces)
      if (is_left_out(model_.joint_of[piece.node[0]]) && !piece.link) add(piece.node[0], piece.length);
    for (std::uint32_t c = 0; c < model_.components; ++c)
      if (is_lost[c]) edits_.push_back(lost[c]);
  }

  const Model& model_;
  const Choice& choice_;
  base::UnionFind groups_;                                             // of arms
  std::vector<End> ends_;                                              // per arm
  std::vector<std::uint32_t> isolated_;                                // per joint without arms
  std::vector<std::vector<std::pair<double, std::uint32_t>>> splits_;  // per piece: places and their nodes
  Drawing drawing_;
  std::vector<TreeEdit> edits_;
};

}  // namespace

Repaired result_of(const Model& model, const Choice& choice) { return ResultBuilder(model, choice).build(); }

}  // namespace quench::tree
