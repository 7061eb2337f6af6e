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

/// Polygons opened lately: fire visits the same few again and again.
class PolygonViews {
 public:
  explicit PolygonViews(const Site& site) : site_(site) {}
  const PolygonView& operator()(std::uint32_t face) {
    PolygonView& view = views_[face % kKept];
    if (view.face != face) view.load(face, site_.complex, site_.points, site_.network, site_.planes);
    return view;
  }

 private:
  static constexpr std::size_t kKept = 1024;
  const Site& site_;
  std::array<PolygonView, kKept> views_;
};

/// Calls visit(view, place) for every polygon of a state's sector that is wanted(face).
template <class Wanted, class Visit>
void for_each_place(const Site& site, std::uint32_t state, PolygonViews& views, const Wanted& wanted,
                    const Visit& visit) {
  if (site.is_vertex(state)) {
    for (std::uint32_t i = site.links.corner_offsets[state]; i < site.links.corner_offsets[state + 1]; ++i) {
      const std::uint32_t c = site.links.corner_list[i], f = site.network.corner_face[c];
      if (wanted(f)) visit(views(f), Place{c - site.complex.face_offsets[f], 0});
    }
    return;
  }
  const Links::Edge& edge = site.links.edges[site.edge_of(state)];
  const std::uint32_t from_base = state - edge.state_base, along = from_base / edge.sectors + 1;
  const auto visit_side = [&](std::uint32_t c) {
    const std::uint32_t f = site.network.corner_face[c];
    if (!wanted(f)) return;
    const PolygonView& view = views(f);
    const std::uint32_t i = c - site.complex.face_offsets[f];
    visit(view, Place{i, view.sides[i].along_edge(along)});
  };
  if (edge.sectors > 1) {
    visit_side(site.network.side_list[edge.first_side + from_base % edge.sectors]);
  } else {
    for (std::uint32_t r = 0; r < edge.degree; ++r) visit_side(edge.corner[r]);
  }
}
template <class Visit>
void for_each_place(const Site& site, std::uint32_t state, PolygonViews& views, const Visit& visit) {
  for_each_place(
      site, state, views, [](std::uint32_t) { return true; }, visit);
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
