// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "quench/geometry.h"

namespace quench::surface {

/// Where on a triangle a point lies: 0 inside, 1 to 3 on the side opposite corner 0 to 2, 4 to 6 at corner 0 to 2.
using Feature = std::uint8_t;
inline constexpr Feature kInterior = 0, kSide = 1, kCorner = 4;

/// Triangles in a binary tree of boxes, sorted along a Z-order curve. O(n log n) to build, on all threads.
class TriangleTree {
 public:
  struct Near {
    Vec3 point = Vec3::Zero();
    double squared = 0;              ///< of the distance
    std::uint32_t triangle = kNone;  ///< its row in the mesh
    Feature feature = kInterior;
  };

  explicit TriangleTree(const TriangleMesh& mesh);

  /// The nearest point of a triangle not farther than the root of `squared_limit`; triangle is kNone where there is
  /// none. Of several at the same distance any, but always the same.
  Near nearest(const Vec3& p, double squared_limit) const;

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Box {  // rounded outwards, relative to origin_
    std::array<float, 3> low, high;
  };
  struct Triangle {
    Vec3 a, ab, ac;  // relative to origin_
    std::uint32_t row;
  };
  double squared_distance(const Box& box, const Vec3& p) const;

  Vec3 origin_ = Vec3::Zero();
  std::vector<Box> boxes_;  // children of box n: 2n and 2n + 1; the leaves are the last half
  std::vector<Triangle> triangles_;
  std::size_t leaves_ = 1;
};

}  // namespace quench::surface
