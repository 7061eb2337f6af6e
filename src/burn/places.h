// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burn/fire.h"
#include "burn/polygon_view.h"

namespace quench::burning {

/// Where a state's node lies on the boundary of a polygon of its sector: node k of a side, k < pieces. A corner is node
/// 0 of the side that starts there.
struct Place {
  std::uint32_t side, k;
  bool is_corner() const { return k == 0; }
};

/// Calls visit(place) for every polygon of a state's sector, loaded into `view`.
template <class Visit>
void for_each_place(const Site& site, std::uint32_t state, PolygonView& view, const Visit& visit) {
  const auto load = [&](std::uint32_t corner) {
    const std::uint32_t f = site.network.corner_face[corner];
    view.load(f, site.complex, site.points, site.network, site.planes);
    return corner - site.complex.face_offsets[f];
  };
  if (site.is_vertex(state)) {
    for (std::uint32_t i = site.links.corner_offsets[state]; i < site.links.corner_offsets[state + 1]; ++i)
      visit(Place{load(site.links.corner_list[i]), 0});
    return;
  }
  const std::uint32_t e = site.edge_of(state), along = site.place_of(state, e);
  const auto sides = site.network.sides_of(e);
  const std::uint32_t sectors = site.network.sectors_of(e);
  const std::size_t first = sectors > 1 ? (state - site.network.state_base[e]) % sectors : 0;
  const std::size_t end = sectors > 1 ? first + 1 : sides.size();
  for (std::size_t r = first; r < end; ++r) {
    const std::uint32_t i = load(sides[r]);
    visit(Place{i, view.sides[i].along_edge(along)});
  }
}

/// Calls visit(side, k) for the two neighbours of a place on the polygon's boundary: the ends of its edge-arcs.
template <class Visit>
void for_each_edge_arc(const PolygonView& view, const Place& place, const Visit& visit) {
  const Side& side = view.sides[place.side];
  visit(side, place.k + 1);
  if (place.k > 0) {
    visit(side, place.k - 1);
  } else {
    const Side& before = view.sides[view.side_before(place.side)];
    visit(before, before.pieces - 1);
  }
}

/// Calls visit(side, first, last) for the nodes first .. last of every side that face-arcs of a place end in: those on
/// none of its own sides. Each node once.
template <class Visit>
void for_each_far_side(const PolygonView& view, const Place& place, const Visit& visit) {
  // From the side after the place's own to the one before; the last stops short of the place's own side.
  const std::size_t stop = place.is_corner() ? view.side_before(place.side) : place.side;
  for (std::size_t i = view.side_after(place.side); i != stop; i = view.side_after(i)) {
    const Side& side = view.sides[i];
    const std::uint32_t last = view.side_after(i) == stop ? side.pieces - 1 : side.pieces;
    if (last >= 1) visit(side, 1, last);
  }
}

/// All arcs of a place inside a polygon: visit(side, k).
template <class Visit>
void for_each_arc(const PolygonView& view, const Place& place, const Visit& visit) {
  for_each_edge_arc(view, place, visit);
  for_each_far_side(view, place, [&](const Side& side, std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t k = first; k <= last; ++k) visit(side, k);
  });
}

}  // namespace quench::burning
