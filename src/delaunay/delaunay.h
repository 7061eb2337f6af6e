// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "delaunay/bounds.h"
#include "delaunay/insertion.h"
#include "quench/context.h"

namespace quench::delaunay {

/// Exact incremental Delaunay triangulation of lattice points: Bowyer-Watson with walks, in rounds along a Hilbert
/// curve.
///
/// The sites are enclosed by a box of 8 extra points (the first 8 of `points`), so there is no infinite vertex. The box
/// is so far away that no empty ball with its centre in O reaches it: such a ball extends beyond O by less than half
/// the diagonal of the largest voxel face (its sphere meets the boundary of O within a voxel face, none of whose
/// corners it contains).
///
/// Ties: a point on the sphere of a tetrahedron is NOT in conflict with it. No perturbation is needed: the set of
/// strict conflicts is star-shaped around the new point p, and p is never coplanar with a facet of its boundary, since
/// a p in the plane of a facet f is strictly inside the balls on both sides of f or of neither (both meet the plane in
/// the same disk). So any order gives a triangulation of the same Delaunay complex; which one of the triangulations of
/// a cospherical set arises depends on the order and is undone by merging (polytopes.h).
///
/// Several threads insert at once (insertion.h); the complex does not depend on it, the triangulation of cospherical
/// sets and the numbers of tetrahedra do.
///
/// About 220 bytes per site.
class Delaunay {
 public:
  Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Context* context)
      : Delaunay(sites, spacing, bounds_of(sites), context) {}
  /// The box encloses all points between `bounds`, as all sites do: it is as far away from them.
  Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, const Bounds& bounds,
           Context* context)
      : Delaunay(sites, spacing, enclosing_box(bounds, spacing), context) {}

  static constexpr std::uint32_t kBoxPoints = 8;
  /// 4 * tetrahedron must fit 32 bits; there were fewer than 7 tetrahedra per site on every shape measured.
  static constexpr std::size_t kMostSites = (std::size_t{1} << 30) / 7;
  const base::HugeVector<Point>& points() const { return triangulation_.points; }
  /// Dead slots have corner[0] == kNone.
  const base::RawHugeVector<Tetrahedron>& tetrahedra() const { return triangulation_.tetrahedra; }
  /// Moves the arrays out; the rest of this object must not be used afterwards.
  base::HugeVector<Point> take_points() { return std::move(triangulation_.points); }
  base::RawHugeVector<Tetrahedron> take_tetrahedra() { return std::move(triangulation_.tetrahedra); }
  const Predicates& predicates() const { return triangulation_.predicates; }
  static bool touches_box(const Tetrahedron& t) {
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
  static Box enclosing_box(const Bounds& bounds, const std::array<std::int64_t, 3>& spacing);
  Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, const Box& box,
           Context* context);

  void cut_box();
  void insert_all(Context* context);
  void insert_together(std::uint32_t begin, std::uint32_t end, std::uint32_t workers, Context* context);

  Triangulation triangulation_;
};

}  // namespace quench::delaunay
