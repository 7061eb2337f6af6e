// SPDX-License-Identifier: Apache-2.0
#include "lattice/cells.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

#include "lattice/polytopes.h"
#include "parallel.h"

namespace quench::lattice {
namespace {

// Pairs of polytopes that share a facet, sorted. Returns per polytope the first edge whose smaller end it is.
std::vector<std::uint32_t> collect_edges(const Polytopes& polytopes, CellComplex& complex, Context* context) {
  const std::size_t chunks = chunks_for(polytopes.count());
  std::vector<std::vector<std::uint32_t>> upper(chunks);  // the larger ends
  std::vector<std::uint32_t> begin(std::size_t{polytopes.count()} + 1, 0);
  for_chunks(chunks, context, "merge", 0.7, 0.75, [&](std::size_t chunk) {
    const auto [first, last] = part_of(polytopes.count(), chunk, chunks);
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
  for_chunks(chunks, context, "merge", 0.75, 0.76, [&](std::size_t chunk) {
    const auto [first, last] = part_of(polytopes.count(), chunk, chunks);
    std::size_t next = 0;
    for (std::size_t p = first; p < last; ++p)
      for (std::uint32_t e = begin[p]; e < begin[p + 1]; ++e)
        complex.edges[e] = {static_cast<std::uint32_t>(p), upper[chunk][next++]};
    std::vector<std::uint32_t>().swap(upper[chunk]);
  });
  return begin;
}

// The six edges (i, j) of a tetrahedron and the other two corners (k, l), (i, j, k, l) an even permutation.
constexpr std::uint8_t kEdge[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                      {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
// Bits of the edges of the facet opposite to each corner.
constexpr std::uint8_t kFacetEdges[4] = {0b111000, 0b100110, 0b010101, 0b001011};
constexpr std::uint8_t kEdgeOf[4][4] = {{0, 0, 1, 2}, {0, 0, 3, 4}, {1, 3, 0, 5}, {2, 4, 5, 0}};

// Faces in the order they are found.
struct RawFaces {
  std::vector<std::array<std::uint32_t, 2>> sites;
  std::vector<std::uint32_t> offsets{0}, corners;
};

// Walks around the edges of the triangulation inside O whose first tetrahedron is in [first, last): ranges share the
// work. An edge is an edge of the Delaunay complex, not a diagonal of a polytope or facet, exactly when at least three
// polytopes surround it. Each polytope is convex, so its tetrahedra are consecutive around the edge.
class FaceCollector {
 public:
  // `done`, bit e of tetrahedron t: its edge kEdge[e] was walked around. A collector uses those of its range.
  FaceCollector(const Polytopes& polytopes, std::size_t first, std::size_t last, RawHugeVector<std::uint8_t>& done)
      : polytopes_(polytopes), first_(first), last_(last), done_(done) {}

  RawFaces run() {
    for (std::size_t t = first_; t < last_; ++t) {
      // Edges on the boundary of O have no face; most of them are found here.
      const auto& neighbour = polytopes_.tetrahedra[t].neighbour;
      std::uint32_t boundary = 0;
      for (std::size_t i = 0; i < 4; ++i) boundary |= neighbour[i] == kNone ? kFacetEdges[i] : 0u;
      done_[t] = static_cast<std::uint8_t>(boundary);
    }
    for (std::size_t t = first_; t < last_; ++t)
      for (std::uint32_t e = 0; e < 6; ++e)
        if (!(done_[t] >> e & 1)) walk_around(static_cast<std::uint32_t>(t), e);
    return std::move(faces_);
  }

 private:
  void walk_around(std::uint32_t start, std::uint32_t e) {
    const auto& corner = polytopes_.tetrahedra[start].corner;
    const auto& index = kEdge[e];
    std::uint32_t a = corner[index[0]], b = corner[index[1]], leave = index[2], keep = index[3];
    if (a > b) {
      std::swap(a, b);
      std::swap(leave, keep);
    }
    ring_.assign(1, polytopes_.polytope_of[start]);
    earlier_ = false;
    if (!walk(start, a, b, leave, corner[keep])) {
      walk(start, a, b, keep, corner[leave]);  // an edge on the boundary of O: only to mark the other side as done
      return;
    }
    if (earlier_) return;
    if (ring_.size() > 1 && ring_.front() == ring_.back()) ring_.pop_back();
    if (ring_.size() < 3) return;
    std::rotate(ring_.begin(), std::min_element(ring_.begin(), ring_.end()), ring_.end());
    faces_.sites.push_back({a, b});
    faces_.corners.insert(faces_.corners.end(), ring_.begin(), ring_.end());
    check_index(faces_.corners.size());
    faces_.offsets.push_back(static_cast<std::uint32_t>(faces_.corners.size()));
  }

  // Collects the polytopes around (a, b) until the walk is back (true) or leaves O (false).
  bool walk(std::uint32_t start, std::uint32_t a, std::uint32_t b, std::uint32_t leave, std::uint32_t keep) {
    for (std::uint32_t t = start;;) {
      const std::uint32_t across = polytopes_.tetrahedra[t].neighbour[leave];
      if (across == kNone) return false;
      t = across >> 2;
      if (t == start) return true;
      const auto& corner = polytopes_.tetrahedra[t].corner;
      std::uint32_t ia = 0, ib = 0;
      for (std::uint32_t i = 0; i < 4; ++i) {
        if (corner[i] == a) ia = i;
        if (corner[i] == b) ib = i;
        if (corner[i] == keep) leave = i;
      }
      keep = corner[across & 3];
      if (t < first_)
        earlier_ = true;  // the edge belongs to an earlier range
      else if (t < last_)
        done_[t] = static_cast<std::uint8_t>(done_[t] | 1u << kEdgeOf[ia][ib]);
      if (polytopes_.polytope_of[t] != ring_.back()) ring_.push_back(polytopes_.polytope_of[t]);
    }
  }

  const Polytopes& polytopes_;
  std::size_t first_, last_;
  RawHugeVector<std::uint8_t>& done_;
  bool earlier_ = false;
  std::vector<std::uint32_t> ring_;
  RawFaces faces_;
};

std::vector<RawFaces> collect_faces(const Polytopes& polytopes, Context* context) {
  // Few chunks: edges between them are walked around once in each.
  const std::size_t count = polytopes.tetrahedra.size();
  const std::size_t chunks = std::min<std::size_t>(
      chunks_for(count), 4 * static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency())));
  RawHugeVector<std::uint8_t> done(count);
  std::vector<RawFaces> faces(chunks);
  for_chunks(chunks, context, "merge", 0.76, 0.9, [&](std::size_t chunk) {
    const auto [first, last] = part_of(count, chunk, chunks);
    faces[chunk] = FaceCollector(polytopes, first, last, done).run();
  });
  return faces;
}

// Sorts the faces by their sites and looks up their edges.
void store_faces(const std::vector<RawFaces>& raw, std::size_t site_count, const std::vector<std::uint32_t>& edge_begin,
                 DualComplex& dual, Context* context) {
  struct Name {
    std::uint32_t list, face;
  };
  std::vector<std::uint32_t> bucket(site_count + 1, 0);
  for_chunks(raw.size(), context, "merge", 0.9, 0.91, [&](std::size_t list) {
    for (const auto& s : raw[list].sites)
      std::atomic_ref<std::uint32_t>(bucket[s[0] + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  prefix_sum(bucket);
  const std::size_t count = bucket.back();
  std::vector<Name> order(count);
  {
    std::vector<std::uint32_t> next(bucket.begin(), bucket.end() - 1);
    for_chunks(raw.size(), context, "merge", 0.91, 0.92, [&](std::size_t list) {
      for (std::uint32_t f = 0; f < raw[list].sites.size(); ++f)
        order[std::atomic_ref<std::uint32_t>(next[raw[list].sites[f][0]]).fetch_add(1, std::memory_order_relaxed)] = {
            static_cast<std::uint32_t>(list), f};
    });
  }
  CellComplex& complex = dual.complex;
  complex.face_offsets.assign(count + 1, 0);
  dual.face_sites.resize(count);
  const std::size_t chunks = chunks_for(site_count);
  for_chunks(chunks, context, "merge", 0.92, 0.94, [&](std::size_t chunk) {
    const auto [first, last] = part_of(site_count, chunk, chunks);
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
  complex.face_vertices.resize(complex.face_offsets.back());
  complex.face_edges.resize(complex.face_offsets.back());
  for_chunks(chunks, context, "merge", 0.94, 1, [&](std::size_t chunk) {
    const auto [first, last] = part_of(count, chunk, chunks);
    for (std::size_t f = first; f < last; ++f) {
      const RawFaces& faces = raw[order[f].list];
      const std::span<const std::uint32_t> corners(faces.corners.data() + faces.offsets[order[f].face],
                                                   faces.corners.data() + faces.offsets[order[f].face + 1]);
      std::size_t place = complex.face_offsets[f];
      for (std::size_t i = 0; i < corners.size(); ++i, ++place) {
        const std::uint32_t u = corners[i], v = corners[i + 1 == corners.size() ? 0 : i + 1];
        const std::uint32_t low = std::min(u, v), high = std::max(u, v);
        std::uint32_t edge = edge_begin[low];
        while (edge < edge_begin[low + 1] && complex.edges[edge][1] != high) ++edge;
        if (edge == edge_begin[low + 1])
          throw Error(ErrorCode::invariant, "a face of the voxel core has a side that is no edge");
        complex.face_vertices[place] = u;
        complex.face_edges[place] = edge;
      }
    }
  });
}

}  // namespace

DualComplex dual_complex(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                         std::span<const LatticePoint> sites, Context* context) {
  DualComplex dual;
  std::vector<std::uint32_t> edge_begin;
  std::vector<RawFaces> raw;
  {
    Polytopes polytopes = polytopes_inside(shape, std::move(delaunay), sites, context);
    dual.complex.vertex_count = polytopes.count();
    edge_begin = collect_edges(polytopes, dual.complex, context);
    raw = collect_faces(polytopes, context);
    dual.vertex_site_offsets = std::move(polytopes.site_offsets);
    dual.vertex_sites = std::move(polytopes.sites);
  }
  store_faces(raw, sites.size(), edge_begin, dual, context);
  return dual;
}

}  // namespace quench::lattice
