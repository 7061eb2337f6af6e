// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/csr.h"
#include "quench/axis.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// The surface of the envelope of a medial mesh in patches, each of one cell: two planes of a slab, the arcs of a cone
/// and the directions of a ball that no cell beside it covers. What cells farther away cover is not taken off.
class Patches {
 public:
  /// `mesh` must outlive it.
  explicit Patches(const MedialAxis& mesh);

  /// The sum of squared distances of a ball from the planes that touch the patches of the cells around a vertex,
  /// weighted by area: a third of each slab, half of each cone. O(cells around it).
  Quadric quadric(std::uint32_t v) const;
  double area() const;
  /// Points of the patches in steps of so much area, each at a place of its own in its patch.
  std::vector<Vec3> points(double step) const;

 private:
  struct Slab {
    std::array<Vec3, 2> normals;
    double area = 0;  // of each side; 0: none, one ball covers the others
  };
  /// An arc of directions around an edge: from an angle on, so far.
  struct Arc {
    double from, width;
  };
  struct Cone {
    Vec3 along, u, v;  // directions n(angle) = slope along + rest (cos u + sin v)
    double slope = 0, rest = 0;
    double height = 0;          // of the highest triangle on the edge
    double area_of_radian = 0;  // for the mean radius 1
    std::vector<Arc> arcs;
  };
  /// Calls take(area, point_at) for every patch, point_at(s, t) with numbers between 0 and 1.
  template <class Take>
  void for_patches(const Take& take) const;

  Vec4 ball(std::uint32_t v) const { return ball_of(mesh_.points[v], mesh_.radius[v]); }
  Slab slab(std::uint32_t f) const;
  Cone cone(std::uint32_t e) const;
  bool is_covered(std::uint32_t v, const Vec3& direction) const;
  static void keep_uncovered(std::vector<Arc>& arcs);

  const MedialAxis& mesh_;
  base::Csr<std::uint32_t> faces_of_edge_, faces_of_vertex_, edges_of_vertex_;
  std::vector<Vec3> directions_;
};

}  // namespace quench::simplification
