// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::surface {

/// An axis-parallel box; holds nothing before the first add().
struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Bounds& box) {
    low = low.cwiseMin(box.low);
    high = high.cwiseMax(box.high);
  }
  /// Whether two boxes are at most `within` apart along every axis.
  bool meets(const Bounds& box, double within) const {
    for (int a = 0; a < 3; ++a)
      if (low[a] > box.high[a] + within || box.low[a] > high[a] + within) return false;
    return true;
  }
};

/// A tree of boxes by median cuts. Build O(n log n), 120 bytes per box.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Bounds> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(boxes_.size());
    if (!boxes_.empty()) build(0, static_cast<std::uint32_t>(boxes_.size()));
    std::vector<Bounds> sorted(boxes_.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = boxes_[order_[i]];
    boxes_ = std::move(sorted);
  }

  /// The boxes in an order in which those that are near each other mostly follow each other.
  std::span<const std::uint32_t> order() const { return order_; }

  /// Calls take(index) for every box for which enter(box) holds; enter() must hold for a box that contains one for
  /// which it holds. Always in the same order.
  template <class Enter, class Take>
  void visit(const Enter& enter, const Take& take) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t at = stack[--depth];
      const Node& node = nodes_[at];
      if (!enter(node.box)) continue;
      if (node.right != 0) {
        stack[depth++] = node.right;
        stack[depth++] = at + 1;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        if (enter(boxes_[i])) take(order_[i]);
    }
  }

 private:
  struct Node {
    Bounds box;
    std::uint32_t begin = 0, end = 0;  // its boxes
    std::uint32_t right = 0;           // second child, 0 for a leaf; the first one follows the node
  };
  static constexpr std::uint32_t kLeaf = 4;

  void build(std::uint32_t begin, std::uint32_t end) {
    const std::size_t self = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Bounds& box = nodes_[self].box;
    for (std::uint32_t i = begin; i < end; ++i) box.add(boxes_[order_[i]]);
    if (end - begin <= kLeaf) return;
    int axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::uint32_t i) { return boxes_[i].low[axis] + boxes_[i].high[axis]; };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) { return at(i) != at(j) ? at(i) < at(j) : i < j; });
    build(begin, middle);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
  }

  std::vector<Bounds> boxes_;         // in the order of the tree
  std::vector<std::uint32_t> order_;  // position in the tree: index given by the caller
  std::vector<Node> nodes_;
};

}  // namespace quench::surface
