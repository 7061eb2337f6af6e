// SPDX-License-Identifier: Apache-2.0
#include "peeling/dual_from_cells.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "lattice/polytopes.h"
#include "quench/error.h"

namespace quench::peeling {
namespace {

using lattice::RawFaces;

// Sorts the cells by their site lists.
Cells sorted(Cells cells, std::size_t site_count, Context* context) {
  const std::size_t count = cells.count();
  const std::size_t chunks = base::chunks_for(count);
  std::vector<std::uint32_t> first(site_count + 1, 0), order(count), rank(count);
  base::for_chunks(chunks, context, "merge", 0.75, 0.76, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t c = begin; c < end; ++c)
      rank[c] = std::atomic_ref<std::uint32_t>(first[cells.sites[cells.site_begin[c]] + 1])
                    .fetch_add(1, std::memory_order_relaxed);
  });
  lattice::prefix_sum(first);
  base::for_chunks(chunks, context, "merge", 0.76, 0.77, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t c = begin; c < end; ++c)
      order[first[cells.sites[cells.site_begin[c]]] + rank[c]] = static_cast<std::uint32_t>(c);
  });
  Cells result;
  result.site_begin.resize(count + 1);
  result.neighbour_begin.resize(count + 1);
  result.hull.resize(count);
  const std::size_t site_chunks = base::chunks_for(site_count);
  base::for_chunks(site_chunks, context, "merge", 0.77, 0.78, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(site_count, chunk, site_chunks);
    for (std::size_t s = begin; s < end; ++s) {
      if (first[s + 1] - first[s] > 1)
        std::sort(order.begin() + first[s], order.begin() + first[s + 1], [&](std::uint32_t a, std::uint32_t b) {
          return std::ranges::lexicographical_compare(cells.sites_of(a), cells.sites_of(b));
        });
      for (std::uint32_t r = first[s]; r < first[s + 1]; ++r) {
        rank[order[r]] = r;
        result.site_begin[r + 1] = static_cast<std::uint32_t>(cells.sites_of(order[r]).size());
        result.neighbour_begin[r + 1] = static_cast<std::uint32_t>(cells.neighbours_of(order[r]).size());
        result.hull[r] = cells.hull[order[r]];
      }
    }
  });
  tbb::parallel_invoke(
      [&] {
        lattice::prefix_sum(result.site_begin);
        result.sites.resize(result.site_begin.back());
      },
      [&] {
        lattice::prefix_sum(result.neighbour_begin);
        result.neighbours.resize(result.neighbour_begin.back());
      });
  base::for_chunks(chunks, context, "merge", 0.78, 0.8, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t r = begin; r < end; ++r) {
      std::ranges::copy(cells.sites_of(order[r]), result.sites.begin() + result.site_begin[r]);
      std::uint32_t at = result.neighbour_begin[r];
      for (const std::uint32_t n : cells.neighbours_of(order[r])) {
        if (n == kOpen) throw Error(ErrorCode::invariant, "a facet of the voxel core's dual stays open");
        result.neighbours[at++] = n == kBoundary ? n : rank[n];
      }
    }
  });
  return result;
}

// Pairs of cells that share a facet, sorted. Returns per cell the first edge whose smaller end it is.
std::vector<std::uint32_t> collect_edges(const Cells& cells, CellComplex& complex, Context* context) {
  const std::size_t chunks = base::chunks_for(cells.count());
  std::vector<std::uint32_t> begin(std::size_t{cells.count()} + 1, 0);
  const auto above = [&](std::size_t c, const auto& visit) {
    for (const std::uint32_t n : cells.neighbours_of(static_cast<std::uint32_t>(c)))
      if (n != kBoundary && n > c) visit(n);
  };
  base::for_chunks(chunks, context, "merge", 0.8, 0.81, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(cells.count(), chunk, chunks);
    for (std::size_t c = first; c < last; ++c) above(c, [&](std::uint32_t) { ++begin[c + 1]; });
  });
  lattice::prefix_sum(begin);
  complex.edges.resize(begin.back());
  base::for_chunks(chunks, context, "merge", 0.81, 0.83, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(cells.count(), chunk, chunks);
    for (std::size_t c = first; c < last; ++c) {
      std::uint32_t e = begin[c];
      above(c, [&](std::uint32_t n) { complex.edges[e++] = {static_cast<std::uint32_t>(c), n}; });
      std::sort(complex.edges.begin() + begin[c], complex.edges.begin() + e);
    }
  });
  return begin;
}

// Walks around the edges of the cells of a range. An edge whose ring of cells closes is a face of the core; it belongs
// to its smallest cell, so a walk ends where it meets a smaller one than it started at.
class RingWalker {
 public:
  RingWalker(const Cells& cells, const Hulls& hulls) : cells_(cells), hulls_(hulls) {}

  RawFaces run(std::size_t first, std::size_t last) {
    faces_.sites.reserve((last - first) * 5 / 4);
    faces_.offsets.reserve((last - first) * 5 / 4);
    faces_.corners.reserve((last - first) * 6);
    for (std::size_t c = first; c < last; ++c) {
      const auto cell = static_cast<std::uint32_t>(c);
      const Hull& hull = hulls_[cells_.hull[c]];
      const auto neighbours = cells_.neighbours_of(cell);
      for (std::uint32_t side = 0; side < hull.from.size(); ++side) {
        const std::uint32_t a = hull.from[side], b = hull.from[hull.next(side)];
        if (a > b) continue;
        // Both cells next to it in the ring.
        const std::uint32_t n = neighbours[hull.facet_of[side]], m = neighbours[hull.facet_of[hull.mate[side]]];
        if (n < cell || m < cell || n == kBoundary || m == kBoundary) continue;
        walk(cell, side, cells_.sites_of(cell)[a], cells_.sites_of(cell)[b]);
      }
    }
    return std::move(faces_);
  }

 private:
  [[noreturn]] static void does_not_close() {
    throw Error(ErrorCode::invariant, "the cells around an edge of the voxel core's dual are no ring");
  }

  // A side from a to b of a facet, seen from outside its cell, has the facet on its left: crossing it leads
  // counter-clockwise around the direction from a to b.
  void walk(std::uint32_t start, std::uint32_t side, std::uint32_t a, std::uint32_t b) {
    ring_.assign(1, start);
    for (std::uint32_t cell = start;;) {
      const std::uint32_t next = cells_.neighbours_of(cell)[hulls_[cells_.hull[cell]].facet_of[side]];
      if (next == start) break;
      if (next == kBoundary || next < start) return;
      const Hull& hull = hulls_[cells_.hull[next]];
      const auto neighbours = cells_.neighbours_of(next);
      const auto sites = cells_.sites_of(next);
      // Two cells share one facet; in it the edge runs from b to a.
      std::uint32_t facet = 0;
      while (facet < neighbours.size() && neighbours[facet] != cell) ++facet;
      if (facet == neighbours.size()) does_not_close();
      std::uint32_t from_b = hull.facet_begin[facet];
      const std::uint32_t end = hull.facet_begin[facet + 1];
      while (from_b < end && sites[hull.from[from_b]] != b) ++from_b;
      if (from_b == end || ring_.size() > cells_.count()) does_not_close();
      side = hull.mate[from_b];
      ring_.push_back(next);
      cell = next;
    }
    faces_.sites.push_back({a, b});
    faces_.corners.insert(faces_.corners.end(), ring_.begin(), ring_.end());
    lattice::check_index(faces_.corners.size());
    faces_.offsets.push_back(static_cast<std::uint32_t>(faces_.corners.size()));
  }

  const Cells& cells_;
  const Hulls& hulls_;
  std::vector<std::uint32_t> ring_;
  RawFaces faces_;
};

}  // namespace

lattice::DualComplex dual_from_cells(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context) {
  cells = sorted(std::move(cells), site_count, context);
  lattice::DualComplex dual;
  dual.complex.vertex_count = cells.count();
  const std::vector<std::uint32_t> edge_begin = collect_edges(cells, dual.complex, context);
  const std::size_t chunks = base::chunks_for(cells.count());
  std::vector<RawFaces> faces(chunks);
  base::for_chunks(chunks, context, "merge", 0.83, 0.9, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(cells.count(), chunk, chunks);
    faces[chunk] = RingWalker(cells, hulls).run(first, last);
  });
  dual.vertex_site_offsets = std::move(cells.site_begin);
  dual.vertex_sites = std::move(cells.sites);
  cells = {};
  lattice::store_faces(faces, site_count, edge_begin, dual, context);
  return dual;
}

}  // namespace quench::peeling
