// SPDX-License-Identifier: Apache-2.0
#include "lattice/cells.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "lattice/polytopes.h"

namespace quench::lattice {
namespace {

// Pairs of polytopes that share a facet, sorted. Returns per polytope the first edge whose smaller end it is.
std::vector<std::uint32_t> collect_edges(const Polytopes& polytopes, CellComplex& complex, Context* context) {
  const std::size_t chunks = base::chunks_for(polytopes.count());
  std::vector<std::vector<std::uint32_t>> upper(chunks);  // the larger ends
  std::vector<std::uint32_t> begin(std::size_t{polytopes.count()} + 1, 0);
  base::for_chunks(chunks, context, "merge", 0.7, 0.75, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(polytopes.count(), chunk, chunks);
    std::vector<std::uint32_t>& ends = upper[chunk];
    for (std::size_t p = first; p < last; ++p) {
      const auto before = static_cast<std::ptrdiff_t>(ends.size());
      for (std::uint32_t m = polytopes.member_offsets[p]; m < polytopes.member_offsets[p + 1]; ++m)
        for (std::uint32_t n : polytopes.tetrahedra[polytopes.members[m]].neighbour)
          if (n != kNone && polytopes.polytope_of[n >> 2] > p) ends.push_back(polytopes.polytope_of[n >> 2]);
      // A facet of more than three corners is met once per triangle of it.
      std::sort(ends.begin() + before, ends.end());
      ends.erase(std::unique(ends.begin() + before, ends.end()), ends.end());
      begin[p + 1] = static_cast<std::uint32_t>(ends.size() - static_cast<std::size_t>(before));
    }
  });
  prefix_sum(begin);
  complex.edges.resize(begin.back());
  base::for_chunks(chunks, context, "merge", 0.75, 0.76, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(polytopes.count(), chunk, chunks);
    std::size_t next = 0;
    for (std::size_t p = first; p < last; ++p)
      for (std::uint32_t e = begin[p]; e < begin[p + 1]; ++e)
        complex.edges[e] = {static_cast<std::uint32_t>(p), upper[chunk][next++]};
    std::vector<std::uint32_t>().swap(upper[chunk]);
  });
  return begin;
}

}  // namespace

void store_faces(const std::vector<RawFaces>& raw, std::size_t site_count, const std::vector<std::uint32_t>& edge_begin,
                 DualComplex& dual, Context* context) {
  struct Name {
    std::uint32_t list, face;
  };
  std::vector<std::uint32_t> bucket(site_count + 1, 0);
  base::for_chunks(raw.size(), context, "merge", 0.9, 0.91, [&](std::size_t list) {
    for (const auto& s : raw[list].sites)
      std::atomic_ref<std::uint32_t>(bucket[s[0] + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  prefix_sum(bucket);
  const std::size_t count = bucket.back();
  std::vector<Name> order(count);
  {
    std::vector<std::uint32_t> next(bucket.begin(), bucket.end() - 1);
    base::for_chunks(raw.size(), context, "merge", 0.91, 0.92, [&](std::size_t list) {
      for (std::uint32_t f = 0; f < raw[list].sites.size(); ++f)
        order[std::atomic_ref<std::uint32_t>(next[raw[list].sites[f][0]]).fetch_add(1, std::memory_order_relaxed)] = {
            static_cast<std::uint32_t>(list), f};
    });
  }
  CellComplex& complex = dual.complex;
  tbb::parallel_invoke([&] { complex.face_offsets.assign(count + 1, 0); }, [&] { dual.face_sites.resize(count); });
  const std::size_t chunks = base::chunks_for(site_count);
  base::for_chunks(chunks, context, "merge", 0.92, 0.94, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(site_count, chunk, chunks);
    for (std::size_t s = first; s < last; ++s) {
      std::sort(order.begin() + bucket[s], order.begin() + bucket[s + 1], [&](const Name& a, const Name& b) {
        return raw[a.list].sites[a.face][1] < raw[b.list].sites[b.face][1];
      });
      for (std::uint32_t f = bucket[s]; f < bucket[s + 1]; ++f) {
        const RawFaces& faces = raw[order[f].list];
        dual.face_sites[f] = faces.sites[order[f].face];
        complex.face_offsets[f + 1] = faces.offsets[order[f].face + 1] - faces.offsets[order[f].face];
      }
    }
  });
  prefix_sum(complex.face_offsets);
  tbb::parallel_invoke([&] { complex.face_vertices.resize(complex.face_offsets.back()); },
                       [&] { complex.face_edges.resize(complex.face_offsets.back()); });
  base::for_chunks(chunks, context, "merge", 0.94, 1, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    for (std::size_t f = first; f < last; ++f) {
      const RawFaces& faces = raw[order[f].list];
      const std::span<const std::uint32_t> corners(faces.corners.data() + faces.offsets[order[f].face],
                                                   faces.corners.data() + faces.offsets[order[f].face + 1]);
      std::size_t place = complex.face_offsets[f];
      for (std::size_t i = 0; i < corners.size(); ++i, ++place) {
        const std::uint32_t u = corners[i], v = corners[i + 1 == corners.size() ? 0 : i + 1];
        complex.face_vertices[place] = u;
        complex.face_edges[place] = edge_between(complex, edge_begin, u, v);
      }
    }
  });
}

std::uint32_t edge_between(const CellComplex& complex, const std::vector<std::uint32_t>& edge_begin, std::uint32_t u,
                           std::uint32_t v) {
  const std::uint32_t low = std::min(u, v), high = std::max(u, v);
  for (std::uint32_t edge = edge_begin[low]; edge < edge_begin[low + 1]; ++edge)
    if (complex.edges[edge][1] == high) return edge;
  throw Error(ErrorCode::invariant, "a face of the voxel core has a side that is no edge");
}

DualComplex dual_complex(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                         std::span<const LatticePoint> sites, Context* context) {
  DualComplex dual;
  std::vector<std::uint32_t> edge_begin;
  std::vector<RawFaces> raw;
  {
    Polytopes polytopes = polytopes_inside(shape, std::move(delaunay), sites, context);
    dual.complex.vertex_count = polytopes.count();
    edge_begin = collect_edges(polytopes, dual.complex, context);
    raw = collect_faces(polytopes, {}, context);
    dual.vertex_site_offsets = std::move(polytopes.site_offsets);
    dual.vertex_sites = std::move(polytopes.sites);
  }
  store_faces(raw, sites.size(), edge_begin, dual, context);
  return dual;
}

}  // namespace quench::lattice
