// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "burning/domain.h"

namespace quench::burning {

struct Point {
  double x, y;
};
inline double distance(const Point& a, const Point& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

/// A polygon with its nodes: sides i with nodes k = 0 .. pieces, their positions in the polygon's plane, their states
/// in the polygon's sectors and their numbers in the network.
class PolygonView {
 public:
  using Side = Polygons::Side;
  PolygonView(const BurnDomain& domain, std::uint32_t f)
      : face(f),
        flat(domain.polygons.flat[f]),
        domain_(domain),
        sides_(domain.polygons.sides.data() + domain.complex.face_offsets[f]),
        count_(domain.complex.face_offsets[f + 1] - domain.complex.face_offsets[f]) {}

  const std::uint32_t face;
  const bool flat;

  std::uint32_t side_count() const { return count_; }
  /// The corner at which side i starts.
  std::uint32_t corner(std::uint32_t i) const { return domain_.complex.face_offsets[face] + i; }
  const Side& side(std::uint32_t i) const { return sides_[i]; }
  std::uint32_t after(std::uint32_t i) const { return i + 1 == count_ ? 0 : i + 1; }
  std::uint32_t before(std::uint32_t i) const { return i == 0 ? count_ - 1 : i - 1; }

  Point at(std::uint32_t i, double k) const { return {sides_[i].x + k * sides_[i].dx, sides_[i].y + k * sides_[i].dy}; }
  std::uint32_t state(std::uint32_t i, std::uint32_t k) const {
    const Side& s = sides_[i];
    if (k == 0) return s.corner_state;
    if (k == s.pieces) return sides_[after(i)].corner_state;
    return s.state_base + (s.along_edge(k) - 1) * s.sectors + s.rank;
  }
  /// The number of a node in the network.
  std::uint32_t node(std::uint32_t i, std::uint32_t k) const {
    const Side& s = sides_[i];
    const std::uint32_t along = s.along_edge(k);
    if (along == 0) return domain_.complex.edges[s.edge][0];
    if (along == s.pieces) return domain_.complex.edges[s.edge][1];
    return domain_.network.node_base[s.edge] + along - 1;
  }
  /// Place of a node in the cycle of the polygon's nodes.
  std::uint32_t place(std::uint32_t i, std::uint32_t k) const {
    if (k == sides_[i].pieces) {
      i = after(i);
      k = 0;
    }
    for (std::uint32_t s = 0; s < i; ++s) k += sides_[s].pieces;
    return k;
  }

  /// Calls visit(k, state) for nodes first .. last of a side.
  template <class Visit>
  void nodes(std::uint32_t i, std::uint32_t first, std::uint32_t last, const Visit& visit) const {
    const Side& s = sides_[i];
    const std::uint32_t inner_end = last == s.pieces ? last : last + 1;
    if (first < inner_end) {
      std::uint32_t state_k = state(i, first);
      const std::uint32_t step = s.forward ? s.sectors : 0u - s.sectors;
      for (std::uint32_t k = first; k < inner_end; ++k, state_k += step) visit(k, state_k);
    }
    if (last == s.pieces) visit(last, sides_[after(i)].corner_state);
  }

 private:
  const BurnDomain& domain_;
  const Side* sides_;
  std::uint32_t count_;
};

/// The place of a node on the boundary of a polygon: node k of a side, k < pieces. A corner is node 0 of the side that
/// starts there.
struct Place {
  std::uint32_t side, k;
  bool is_corner() const { return k == 0; }
};

/// Calls visit(view, place of the node) for every polygon of a state's sector for which wanted(face).
template <class Wanted, class Visit>
void for_each_place(const BurnDomain& domain, std::uint32_t state, const Wanted& wanted, const Visit& visit) {
  if (domain.is_vertex(state)) {
    for (const std::uint32_t c : domain.links.corners[state]) {
      const std::uint32_t f = domain.network.corner_face[c];
      if (wanted(f)) visit(PolygonView(domain, f), Place{c - domain.complex.face_offsets[f], 0});
    }
    return;
  }
  const Links::Edge& edge = domain.links.edges[domain.edge_of(state)];
  const std::uint32_t from_base = state - edge.state_base;
  const auto visit_side = [&](std::uint32_t c, std::uint32_t f, std::uint32_t along) {
    if (!wanted(f)) return;
    const PolygonView view(domain, f);
    const std::uint32_t i = c - domain.complex.face_offsets[f];
    visit(view, Place{i, view.side(i).along_edge(along)});
  };
  if (edge.degree > 2) {
    const std::uint32_t c = domain.network.edge_corners.items()[edge.first_corner + from_base % edge.degree];
    visit_side(c, domain.network.corner_face[c], from_base / edge.degree + 1);
  } else {
    for (std::uint32_t r = 0; r < edge.degree; ++r) visit_side(edge.corner[r], edge.face[r], from_base + 1);
  }
}
template <class Visit>
void for_each_place(const BurnDomain& domain, std::uint32_t state, const Visit& visit) {
  for_each_place(
      domain, state, [](std::uint32_t) { return true; }, visit);
}

/// Calls visit(side, k) for the two neighbours of a node on the polygon's boundary: the ends of its edge arcs.
template <class Visit>
void for_each_edge_arc(const PolygonView& view, const Place& place, const Visit& visit) {
  visit(place.side, place.k + 1);
  if (place.k > 0) {
    visit(place.side, place.k - 1);
  } else {
    const std::uint32_t before = view.before(place.side);
    visit(before, view.side(before).pieces - 1);
  }
}

/// Calls visit(side, first, last) for the nodes first .. last of every side at which face arcs of a node end: those on
/// none of its own sides. Each node once.
template <class Visit>
void for_each_far_side(const PolygonView& view, const Place& place, const Visit& visit) {
  // The sides after the node's own ones up to the one before them, of which the last node is on an own side.
  const std::uint32_t stop = place.is_corner() ? view.before(place.side) : place.side;
  for (std::uint32_t i = view.after(place.side); i != stop; i = view.after(i)) {
    const std::uint32_t pieces = view.side(i).pieces, last = view.after(i) == stop ? pieces - 1 : pieces;
    if (last >= 1) visit(i, 1u, last);
  }
}

}  // namespace quench::burning
