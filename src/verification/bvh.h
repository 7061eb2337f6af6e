// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "quench/geometry.h"

namespace quench::verification {

/// An axis-parallel box with integer corners; sites are boxes of one point, boundary faces are flat ones.
struct Box {
  std::array<std::int32_t, 3> low, high;

  Vec3 nearest_point(const Vec3& x) const {
    Vec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = std::clamp(x[a], static_cast<double>(low[static_cast<std::size_t>(a)]),
                        static_cast<double>(high[static_cast<std::size_t>(a)]));
    return p;
  }
  double squared_distance(const Vec3& x) const { return (x - nearest_point(x)).squaredNorm(); }
};

/// A bounding volume hierarchy by median cuts, for nearest-box and range queries. Build O(n log n), 60 bytes per box.
class Bvh {
 public:
  explicit Bvh(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    if (!boxes_.empty()) build(0, static_cast<std::uint32_t>(boxes_.size()));
    std::vector<Box> sorted(boxes_.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = boxes_[order_[i]];
    boxes_ = std::move(sorted);
  }

  /// Squared distance to the nearest box; infinite when there is none.
  double nearest_squared(const Vec3& x) const {
    double best = std::numeric_limits<double>::infinity();
    if (!nodes_.empty()) nearest(0, x, best);
    return best;
  }

  /// Calls visit(index, box) for every box not farther than sqrt(squared), until it returns false.
  template <class Visit>
  bool visit_within(const Vec3& x, double squared, const Visit& visit) const {
    return nodes_.empty() || within(0, x, squared, visit);
  }

 private:
  struct Node {
    Box box;
    std::uint32_t begin, end;  // of the leaf's boxes; begin == end for an inner node
    std::uint32_t right = 0;   // the left child follows its parent
  };
  static constexpr std::uint32_t kLeafSize = 8;

  void build(std::uint32_t begin, std::uint32_t end) {
    const std::size_t self = nodes_.size();
    Box box = boxes_[order_[begin]];
    for (std::uint32_t i = begin; i < end; ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        box.low[a] = std::min(box.low[a], boxes_[order_[i]].low[a]);
        box.high[a] = std::max(box.high[a], boxes_[order_[i]].high[a]);
      }
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= kLeafSize) return;
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (box.high[a] - box.low[a] > box.high[axis] - box.low[axis]) axis = a;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       return std::int64_t{boxes_[i].low[axis]} + boxes_[i].high[axis] <
                              std::int64_t{boxes_[j].low[axis]} + boxes_[j].high[axis];
                     });
    build(begin, middle);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
    nodes_[self].begin = nodes_[self].end = 0;
  }

  void nearest(std::uint32_t n, const Vec3& x, double& best) const {
    const Node& node = nodes_[n];
    if (node.begin != node.end) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) best = std::min(best, boxes_[i].squared_distance(x));
      return;
    }
    std::array<std::uint32_t, 2> child{n + 1, node.right};
    std::array<double, 2> distance{nodes_[child[0]].box.squared_distance(x), nodes_[child[1]].box.squared_distance(x)};
    const std::size_t first = distance[1] < distance[0];
    if (distance[first] < best) nearest(child[first], x, best);
    if (distance[1 - first] < best) nearest(child[1 - first], x, best);
  }

  template <class Visit>
  bool within(std::uint32_t n, const Vec3& x, double squared, const Visit& visit) const {
    const Node& node = nodes_[n];
    if (node.box.squared_distance(x) > squared) return true;
    if (node.begin == node.end) return within(n + 1, x, squared, visit) && within(node.right, x, squared, visit);
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (boxes_[i].squared_distance(x) <= squared && !visit(order_[i], boxes_[i])) return false;
    return true;
  }

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;  // position in the tree: index given by the caller
  std::vector<Node> nodes_;
};

}  // namespace quench::verification
