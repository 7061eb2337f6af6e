// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "tree/course.h"
#include "tree/polyline_network.h"

namespace quench::tree {
namespace {

// Lengths that differ by less are the same: turned about, a tree has the same axes.
constexpr double kSame = 1e-9;
// A turn of so many radians, or a radius so many times as large, count alike.
constexpr double kTurnUnit = 0.5, kRadiusUnit = 0.5;
// What a course that ends before the window does costs, at most.
constexpr double kShort = 2;
// A child continues only if it is at least so many times as thick as the thickest one.
constexpr double kThickEnough = 0.5;
// From the root node an axis first goes where the tree is so many times as thick as all of it up to there.
constexpr double kSpurThinner = 2;
// Of children whose costs differ by less, the one with the longest way to a tip continues.
constexpr double kNearTie = 0.25;
// Forks that a way on may pass: the bound of trees whose forks all lie in one place.
constexpr int kMostForks = 12;

// Per branch the longest way from its base to a tip.
std::vector<double> ways_of(const Tree& tree) {
  std::vector<double> way(tree.branches.size(), 0);  // first the longest one behind it
  for (std::size_t b = way.size(); b-- > 0;) {
    way[b] += length_of(tree.branches[b].points);
    if (const std::uint32_t p = tree.branches[b].parent; p != kNone) way[p] = std::max(way[p], way[b]);
  }
  return way;
}

// The values of rules that compare children by what follows behind them.
class Below {
 public:
  explicit Below(const Tree& tree) : tree_(tree), children_(children_of(tree)), way_(ways_of(tree)) {
    for (const Tree::Branch& branch : tree.branches) {
      length_.push_back(length_of(branch.points));
      mean_radius_.push_back(mean_radius(branch));
    }
  }

  // By `depth` children are compared by the axes they make themselves, so the choices are made from the tips on.
  std::vector<std::uint32_t> choices(AxisRule rule) {
    std::vector<std::uint32_t> on(tree_.branches.size(), kNone);
    axis_.resize(on.size());
    for (std::size_t b = on.size(); b-- > 0;) {
      on[b] = best_of(children_[b], rule, static_cast<std::uint32_t>(b));
      axis_[b] = length_[b] + (on[b] == kNone ? 0 : axis_[on[b]]);
    }
    return on;
  }
  // `from`: what they continue, or kNone.
  std::uint32_t best_of(std::span<const std::uint32_t> children, AxisRule rule, std::uint32_t from) const {
    std::uint32_t best = kNone;
    for (const std::uint32_t c : children)
      if (best == kNone || better(c, best, rule, from)) best = c;
    return best;
  }

 private:
  // The largest level that follows a branch, at least: its Strahler number less one.
  bool better(std::uint32_t a, std::uint32_t b, AxisRule rule, std::uint32_t from) const {
    const auto more = [](double x, double y) { return x > y * (1 + kSame); };
    if (rule == AxisRule::depth || rule == AxisRule::strahler) {
      const std::uint32_t sa = tree_.branches[a].strahler, sb = tree_.branches[b].strahler;
      if (sa != sb) return sa > sb;
      if (rule == AxisRule::depth) {
        if (more(axis_[a], axis_[b])) return true;
        if (more(axis_[b], axis_[a]) || from == kNone) return false;
        return turn(from, a) < turn(from, b) - kSame;
      }
    }
    if (rule == AxisRule::radius) {
      if (more(mean_radius_[a], mean_radius_[b])) return true;
      if (more(mean_radius_[b], mean_radius_[a])) return false;
    }
    return more(way_[a], way_[b]);
  }
  double turn(std::uint32_t from, std::uint32_t child) const {
    const auto chord = [&](std::uint32_t b) -> Vec3 {
      return tree_.branches[b].points.back() - tree_.branches[b].points[0];
    };
    return angle_between(chord(from), chord(child));
  }
  static double mean_radius(const Tree::Branch& branch) {
    double sum = 0, length = 0;
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const double step = (branch.points[i] - branch.points[i - 1]).norm();
      sum += step * (branch.radius[i] + branch.radius[i - 1]) / 2;
      length += step;
    }
    return length > 0 ? sum / length : branch.radius[0];
  }

  const Tree& tree_;
  base::Csr<std::uint32_t> children_;
  std::vector<double> way_, length_, mean_radius_, axis_;
};

// Continuation: from the root node on, an axis is known up to a fork; of all ways on from there, as far as the window
// goes, the one that costs least is where it continues.
class Continuation {
 public:
  explicit Continuation(const Tree& tree) : tree_(tree), children_(children_of(tree)), way_(ways_of(tree)) {
    thickest_.assign(tree.branches.size(), 0);
    for (std::size_t b = tree.branches.size(); b-- > 0;) {
      thickest_[b] = std::max(thickest_[b], *std::ranges::max_element(tree.branches[b].radius));
      if (const std::uint32_t p = tree.branches[b].parent; p != kNone)
        thickest_[p] = std::max(thickest_[p], thickest_[b]);
    }
  }

  std::vector<std::uint32_t> choices() {
    on_.assign(tree_.branches.size(), kNone);
    for (std::uint32_t b = 0; b < tree_.branches.size(); ++b)  // parents first
      if (const std::uint32_t p = tree_.branches[b].parent; p == kNone || on_[p] != b) follow(b);
    return std::move(on_);
  }

 private:
  void follow(std::uint32_t first) {
    Course course;
    for (std::uint32_t b = first; b != kNone; b = on_[b]) {
      course.append(tree_.branches[b]);
      on_[b] = next(b, course, tree_.branches[first].parent == kNone);
    }
  }
  std::uint32_t next(std::uint32_t b, const Course& course, bool from_root) {
    const auto children = children_[b];
    if (children.size() < 2) return children.empty() ? kNone : children[0];
    if (from_root) {  // a thin spur that the root node lies at the end of leads to the thick part
      const std::uint32_t thick =
          *std::ranges::max_element(children, {}, [&](std::uint32_t c) { return thickest_[c]; });
      if (thickest_[thick] > kSpurThinner * *std::ranges::max_element(course.radius())) return thick;
    }
    const double ball = tree_.branches[b].radius.back();
    const Window in = window_of(course.reversed(kWindow * ball), ball);
    std::vector<double> thickness, cost;
    for (const std::uint32_t c : children)
      thickness.push_back(thickness_behind(tree_, children_, c, kThicknessReach * ball));
    const double enough = kThickEnough * *std::ranges::max_element(thickness);
    for (std::size_t i = 0; i < children.size(); ++i)
      cost.push_back(thickness[i] < enough ? std::numeric_limits<double>::infinity()
                                           : least_cost(children[i], ball, in, Course(), 0));
    const double near = *std::ranges::min_element(cost) + kNearTie;
    std::uint32_t best = kNone;
    for (std::size_t i = 0; i < children.size(); ++i)
      if (cost[i] <= near && (best == kNone || way_[children[i]] > way_[best] * (1 + kSame))) best = children[i];
    return best;
  }
  // Of all ways that begin with this branch and end with the window, or at a tip.
  double least_cost(std::uint32_t b, double ball, const Window& in, const Course& before, int forks) const {
    Course way = before;
    way.append(tree_.branches[b]);
    const auto children = children_[b];
    if (children.empty() || way.length() >= kWindow * ball || forks == kMostForks) return cost_of(way, ball, in);
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t c : children) least = std::min(least, least_cost(c, ball, in, way, forks + 1));
    return least;
  }
  static double cost_of(const Course& way, double ball, const Window& in) {
    const Window out = window_of(way, ball);
    const double turn = angle_between(-in.direction, out.direction);
    const double change = in.radius > 0 && out.radius > 0 ? std::abs(std::log(out.radius / in.radius)) : 0;
    const double missing = ball > 0 ? std::max(0.0, 1 - way.length() / (kWindow * ball)) : 0;
    return turn / kTurnUnit + change / kRadiusUnit + kShort * missing;
  }

  const Tree& tree_;
  base::Csr<std::uint32_t> children_;
  std::vector<double> way_, thickest_;  // of each branch and all behind it
  std::vector<std::uint32_t> on_;
};

}  // namespace

std::vector<std::uint32_t> continuations(const Tree& tree, AxisRule rule) {
  return rule == AxisRule::continuation ? Continuation(tree).choices() : Below(tree).choices(rule);
}

double thickness_behind(const Tree& tree, const base::Csr<std::uint32_t>& children, std::uint32_t branch,
                        double reach) {
  struct Way {
    std::uint32_t branch;
    double left, sum;
  };
  double most = 0;
  std::vector<Way> open{{branch, reach, 0}};
  while (!open.empty()) {
    const Way way = open.back();
    open.pop_back();
    Course course;
    course.append(tree.branches[way.branch]);
    const double sum = way.sum + radius_integral(course, way.left), left = way.left - course.length();
    most = std::max(most, sum);
    if (left > 0)
      for (const std::uint32_t c : children[way.branch]) open.push_back({c, left, sum});
  }
  return reach > 0 ? most / reach : 0;
}

std::uint32_t main_branch(const Tree& tree, std::span<const std::uint32_t> at_root, AxisRule rule) {
  // Nothing leads to a root node: by `continuation` it is the thickest one too.
  if (rule == AxisRule::continuation) rule = AxisRule::radius;
  Below below(tree);
  below.choices(rule);  // the axes that `depth` compares
  return below.best_of(at_root, rule, kNone);
}

}  // namespace quench::tree
