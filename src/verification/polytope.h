// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "verification/nearest_sites.h"

namespace quench::verification {

/// The convex hull of cospherical sites: the Delaunay polytope of a Voronoi vertex. Every site is a corner, a facet is
/// the cycle of all its sites, counterclockwise seen from outside. Exact; O(sites * hull edges). Empty when the
/// sites are coplanar.
std::vector<Ids> hull_facets(const Sites& sites, const Ids& cospherical);

/// Cocircular sites as the corners of their convex polygon, in cyclic order.
Ids convex_cycle(const Sites& sites, const Ids& cocircular);
/// The sides of that polygon, each by its two corners in ascending order.
std::vector<Ids> sides_of_polygon(const Sites& sites, const Ids& cocircular);

/// Recomputes lambda from site sets alone, in world units.
class LambdaOfSites {
 public:
  LambdaOfSites(const VoxelShape& shape, const Sites& sites, double unit, bool ball_rule)
      : shape_(shape), sites_(sites), unit_(unit), ball_rule_(ball_rule) {}

  /// A unit lattice edge whose four voxels (in a plane two pixels) are neither all in nor all out: its dual face (edge)
  /// is not in the core.
  bool is_boundary_edge(std::uint32_t a, std::uint32_t b) const;
  /// A unit lattice square between two voxels of which one is in: its dual edge is not in the core.
  bool is_boundary_square(const Ids& cycle) const;
  /// Whether the dual edge has no face in the core.
  bool has_only_boundary_edges(const Ids& cycle) const;

  /// Of a face, in a plane of an edge, by its two sites.
  double face(std::uint32_t a, std::uint32_t b) const;
  /// Of an edge by the cycle of its sites; in a plane of a vertex by that of its polygon.
  double edge(const Ids& cycle) const;
  double vertex(const Ids& cospherical, const std::vector<Ids>& facets) const;

 private:
  double ball_of_circle(const Ids& cycle) const;
  double ball_of_sphere(const Ids& cospherical, const std::vector<Ids>& facets) const;

  const VoxelShape& shape_;
  const Sites& sites_;
  double unit_;
  bool ball_rule_;
};

}  // namespace quench::verification
