// SPDX-License-Identifier: Apache-2.0
#include "tree/spurs.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "tree/polyline_network.h"

namespace quench::tree {
namespace {

constexpr double kSpurRadii = 0.75, kSpurVoxels = 3;              // of what it leaves; true branches by several
constexpr double kLongestSpurRadii = 10, kLongestSpurVoxels = 5;  // what is longer is no spur, wherever it ends

class SpurCutter {
 public:
  SpurCutter(const Tree& tree, double voxel)
      : tree_(tree), voxel_(voxel), children_(children_of(tree)), dropped_(tree.branches.size(), 0) {
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
      if (tree.branches[b].parent == kNone) at_root_[plant_slot(b)].push_back(b);
      length_.push_back(length_of(tree.branches[b].points));
    }
  }

  std::vector<std::uint8_t> run() {
    std::vector<std::uint32_t> ends;
    for (std::uint32_t b = 0; b < tree_.branches.size(); ++b)
      if (children_[b].empty() && is_short(b)) ends.push_back(b);
    std::ranges::stable_sort(ends, {}, [&](std::uint32_t b) { return length_[b]; });
    for (const std::uint32_t b : ends)
      if (ends_inside(b)) dropped_[b] = 1;
    return std::move(dropped_);
  }

 private:
  std::size_t plant_slot(std::uint32_t b) {
    const std::size_t plant = tree_.branches[b].plant;
    if (at_root_.size() <= plant) at_root_.resize(plant + 1);
    return plant;
  }
  bool is_short(std::uint32_t b) const {
    return length_[b] <= kLongestSpurRadii * tree_.branches[b].radius.front() + kLongestSpurVoxels * voxel_;
  }

  bool ends_inside(std::uint32_t b) const {
    const Tree::Branch& branch = tree_.branches[b];
    const Vec3& tip = branch.points.back();
    double out = std::numeric_limits<double>::infinity(), least = 0;
    for_around(b, length_[b] + branch.radius.front(), [&](const Vec3& point, double radius) {
      const double reach = (tip - point).norm() + branch.radius.back() - radius;
      if (reach >= out) return;
      out = reach;
      least = std::max(kSpurVoxels * voxel_, kSpurRadii * radius);
    });
    return out < least;
  }

  struct Walk {
    std::uint32_t branch;
    bool away;    // from the root node
    double left;  // of the way
  };

  /// The points of the branches around the fork at which one begins, as far along them as `way`.
  template <class Take>
  void for_around(std::uint32_t b, double way, const Take& take) const {
    std::vector<Walk> open;
    push_around(open, b, way);
    while (!open.empty()) {
      const Walk walk = open.back();
      open.pop_back();
      const Tree::Branch& branch = tree_.branches[walk.branch];
      const std::size_t n = branch.points.size();
      double left = walk.left;
      for (std::size_t i = 0; i < n && left >= 0; ++i) {
        const std::size_t at = walk.away ? i : n - 1 - i, before = walk.away ? at - 1 : at + 1;
        if (i > 0) left -= (branch.points[at] - branch.points[before]).norm();
        if (left >= 0) take(branch.points[at], branch.radius[at]);
      }
      if (left < 0) continue;
      if (walk.away)
        for (const std::uint32_t child : children_[walk.branch]) push(open, {child, true, left});
      else
        push_around(open, walk.branch, left);
    }
  }
  void push(std::vector<Walk>& open, const Walk& walk) const {
    if (!dropped_[walk.branch]) open.push_back(walk);
  }
  void push_around(std::vector<Walk>& open, std::uint32_t b, double way) const {
    const Tree::Branch& branch = tree_.branches[b];
    if (branch.parent == kNone) {
      for (const std::uint32_t other : at_root_[branch.plant])
        if (other != b) push(open, {other, true, way});
      return;
    }
    push(open, {branch.parent, false, way});
    for (const std::uint32_t other : children_[branch.parent])
      if (other != b) push(open, {other, true, way});
  }

  const Tree& tree_;
  double voxel_;
  base::Csr<std::uint32_t> children_;
  std::vector<std::vector<std::uint32_t>> at_root_;  // per plant
  std::vector<double> length_;
  std::vector<std::uint8_t> dropped_;
};

}  // namespace

std::size_t drop_spurs(Tree& tree, double voxel) {
  const std::vector<std::uint8_t> dropped = SpurCutter(tree, voxel).run();
  std::vector<std::uint32_t> number(tree.branches.size(), kNone);
  std::uint32_t count = 0;
  for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
    if (dropped[b]) continue;
    number[b] = count;
    Tree::Branch branch = std::move(tree.branches[b]);
    if (branch.parent != kNone) branch.parent = number[branch.parent];
    tree.branches[count++] = std::move(branch);
  }
  const std::size_t before = tree.branches.size();
  tree.branches.resize(count);
  return before - count;
}

}  // namespace quench::tree
