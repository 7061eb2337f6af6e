// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lattice/huge_pages.h"
#include "lattice/predicates.h"
#include "quench/context.h"

namespace quench::lattice {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A tetrahedron of positive orientation. `neighbour[i]` lies across the facet opposite to corner i and is encoded as
/// 4 * tetrahedron + the index of that facet there; kNone on the hull of the enclosing box. 32 bytes.
struct Tetrahedron {
  std::array<std::uint32_t, 4> corner;
  std::array<std::uint32_t, 4> neighbour;
};

/// Exact incremental Delaunay triangulation of lattice points (algorithm A of the performance notes): Bowyer-Watson
/// with walks, in rounds along a Hilbert curve.
///
/// The sites are enclosed by a box of 8 extra points (the first 8 of `points`), so there is no infinite vertex. The box
/// is so far away that no empty ball with its centre in O reaches it: such a ball pokes out of O by less than half the
/// diagonal of the largest voxel face (its sphere meets the boundary of O within a voxel face, none of whose corners it
/// contains).
///
/// Ties: a point on the sphere of a tetrahedron is NOT in conflict with it. No perturbation is needed: the set of
/// strict conflicts is star-shaped around the new point p, and p is never coplanar with a facet of its boundary, since
/// a p in the plane of a facet f is strictly inside the balls on both sides of f or of neither (both meet the plane in
/// the same disk). So any order gives a triangulation of the same Delaunay complex; which one of the triangulations of
/// a cospherical set arises depends on the order and is undone by merging (cells.h).
///
/// About 2.3 us and 225 bytes per site.
class Delaunay {
 public:
  Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Context* context);

  static constexpr std::uint32_t kBoxPoints = 8;
  const HugeVector<Point>& points() const { return points_; }
  /// Dead slots have corner[0] == kNone.
  const HugeVector<Tetrahedron>& tetrahedra() const { return tetrahedra_; }
  const Predicates& predicates() const { return predicates_; }
  bool touches_box(const Tetrahedron& t) const {
    return std::min({t.corner[0], t.corner[1], t.corner[2], t.corner[3]}) < kBoxPoints;
  }

  /// Throws Error(invariant) naming the first relation that does not hold: orientation, mutual neighbours with equal
  /// facets, empty balls across every facet (which makes the triangulation Delaunay).
  void validate() const;

 private:
  struct Box {
    std::array<std::int64_t, 3> low, high;
    std::int64_t extent;
  };
  static Box enclosing_box(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing);
  Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, const Box& box,
           Context* context);

  void insert(std::uint32_t p);
  std::uint32_t locate(std::uint32_t p);
  void find_cavity(std::uint32_t p, std::uint32_t start);
  void fill_cavity(std::uint32_t p);
  template <class Table>
  void link_new_tetrahedra(Table&& table);
  bool conflicts(std::uint32_t tetrahedron, const Point& p) const {
    const auto& c = tetrahedra_[tetrahedron].corner;
    return predicates_.in_sphere(points_[c[0]], points_[c[1]], points_[c[2]], points_[c[3]], p) > 0;
  }

  // A facet of the cavity: the new tetrahedron on it is its inner tetrahedron with corner `facet` replaced by p.
  struct CavityFacet {
    std::array<std::uint32_t, 4> corner;
    std::uint32_t facet;
    std::uint32_t outside;
    std::uint32_t tetrahedron;  // the new one
  };

  Predicates predicates_;
  HugeVector<Point> points_;
  HugeVector<Tetrahedron> tetrahedra_;
  HugeVector<std::uint8_t> state_;   // per tetrahedron during one insertion: see find_cavity
  HugeVector<std::uint32_t> local_;  // per point: index within the current cavity, or kNone
  std::vector<std::uint32_t> cavity_, rim_, free_, cavity_points_;
  std::vector<CavityFacet> facets_;
  std::vector<std::uint32_t> pair_table_;  // kSmall^2 entries, all kNone between insertions
  std::uint32_t hint_ = 0;
  std::uint32_t random_ = 1;
};

}  // namespace quench::lattice
