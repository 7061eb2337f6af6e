// SPDX-License-Identifier: Apache-2.0
#include "simplification/primitive_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace quench::simplification {
namespace {

constexpr std::uint32_t kLeaf = 4;

void reach_ball(const Vec3& p, const Vec4& a, int ia, Reach& best) {
  const double d = (p - a.head<3>()).norm() - a[3];
  if (d < best.distance) {
    best.distance = d;
    best.share = {0, 0, 0};
    best.share[ia] = 1;
  }
}

/// The ball between two that reaches furthest: f(t) = |p - c(t)| - r(t) is convex.
void reach_cone(const Vec3& p, const Vec4& a, int ia, const Vec4& b, int ib, Reach& best) {
  const Vec3 along = b.head<3>() - a.head<3>();
  const double squared = along.squaredNorm(), grow = b[3] - a[3];
  if (squared <= grow * grow) return grow > 0 ? reach_ball(p, b, ib, best) : reach_ball(p, a, ia, best);
  const Vec3 q = p - a.head<3>();
  const double foot = q.dot(along) / squared;
  const double height = (q - foot * along).norm();
  const double t = foot + height * grow / std::sqrt(squared * (squared - grow * grow));
  if (t <= 0) return reach_ball(p, a, ia, best);
  if (t >= 1) return reach_ball(p, b, ib, best);
  const double d = (q - t * along).norm() - a[3] - t * grow;
  if (d < best.distance) {
    best.distance = d;
    best.share = {0, 0, 0};
    best.share[ia] = 1 - t;
    best.share[ib] = t;
  }
}

void reach_slab(const Vec3& p, const Vec4& a, const Vec4& b, const Vec4& c, Reach& best) {
  const Vec4 d1 = b - a, d2 = c - a;
  const Vec3 u = d1.head<3>(), v = d2.head<3>(), normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (squared > 0) {
    // Shares of a point x in the plane are linear in x: s = x . gs, t = x . gt.
    const Vec3 gs = v.cross(normal) / squared, gt = normal.cross(u) / squared;
    const Vec3 slope = d1[3] * gs + d2[3] * gt;
    const double rest = 1 - slope.squaredNorm();
    if (rest > 0) {
      const Vec3 q = p - a.head<3>();
      const double height = std::abs(q.dot(normal)) / std::sqrt(squared);
      const Vec3 x = q + height / std::sqrt(rest) * slope;
      const double s = x.dot(gs), t = x.dot(gt);
      if (s >= 0 && t >= 0 && s + t <= 1) {
        const double d = height * std::sqrt(rest) - q.dot(slope) - a[3];
        // |q - x'| - r(x') = height / sqrt(rest) - a3 - slope.(q + height slope / sqrt(rest))
        if (d < best.distance) {
          best.distance = d;
          best.share = {1 - s - t, s, t};
        }
        return;
      }
    }
  }
  reach_cone(p, a, 0, b, 1, best);
  reach_cone(p, b, 1, c, 2, best);
  reach_cone(p, a, 0, c, 2, best);
}

}  // namespace

Reach reach_of(const Vec3& p, const Primitive& primitive, std::span<const Vec4> balls) {
  Reach best;
  if (primitive[1] == kNone)
    reach_ball(p, balls[primitive[0]], 0, best);
  else if (primitive[2] == kNone)
    reach_cone(p, balls[primitive[0]], 0, balls[primitive[1]], 1, best);
  else
    reach_slab(p, balls[primitive[0]], balls[primitive[1]], balls[primitive[2]], best);
  return best;
}

PrimitiveTree::PrimitiveTree(std::span<const Primitive> primitives, std::span<const Vec4> balls)
    : primitives_(primitives), balls_(balls), order_(primitives.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  for (const Primitive& primitive : primitives) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const std::uint32_t v : primitive) {
      if (v == kNone) continue;
      low = low.cwiseMin(Vec3(balls[v].head<3>().array() - balls[v][3]));
      high = high.cwiseMax(Vec3(balls[v].head<3>().array() + balls[v][3]));
    }
    low_.push_back(low);
    high_.push_back(high);
  }
  nodes_.emplace_back();
  if (!primitives.empty()) build(0, 0, static_cast<std::uint32_t>(primitives.size()));
  low_.clear();
  high_.clear();
}

void PrimitiveTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t last) {
  Vec3 low = low_[order_[first]], high = high_[order_[first]], least = low + high, most = least;
  for (std::uint32_t i = first; i < last; ++i) {
    low = low.cwiseMin(low_[order_[i]]);
    high = high.cwiseMax(high_[order_[i]]);
    least = least.cwiseMin(low_[order_[i]] + high_[order_[i]]);
    most = most.cwiseMax(low_[order_[i]] + high_[order_[i]]);
  }
  nodes_[node].low = low;
  nodes_[node].high = high;
  if (last - first <= kLeaf) {
    nodes_[node].first = first;
    nodes_[node].count = last - first;
    return;
  }
  int axis = 0;
  (most - least).maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::uint32_t i, std::uint32_t j) {
                     const double x = low_[i][axis] + high_[i][axis], y = low_[j][axis] + high_[j][axis];
                     return x != y ? x < y : i < j;
                   });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = child;
  build(child, first, middle);
  build(child + 1, middle, last);
}

// The signed distance of a box: no primitive inside has a smaller one.
double PrimitiveTree::bound(const Node& node, const Vec3& p) {
  const Vec3 beyond = (node.low - p).cwiseMax(p - node.high);
  const double inside = beyond.maxCoeff();
  return inside <= 0 ? inside : beyond.cwiseMax(0).norm();
}

Reach PrimitiveTree::nearest(const Vec3& p, std::uint32_t guess) const {
  Reach best;
  if (order_.empty()) return best;
  const auto look = [&](std::uint32_t i) {
    const Reach reach = reach_of(p, primitives_[i], balls_);
    if (reach.distance < best.distance || (reach.distance == best.distance && i < best.primitive)) {
      best = reach;
      best.primitive = i;
    }
  };
  if (guess != kNone) look(guess);
  std::array<std::pair<double, std::uint32_t>, 64> stack;
  std::size_t top = 0;
  stack[top++] = {bound(nodes_[0], p), 0};
  while (top > 0) {
    const auto [least, n] = stack[--top];
    if (least > best.distance) continue;
    const Node& node = nodes_[n];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) look(order_[i]);
      continue;
    }
    std::pair<double, std::uint32_t> near{bound(nodes_[node.first], p), node.first},
        far{bound(nodes_[node.first + 1], p), node.first + 1};
    if (far.first < near.first) std::swap(near, far);
    if (far.first <= best.distance) stack[top++] = far;
    if (near.first <= best.distance) stack[top++] = near;
  }
  return best;
}

}  // namespace quench::simplification
