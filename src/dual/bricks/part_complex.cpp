// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "dual/assemble.h"
#include "dual/bricks/part.h"
#include "dual/bricks/part_order.h"
#include "dual/edge_star.h"
#include "quench/error.h"

namespace quench::dual::bricks {
namespace {

// Which cells may have others around them that are not known.
class IncompleteCells {
 public:
  IncompleteCells(const Part& part, const Hulls& hulls, PartComplex& complex)
      : cells_(part.found.cells), unmatched_(part.found.unmatched), hulls_(hulls), complex_(complex) {}

  void run(std::span<const std::uint32_t> edge_of) {
    complex_.edge_incomplete.assign(complex_.dual.complex.edges.size(), 0);
    complex_.vertex_incomplete.assign(cells_.count(), 0);
    for (const UnmatchedFacet& f : unmatched_) {
      if (f.polytope == kNone) continue;
      complex_.vertex_incomplete[f.polytope] = 1;
      const Hull& hull = hulls_[cells_.hull[f.polytope]];
      const auto sites = cells_.sites_of(f.polytope);
      for (std::uint32_t h = hull.facet_begin[f.facet]; h < hull.facet_begin[f.facet + 1]; ++h) {
        const std::uint32_t a = sites[hull.origin[hull.next(h)]], b = sites[hull.origin[h]];
        if (a < b) walk(f.polytope, hull.twin[h], b, edge_of);
      }
    }
    for (std::size_t e = 0; e < complex_.edge_incomplete.size(); ++e)
      if (complex_.edge_incomplete[e])
        for (const std::uint32_t v : complex_.dual.complex.edges[e]) complex_.vertex_incomplete[v] = 1;
  }

 private:
  // From one end of an open star counter-clockwise to the other, which has its larger site on the other side, so that
  // each is walked once. Its links are incomplete if that end is an unmatched facet, too.
  void walk(std::uint32_t polytope, std::uint32_t halfedge, std::uint32_t b, std::span<const std::uint32_t> edge_of) {
    arc_.clear();
    for (;;) {
      const std::uint32_t link = cells_.neighbour_begin[polytope] + hulls_[cells_.hull[polytope]].facet[halfedge];
      const std::uint32_t next = cells_.neighbours[link];
      if (next == kUnmatched) break;
      if (next >= kPruned) return;
      arc_.push_back(edge_of[link]);
      if (arc_.size() > cells_.count()) star_does_not_close();
      halfedge = halfedge_after(cells_, hulls_, polytope, next, b);
      polytope = next;
    }
    for (const std::uint32_t e : arc_) complex_.edge_incomplete[e] = 1;
  }

  const Cells& cells_;
  const std::vector<UnmatchedFacet>& unmatched_;
  const Hulls& hulls_;
  PartComplex& complex_;
  std::vector<std::uint32_t> arc_;
};

// The edge of each link, kNone where there is none; sets link_of and twin_of.
std::vector<std::uint32_t> edges_of_links(const Cells& cells, PartComplex& complex) {
  const auto& edges = complex.dual.complex.edges;
  std::vector<std::uint32_t> begin(std::size_t{cells.count()} + 1, 0), edge_of(cells.neighbours.size(), kNone);
  for (const auto& e : edges) ++begin[e[0] + 1];
  base::prefix_sum(begin);
  complex.link_of.resize(edges.size());
  complex.twin_of.resize(edges.size());
  for (std::uint32_t p = 0; p < cells.count(); ++p)
    for (std::uint32_t link = cells.neighbour_begin[p]; link < cells.neighbour_begin[p + 1]; ++link) {
      const std::uint32_t n = cells.neighbours[link];
      if (n >= kPruned) continue;
      const auto [low, high] = std::minmax(p, n);
      const auto first = edges.begin() + begin[low], last = edges.begin() + begin[low + 1];
      const auto edge =
          static_cast<std::uint32_t>(std::lower_bound(first, last, std::array{low, high}) - edges.begin());
      edge_of[link] = edge;
      (p < n ? complex.link_of : complex.twin_of)[edge] = link;
    }
  return edge_of;
}

}  // namespace

PartComplex complex_of(const Part& part, const Hulls& hulls, Context* context) {
  PartComplex complex;
  complex.dual = assemble_part(part.found.cells, hulls, part.sites.size(), context);
  IncompleteCells(part, hulls, complex).run(edges_of_links(part.found.cells, complex));
  return complex;
}

namespace {

void check_closed(const Part& part, const PartComplex& complex, const Removal& removal) {
  const auto& edges = complex.dual.complex.edges;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (!removal.edge[e] && (removal.vertex[edges[e][0]] || removal.vertex[edges[e][1]]))
      throw Error(ErrorCode::invariant, "an edge of the voxel core would be left without an end");
  for (const UnmatchedFacet& f : part.found.unmatched)
    if (f.polytope != kNone && removal.vertex[f.polytope])
      throw Error(ErrorCode::invariant, "a vertex of the voxel core that is not complete would be removed");
}

// The values of faces that stay; both lists are in order.
void keep_values(Part& part, const PartComplex& complex, const Removal& removal) {
  const CellComplex& cells = complex.dual.complex;
  std::vector<FaceValue> kept;
  std::size_t face = 0;
  for (const FaceValue& value : part.faces) {
    while (complex.dual.face_sites[face] < value.sites) ++face;
    const auto first = cells.face_edges.begin() + cells.face_offsets[face],
               last = cells.face_edges.begin() + cells.face_offsets[face + 1];
    if (std::none_of(first, last, [&](std::uint32_t e) { return removal.edge[e] != 0; })) kept.push_back(value);
  }
  part.faces = std::move(kept);
}

template <class T>
void keep_groups(std::vector<T>& list, const std::vector<std::uint32_t>& begin, const std::vector<std::uint8_t>& gone) {
  std::size_t to = 0;
  for (std::size_t p = 0; p < gone.size(); ++p)
    if (!gone[p])
      for (std::uint32_t i = begin[p]; i < begin[p + 1]; ++i) list[to++] = list[i];
  list.resize(to);
}

template <class T>
void keep_entries(std::vector<T>& list, const std::vector<std::uint8_t>& gone) {
  std::size_t to = 0;
  for (std::size_t p = 0; p < gone.size(); ++p)
    if (!gone[p]) list[to++] = list[p];
  list.resize(to);
}

void keep_polytopes(Part& part, const std::vector<std::uint8_t>& gone) {
  Cells& cells = part.found.cells;
  keep_groups(part.link_lambda, cells.neighbour_begin, gone);
  keep_groups(part.link_detail, cells.neighbour_begin, gone);
  keep_groups(part.contact, cells.site_begin, gone);
  keep_entries(part.vertex_lambda, gone);
  keep_entries(part.vertex_detail, gone);
  std::vector<std::uint32_t> number(gone.size());
  std::uint32_t next = 0;
  for (std::size_t p = 0; p < gone.size(); ++p) number[p] = gone[p] ? kPruned : next++;
  Cells kept;
  for (std::uint32_t p = 0; p < cells.count(); ++p) {
    if (gone[p]) continue;
    const auto neighbours = cells.neighbours_of(p);
    const std::uint32_t copy =
        kept.add(cells.sites_of(p), cells.hull[p], static_cast<std::uint32_t>(neighbours.size()));
    std::ranges::transform(neighbours, kept.neighbours_of(copy).begin(),
                           [&](std::uint32_t n) { return n < kPruned ? number[n] : n; });
  }
  cells = std::move(kept);
  for (UnmatchedFacet& f : part.found.unmatched)
    if (f.polytope != kNone) f.polytope = number[f.polytope];
}

}  // namespace

void remove(Part& part, const PartComplex& complex, const Removal& removal, std::uint64_t faces) {
  check_closed(part, complex, removal);
  keep_values(part, complex, removal);
  for (std::size_t e = 0; e < removal.edge.size(); ++e)
    if (removal.edge[e])
      part.found.cells.neighbours[complex.link_of[e]] = part.found.cells.neighbours[complex.twin_of[e]] = kPruned;
  part.extend();
  keep_polytopes(part, removal.vertex);
  drop_unnamed_sites(part);
  part.pruned.vertices += static_cast<std::uint64_t>(std::ranges::count(removal.vertex, 1));
  part.pruned.edges += static_cast<std::uint64_t>(std::ranges::count(removal.edge, 1));
  part.pruned.faces += faces;
}

}  // namespace quench::dual::bricks
