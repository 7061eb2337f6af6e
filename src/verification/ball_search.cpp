// SPDX-License-Identifier: Apache-2.0
#include "verification/ball_search.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace quench::verification {

namespace {

constexpr std::uint32_t kBallsInLeaf = 8;

}  // namespace

BallSearch::BallSearch(std::vector<LevelBall> balls) : balls_(std::move(balls)) {
  if (!balls_.empty()) build(0, static_cast<std::uint32_t>(balls_.size()));
}

void BallSearch::build(std::uint32_t begin, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  Node node{balls_[begin].centre, balls_[begin].centre, 0, 0, begin, end, 0};
  for (std::uint32_t i = begin; i < end; ++i) {
    node.low = node.low.cwiseMin(balls_[i].centre);
    node.high = node.high.cwiseMax(balls_[i].centre);
    node.radius = std::max(node.radius, balls_[i].radius);
    node.level = std::max(node.level, balls_[i].level);
  }
  nodes_.push_back(node);
  if (end - begin <= kBallsInLeaf) return;
  Eigen::Index axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(balls_.begin() + begin, balls_.begin() + middle, balls_.begin() + end,
                   [&](const LevelBall& a, const LevelBall& b) { return a.centre[axis] < b.centre[axis]; });
  build(begin, middle);
  nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end);
}

double BallSearch::bound(std::uint32_t n, const Vec3& p, double level) const {
  const Node& node = nodes_[n];
  if (node.level < level) return std::numeric_limits<double>::infinity();
  return (p - p.cwiseMax(node.low).cwiseMin(node.high)).norm() - node.radius;
}

bool BallSearch::find(const Vec3& p, double level, double enough, double& away, std::uint32_t& ball) const {
  return !nodes_.empty() && bound(0, p, level) < away && search(0, p, level, enough, away, ball);
}

bool BallSearch::search(std::uint32_t n, const Vec3& p, double level, double enough, double& away,
                        std::uint32_t& ball) const {
  const Node& node = nodes_[n];
  bool found = false;
  if (node.right == 0) {
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (const double own = outside(i, p); balls_[i].level >= level && own < away) {
        away = own;
        ball = i;
        found = true;
      }
    return found;
  }
  std::array<std::pair<double, std::uint32_t>, 2> children{std::pair{bound(n + 1, p, level), n + 1},
                                                           std::pair{bound(node.right, p, level), node.right}};
  if (children[1].first < children[0].first) std::swap(children[0], children[1]);
  for (const auto& [nearest, child] : children)
    if (nearest < away && !(away <= enough) && search(child, p, level, enough, away, ball)) found = true;
  return found;
}

}  // namespace quench::verification
