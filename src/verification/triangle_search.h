// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/geometry.h"

namespace quench::verification {

/// Triangles of a closed surface in a tree by median cuts of their middles. Build O(n log n), 150 bytes per triangle.
class TriangleSearch {
 public:
  explicit TriangleSearch(const TriangleMesh& mesh);

  std::size_t size() const { return triangles_.size(); }
  double longest_side() const { return longest_side_; }
  /// To the nearest triangle; infinite when there is none.
  double distance(const Vec3& p) const;
  /// Whether the winding number is 1, by the crossings along a ray that passes no edge too near.
  bool inside(const Vec3& p) const;

 private:
  struct Triangle {
    Vec3 a, b, c;
  };
  struct Node {
    Vec3 low, high;
    std::uint32_t begin = 0, end = 0;
    std::uint32_t right = 0;  // second child, 0 of a leaf; the first one follows
  };
  struct Crossings {
    std::int64_t sum = 0;
    bool sure = true;
  };
  void build(std::uint32_t begin, std::uint32_t end);
  void find(std::uint32_t node, const Vec3& p, double& squared) const;
  void cross(std::uint32_t node, const Vec3& p, const Vec3& along, Crossings& crossings) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  double longest_side_ = 0;
};

}  // namespace quench::verification
