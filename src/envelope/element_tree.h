// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "envelope/element.h"
#include "quench/geometry.h"

namespace quench::envelope {

/// Elements in a balanced binary tree of boxes. A node knows the box of the elements and that of their axes with their
/// largest radius: the first bounds distances well where radii differ, the second where many large balls overlap.
class ElementTree {
 public:
  struct Near {
    NearBall ball;
    std::uint32_t element = kNone;  ///< in the order they were given
  };

  explicit ElementTree(std::vector<Element> elements);

  std::size_t size() const { return elements_.size(); }
  /// By their place in the tree; row(place) is the order they were given in.
  const Element& element(std::size_t place) const { return elements_[place]; }
  std::uint32_t row(std::size_t place) const { return rows_[place]; }

  /// The element whose ball a point is least outside of, if by less than `within`; or the first found that it is not
  /// more than `enough` outside of.
  Near nearest(const Vec3& p, double within, double enough) const;
  /// Whether some ball, its radius longer by the factor 1 + `slack`, holds a point.
  bool contains(const Vec3& p, double slack) const;

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Node {                       // rounded outwards, relative to origin_
    float low[3], high[3];            // of the elements
    float axis_low[3], axis_high[3];  // of the centres of their balls
    float largest_radius;
  };
  void fill_leaf(std::size_t leaf);
  /// No more than the distance of a point (relative to origin_) from any ball of a node: of a ball in a box the centre
  /// lies no deeper under the ball's surface than under the box's.
  double bound(std::size_t node, const Vec3& p) const;
  template <class Visit>
  void walk(const Vec3& p, const double& limit, const Visit& visit) const;

  std::vector<Element> elements_;
  std::vector<std::uint32_t> rows_;
  Vec3 origin_ = Vec3::Zero();
  std::vector<Node> nodes_;  // children of node n: 2n and 2n + 1; the root is node 1; the leaves are the last half
  std::size_t leaves_ = 1;
};

}  // namespace quench::envelope
