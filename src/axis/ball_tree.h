// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "quench/axis.h"
#include "quench/geometry.h"

namespace quench::axis {

/// Balls in a binary tree of boxes over their centres, sorted along a Z-order curve (Morton 1966). O(n log n) to build,
/// on all threads; 12 bytes per ball. The order of the balls, and so of visits, depends on the balls alone.
class BallTree {
 public:
  struct Ball {
    const Vec3& centre;
    double radius;
    std::uint32_t vertex;  ///< row of the centre
  };

  /// The balls of some vertices. `points` and `radius` must outlive the tree.
  BallTree(std::span<const Vec3> points, std::span<const double> radius, std::vector<std::uint32_t> vertices);

  /// Those of all vertices of a voxel core (as it was before it was fitted), which must outlive the tree.
  explicit BallTree(const MedialAxis& axis);

  std::size_t node_count() const { return nodes_.size(); }
  std::size_t size() const { return vertices_.size(); }
  Ball ball(std::size_t i) const { return {points_[vertices_[i]], radius_[vertices_[i]], vertices_[i]}; }
  /// The leaf that holds ball i; the parent of node n is n / 2, the root is node 1.
  std::size_t leaf_of(std::size_t i) const { return leaves_ + i / kLeaf; }

  /// Not less than the largest radius in a node; -infinity for an empty one.
  double largest_radius(std::size_t node) const { return static_cast<double>(nodes_[node].largest_radius); }
  /// Not more than the distance of a point from the centres in a node.
  double distance(std::size_t node, const Vec3& p) const {
    const Node& n = nodes_[node];
    double squared = 0;
    for (int a = 0; a < 3; ++a) {
      const double below = static_cast<double>(n.low[a]) - (p[a] - origin_[a]);
      const double above = (p[a] - origin_[a]) - static_cast<double>(n.high[a]);
      const double outside = below > 0 ? below : above > 0 ? above : 0;
      squared += outside * outside;
    }
    return std::sqrt(squared);
  }

  /// The same of a box of points.
  double distance(std::size_t node, const Vec3& low, const Vec3& high) const {
    const Node& n = nodes_[node];
    double squared = 0;
    for (int a = 0; a < 3; ++a) {
      const double below = static_cast<double>(n.low[a]) - (high[a] - origin_[a]);
      const double above = (low[a] - origin_[a]) - static_cast<double>(n.high[a]);
      const double outside = below > 0 ? below : above > 0 ? above : 0;
      squared += outside * outside;
    }
    return std::sqrt(squared);
  }

  /// Calls visit(i) for ball i of every leaf whose own and whose ancestors' bound(node) is below `limit`, nearer nodes
  /// first; visit() may lower `limit`.
  template <class Bound, class Visit>
  void walk(const Bound& bound, const double& limit, const Visit& visit) const {
    walk(1, bound(1), bound, limit, visit);
  }

  /// The ball that a point is least outside of, if by less than `limit`; else size(). `limit` becomes that distance
  /// (|p - centre| - radius, negative inside).
  std::size_t nearest(const Vec3& p, double& limit) const {
    return near(p, -std::numeric_limits<double>::infinity(), limit);
  }
  /// The same, or the first ball found that the point is not more than `enough` outside of.
  std::size_t near(const Vec3& p, double enough, double& limit) const;

 private:
  static constexpr std::size_t kLeaf = 8;
  struct Node {  // rounded outwards, relative to origin_
    float low[3], high[3], largest_radius;
  };
  void fill_leaf(std::size_t leaf);

  template <class Bound, class Visit>
  void walk(std::size_t node, double own, const Bound& bound, const double& limit, const Visit& visit) const {
    if (!(own < limit)) return;
    if (node >= leaves_) {
      const std::size_t first = (node - leaves_) * kLeaf;
      for (std::size_t i = first; i < first + kLeaf && i < size(); ++i) visit(i);
      return;
    }
    const double left = bound(2 * node), right = bound(2 * node + 1);
    const bool left_first = left <= right;
    walk(left_first ? 2 * node : 2 * node + 1, left_first ? left : right, bound, limit, visit);
    walk(left_first ? 2 * node + 1 : 2 * node, left_first ? right : left, bound, limit, visit);
  }

  std::span<const Vec3> points_;
  std::span<const double> radius_;
  std::vector<std::uint32_t> vertices_;
  Vec3 origin_ = Vec3::Zero();  // a corner of the box around all: floats are precise enough near it
  std::vector<Node> nodes_;     // children of node n: 2n and 2n + 1; the leaves are the last half
  std::size_t leaves_ = 1;
};

/// How far a point lies outside a ball; negative inside.
inline double outside(const BallTree::Ball& ball, const Vec3& p) { return (p - ball.centre).norm() - ball.radius; }

/// Calls visit(ball) for those that a point lies outside of by less than `limit`.
template <class Visit>
void for_balls_near(const BallTree& tree, const Vec3& p, double limit, const Visit& visit) {
  tree.walk([&](std::size_t node) { return tree.distance(node, p) - tree.largest_radius(node); }, limit,
            [&](std::size_t i) {
              if (outside(tree.ball(i), p) < limit) visit(tree.ball(i));
            });
}

/// The rows of balls that some point of a box lies outside of by less than `limit`, and maybe of others.
inline void balls_near_box(const BallTree& tree, const Vec3& low, const Vec3& high, double limit,
                           std::vector<std::uint32_t>& rows) {
  rows.clear();
  tree.walk([&](std::size_t node) { return tree.distance(node, low, high) - tree.largest_radius(node); }, limit,
            [&](std::size_t i) {
              const BallTree::Ball ball = tree.ball(i);
              const Vec3 nearest = ball.centre.cwiseMax(low).cwiseMin(high);
              if (outside(ball, nearest) < limit * (1 + 1e-9)) rows.push_back(static_cast<std::uint32_t>(i));
            });
}

/// Balls that boundary vertices are near, looked up one after the other: the last answer in a neighbourhood is mostly
/// near its other vertices, too.
class NearBalls {
 public:
  NearBalls(const BallTree& tree, const Grid& grid)
      : tree_(tree), grid_(grid), last_(kEntries, static_cast<std::uint32_t>(tree.size())) {}

  /// Whether the vertex lies less than `limit` outside some ball; the distance to the nearest one, or to any that it is
  /// not more than `enough` outside of, becomes the new limit.
  bool find(const LatticePoint& site, double enough, double& limit);

 private:
  static constexpr std::size_t kEntries = 1 << 16;
  std::size_t entry(std::int64_t x, std::int64_t y) const;
  const BallTree& tree_;
  const Grid& grid_;
  std::vector<std::uint32_t> last_;  // per column of 4 x 4 voxels, those 1024 apart share one: sites come by z; per
                                     // square of 4 x 4 pixels
};

}  // namespace quench::axis
