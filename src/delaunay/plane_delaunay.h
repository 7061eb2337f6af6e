// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/huge_pages.h"
#include "delaunay/plane_predicates.h"
#include "quench/context.h"
#include "quench/geometry.h"

namespace quench::delaunay {

/// The Delaunay triangulation of sites of the plane as half-edges: 2 e and 2 e + 1 are the two directions of edge e.
/// Orientations are those of the view of plane_predicates.h. 72 bytes per site.
class PlaneDelaunay {
 public:
  struct HalfEdge {
    std::uint32_t origin;          ///< a site; kNone: there is no such edge
    std::uint32_t next, previous;  ///< half-edges around the origin, counter-clockwise and clockwise
  };

  /// `sites` in order of y, x, at least two in every row that has any; they must outlive the triangulation. Divide and
  /// conquer (Guibas, Stolfi 1985), from row to row: O(n log n) in the worst case, on all threads of the arena. Of
  /// cocircular sites any triangulation may come out. Throws Error(failed) when indices outgrow 32 bits.
  PlaneDelaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Context* context);

  std::uint32_t half_edge_count() const { return static_cast<std::uint32_t>(half_edges_.size()); }
  const HalfEdge& operator[](std::uint32_t e) const { return half_edges_[e]; }
  HalfEdge& operator[](std::uint32_t e) { return half_edges_[e]; }
  std::uint32_t origin(std::uint32_t e) const { return half_edges_[e].origin; }
  std::uint32_t destination(std::uint32_t e) const { return half_edges_[e ^ 1].origin; }
  /// The half-edge from the destination that has the same face on its left.
  std::uint32_t next_of_face(std::uint32_t e) const { return half_edges_[e ^ 1].previous; }
  /// Joins the faces on both sides of an edge.
  void remove(std::uint32_t e);

 private:
  /// The triangulation of consecutive rows: an edge of its hull from its first and one from its last site, and the
  /// edges it has left: it has 3 per site, and fewer are used, so there always are some.
  struct Part {
    std::uint32_t first, last;
    std::uint32_t unused, unused_end;  // first and last of a list through `next`
  };
  class Builder;

  base::RawHugeVector<HalfEdge> half_edges_;
};

inline void PlaneDelaunay::remove(std::uint32_t e) {
  for (const std::uint32_t h : {e, e ^ 1}) {
    HalfEdge& half_edge = half_edges_[h];
    half_edges_[half_edge.next].previous = half_edge.previous;
    half_edges_[half_edge.previous].next = half_edge.next;
    half_edge.origin = kNone;
  }
}

}  // namespace quench::delaunay
