// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tree/course.h"
#include "tree/polyline_network.h"

namespace quench::tree {
namespace {

// A stem ends where all of its children are less than so many times as thick as it.
constexpr double kCrownThinner = 0.45;
// How far along the parent its tube is looked at around a fork, in its radii.
constexpr double kTubeReach = 4;

class Axes {
 public:
  Axes(Tree& tree, const HierarchyOptions& options, bool medial)
      : tree_(tree),
        options_(options),
        medial_(medial),
        children_(children_of(tree)),
        on_(continuations(tree, options.rule)) {}

  void run() {
    find_plants();
    for (std::uint32_t b = 0; b < tree_.branches.size(); ++b) {  // parents first
      const std::uint32_t p = tree_.branches[b].parent;
      if (p == kNone || on_[p] != b) begin(b);
    }
    for (Piece& piece : pieces_) measure(piece);
    number();
  }

 private:
  // An axis before axes have their numbers. Its parent comes before it.
  struct Piece {
    std::vector<std::uint32_t> branches;
    std::uint32_t parent = kNone, plant = 0;
    bool stem = false;
    Course course;
    double position = 0;
  };

  void find_plants() {
    at_root_.resize(tree_.plants.size());
    for (std::uint32_t b = 0; b < tree_.branches.size(); ++b)
      if (tree_.branches[b].parent == kNone) at_root_[tree_.branches[b].plant].push_back(b);
    piece_of_.assign(tree_.branches.size(), kNone);
    main_.assign(tree_.plants.size(), kNone);
    // The main axes come first: what else begins at a root node is a child of them.
    for (std::uint32_t p = 0; p < tree_.plants.size(); ++p) {
      main_[p] = static_cast<std::uint32_t>(pieces_.size());
      begin(main_branch(tree_, at_root_[p], options_.rule));
    }
  }
  void begin(std::uint32_t b) {
    if (piece_of_[b] != kNone) return;
    const std::uint32_t before = tree_.branches[b].parent, plant = tree_.branches[b].plant;
    const auto id = static_cast<std::uint32_t>(pieces_.size());
    Piece& piece = pieces_.emplace_back();
    piece.plant = plant;
    if (before != kNone)
      piece.parent = piece_of_[before];
    else if (main_[plant] != id && !tree_.plants[plant].soma)
      piece.parent = main_[plant];
    const bool may_be_stem = options_.stem && main_[plant] == id;
    Course stem;
    for (std::uint32_t next = b; next != kNone; next = on_[next]) {
      piece_of_[next] = id;
      piece.branches.push_back(next);
      if (may_be_stem) stem.append(tree_.branches[next]);
      if (may_be_stem && ends_at_crown(stem, next)) {
        piece.stem = true;
        on_[next] = kNone;  // all its children are axes of their own
      }
    }
  }
  // Whether all children of a branch are thin beside what leads to it.
  bool ends_at_crown(const Course& stem, std::uint32_t last) const {
    if (children_[last].empty()) return false;
    const double reach = kThicknessReach * stem.radius().back();
    const double before = radius_integral(stem.reversed(reach), reach) / std::min(reach, stem.length());
    return std::ranges::all_of(children_[last], [&](std::uint32_t c) {
      return thickness_behind(tree_, children_, c, reach) < kCrownThinner * before;
    });
  }

  // Course and place on the parent, whose own are known.
  void measure(Piece& piece) {
    Course raw;
    for (const std::uint32_t b : piece.branches) raw.append(tree_.branches[b]);
    if (piece.parent == kNone) {
      piece.course = std::move(raw);
    } else if (!medial_ || tree_.branches[piece.branches[0]].parent == kNone) {
      piece.position = length_before(piece);
      piece.course = std::move(raw);
    } else {
      while (const Piece* older = older_parent(piece, raw.points()[0]))
        piece.parent = static_cast<std::uint32_t>(older - pieces_.data());
      leave_tube(piece, raw);
    }
    if (medial_) piece.course = smoothed(piece.course);
  }
  // Along the parent up to the branch that this begins behind.
  double length_before(const Piece& piece) const {
    const std::uint32_t last = tree_.branches[piece.branches[0]].parent;
    double length = 0;
    if (last == kNone) return 0;
    for (const std::uint32_t b : pieces_[piece.parent].branches) {
      length += length_of(tree_.branches[b].points);
      if (b == last) break;
    }
    return length;
  }
  // The parent of the parent, where the fork lies inside of its tube: where a thick axis has several children at one
  // place, their courses meet inside of it before they come to its own.
  const Piece* older_parent(const Piece& piece, const Vec3& fork) const {
    const Piece& parent = pieces_[piece.parent];
    if (parent.parent == kNone) return nullptr;
    const Piece& older = pieces_[parent.parent];
    const Foot foot = nearest_on(older.course, fork);
    return foot.distance < older.course.radius_at(foot.at) ? &older : nullptr;
  }
  // The course from where it is clear of the parent's tube on; before that it goes straight back to the parent's.
  void leave_tube(Piece& piece, const Course& raw) const {
    const Course& parent = pieces_[piece.parent].course;
    const Foot fork = nearest_on(parent, raw.points()[0]);
    const double tube = parent.radius_at(fork.at);
    const double low = fork.at - kTubeReach * tube, high = fork.at + kTubeReach * tube;
    std::size_t clear = 0;
    while (clear < raw.size()) {
      const Foot foot = nearest_on(parent, raw.points()[clear], low, high);
      if (foot.distance >= parent.radius_at(foot.at) + raw.radius()[clear]) break;
      ++clear;
    }
    const bool never = clear == raw.size();
    if (never) clear = raw.size() - 1;
    const Vec3& from = raw.points()[clear];
    const double child = raw.radius()[clear];
    const double beyond = std::min(raw.length(), raw.at()[clear] + std::max(2 * child, tube));
    const Vec3 direction = never ? Vec3(from - raw.points()[0]) : Vec3(raw.point_at(beyond) - from);
    Foot base = direction.norm() > 0 ? nearest_to_ray(parent, from, -direction.normalized(), low, high) : fork;
    if (base.distance > parent.radius_at(base.at)) base = fork;
    piece.position = base.at;
    piece.course.append(parent.point_at(base.at), child);
    for (std::size_t i = clear; i < raw.size(); ++i) piece.course.append(raw.points()[i], raw.radius()[i]);
  }

  // Axes plant by plant, level by level, children by position.
  void number() {
    std::vector<std::vector<std::uint32_t>> children(pieces_.size());
    for (std::uint32_t i = 0; i < pieces_.size(); ++i)
      if (pieces_[i].parent != kNone) children[pieces_[i].parent].push_back(i);
    for (auto& list : children)
      std::ranges::stable_sort(list, {}, [&](std::uint32_t i) { return pieces_[i].position; });
    std::vector<std::uint32_t> order, number(pieces_.size());
    for (std::uint32_t p = 0; p < tree_.plants.size(); ++p) {
      std::size_t next = order.size();
      order.push_back(main_[p]);
      for (std::uint32_t i = 0; i < pieces_.size(); ++i)
        if (pieces_[i].plant == p && pieces_[i].parent == kNone && i != main_[p]) order.push_back(i);
      for (; next < order.size(); ++next)
        order.insert(order.end(), children[order[next]].begin(), children[order[next]].end());
    }
    for (std::uint32_t i = 0; i < order.size(); ++i) number[order[i]] = i;
    tree_.axes.clear();
    for (const std::uint32_t i : order) add(pieces_[i], number);
    for (std::uint32_t p = 0; p < tree_.plants.size(); ++p) tree_.plants[p].main_axis = number[main_[p]];
  }
  void add(Piece& piece, const std::vector<std::uint32_t>& number) {
    const auto id = static_cast<std::uint32_t>(tree_.axes.size());
    Tree::Axis& axis = tree_.axes.emplace_back();
    axis.plant = piece.plant;
    axis.stem = piece.stem;
    axis.position = piece.position;
    axis.points = piece.course.points();
    axis.radius = piece.course.radius();
    axis.branches = std::move(piece.branches);
    for (const std::uint32_t b : axis.branches) tree_.branches[b].axis = id;
    if (piece.parent == kNone) return;
    axis.parent = number[piece.parent];
    axis.level = tree_.axes[axis.parent].level + 1;
    tree_.axes[axis.parent].children.push_back(id);
  }

  Tree& tree_;
  const HierarchyOptions& options_;
  bool medial_;
  base::Csr<std::uint32_t> children_;
  std::vector<std::uint32_t> on_;
  std::vector<std::vector<std::uint32_t>> at_root_;
  std::vector<std::uint32_t> piece_of_, main_;
  std::vector<Piece> pieces_;
};

}  // namespace

void build_axes(Tree& tree, const HierarchyOptions& options, bool medial) { Axes(tree, options, medial).run(); }

}  // namespace quench::tree
