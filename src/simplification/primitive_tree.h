// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// Corners of a slab, a cone (third none) or a ball (second none, too).
using Primitive = std::array<std::uint32_t, 3>;

/// Where a primitive reaches furthest at a point: its signed distance, negative inside.
struct Reach {
  double distance = std::numeric_limits<double>::infinity();
  std::uint32_t primitive = kNone;
  std::array<double, 3> share{0, 0, 0};  ///< of the corners: the ball that reaches furthest
};

Reach reach_of(const Vec3& p, const Primitive& primitive, std::span<const Vec4> balls);

/// Primitives in a binary tree of boxes.
class PrimitiveTree {
 public:
  /// Both must outlive the tree.
  PrimitiveTree(std::span<const Primitive> primitives, std::span<const Vec4> balls);

  /// That of the primitive of the smallest signed distance.
  Reach nearest(const Vec3& p, std::uint32_t guess = kNone) const;

 private:
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0, count = 0;  // of order_, in leaves; else the first child, and 0
  };
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t last);
  static double bound(const Node& node, const Vec3& p);

  std::span<const Primitive> primitives_;
  std::span<const Vec4> balls_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<Vec3> low_, high_;
};

}  // namespace quench::simplification
