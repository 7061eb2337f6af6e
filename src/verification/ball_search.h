// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/geometry.h"

namespace quench::verification {

/// A ball that is part of the prunings for thresholds up to its level.
struct LevelBall {
  Vec3 centre;
  double radius, level;
};

/// Balls in a tree by median cuts of their centres. Build O(n log n).
class BallSearch {
 public:
  explicit BallSearch(std::vector<LevelBall> balls);

  std::size_t size() const { return balls_.size(); }
  /// How far a point lies outside of ball i; negative inside.
  double outside(std::uint32_t i, const Vec3& p) const { return (p - balls_[i].centre).norm() - balls_[i].radius; }
  double level(std::uint32_t i) const { return balls_[i].level; }
  /// Lowers `away` to how far a point lies outside of the union of the balls of some level or more, or of one of them
  /// where that is not above `enough`, and sets `ball` to that. False when no ball is nearer than `away`.
  bool find(const Vec3& p, double level, double enough, double& away, std::uint32_t& ball) const;

 private:
  struct Node {
    Vec3 low, high;                // of the centres
    double radius = 0, level = 0;  // the largest
    std::uint32_t begin = 0, end = 0,
                  right = 0;  // of a leaf the balls; of another node the second child, the first follows
  };
  void build(std::uint32_t begin, std::uint32_t end);
  double bound(std::uint32_t node, const Vec3& p, double level) const;
  bool search(std::uint32_t node, const Vec3& p, double level, double enough, double& away, std::uint32_t& ball) const;

  std::vector<LevelBall> balls_;
  std::vector<Node> nodes_;
};

}  // namespace quench::verification
