// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::shape {

/// Whether a vertex of a surface in lattice coordinates lies inside a cell, not on an edge between voxel centres.
inline bool is_inside_cell(const Vec3& p) {
  const auto between = [](double x) { return x - 0.5 != std::floor(x - 0.5); };
  return between(p[0]) && between(p[1]) && between(p[2]);
}

/// The fans of triangles that SurfaceLayers makes: around a vertex inside a cell, which is the last corner of its
/// triangles, a loop of vertices on edges. Tubes are no fans. 4 bytes for each corner and 28 per fan.
class SurfaceFans {
 public:
  struct Fan {
    std::uint32_t middle, first, size;  ///< the vertex inside; triangles [first, first + size)
  };

  explicit SurfaceFans(const TriangleMesh& mesh);

  const std::vector<Fan>& fans() const { return fans_; }
  /// The fans that share an edge with a fan; kNone stands for a tube.
  std::span<const std::uint32_t> neighbours(const Fan& fan) const { return {neighbour_.data() + fan.first, fan.size}; }
  /// Calls visit(fan) for every fan around a vertex on an edge.
  template <class Visit>
  void for_fans_around(std::size_t vertex, const Visit& visit) const {
    for (std::uint32_t i = begin_[vertex]; i < begin_[vertex + 1]; ++i) visit(fan_of_[rim_[i]]);
  }

 private:
  void list_rims(const TriangleMesh& mesh);

  std::vector<Fan> fans_;
  std::vector<std::uint32_t> fan_of_, neighbour_;  // of every triangle; of its edge between two edge vertices
  std::vector<std::uint32_t> begin_, rim_;         // the triangles that begin at every vertex
};

/// Loops of three and four vertices do without the vertex inside where it is within `tolerance` of the plane through
/// them; the surface stays a closed manifold. `fans`: of the mesh, whose vertices may have moved since. O(n).
void flatten_fans(TriangleMesh& mesh, const SurfaceFans& fans, double tolerance);

/// Drops the vertices that no triangle has; order stays.
void drop_unused_points(TriangleMesh& mesh);

}  // namespace quench::shape
