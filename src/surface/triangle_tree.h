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

/// Triangles in a balanced tree of boxes and slabs with four children each. O(n log n) to build, on all threads; about
/// 140 bytes per triangle.
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
  static constexpr std::size_t kLeaf = 4, kChildren = 4;
  /// The boxes of the children of a node, rounded outwards, relative to origin_: lower and upper side by axis and
  /// child; and slabs across their mean normals, thinner than the boxes: from the middle of a ball or tube all boxes
  /// along it are equally far, slabs much less so.
  struct Boxes {
    float low[3][kChildren], high[3][kChildren];
    float normal[3][kChildren], least[kChildren], most[kChildren];
  };
  struct Triangle {
    Vec3 a, ab, ac;  // relative to origin_
    std::uint32_t row;
  };
  void fill_leaf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& order, std::size_t leaf, Boxes& boxes,
                 std::size_t child);
  void fill_slab(std::size_t first, std::size_t last, Boxes& boxes, std::size_t child) const;

  Vec3 origin_ = Vec3::Zero();
  double rounding_ = 0;              // what distances to boxes may be wrong by
  std::vector<Boxes> nodes_;         // children of node n: 4 n + 1 to 4 n + 4; those behind the last node are leaves
  std::vector<Triangle> triangles_;  // by leaf, in equal parts
  std::size_t leaves_ = 0;
};

}  // namespace quench::surface
