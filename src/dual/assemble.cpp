// SPDX-License-Identifier: Apache-2.0
#include "dual/assemble.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "dual/edge_star.h"
#include "quench/error.h"

namespace quench::dual {
namespace {

std::uint32_t count_up(std::uint32_t& counter) {
  return std::atomic_ref<std::uint32_t>(counter).fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

std::vector<std::uint32_t> order_of(const Cells& cells, std::size_t site_count, Context* context) {
  const std::size_t count = cells.count();
  const std::size_t chunks = base::chunks_for(count);
  std::vector<std::uint32_t> first(site_count + 1, 0), order(count), rank(count);
  base::for_chunks(chunks, context, "merge", 0.75, 0.76, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t p = begin; p < end; ++p) rank[p] = count_up(first[cells.sites[cells.site_begin[p]] + 1]);
  });
  base::prefix_sum(first);
  base::for_chunks(chunks, context, "merge", 0.76, 0.77, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t p = begin; p < end; ++p)
      order[first[cells.sites[cells.site_begin[p]]] + rank[p]] = static_cast<std::uint32_t>(p);
  });
  const std::size_t site_chunks = base::chunks_for(site_count);
  base::for_chunks(site_chunks, context, "merge", 0.77, 0.78, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(site_count, chunk, site_chunks);
    for (std::size_t s = begin; s < end; ++s)
      if (first[s + 1] - first[s] > 1)
        std::sort(order.begin() + first[s], order.begin() + first[s + 1], [&](std::uint32_t a, std::uint32_t b) {
          return std::ranges::lexicographical_compare(cells.sites_of(a), cells.sites_of(b));
        });
  });
  return order;
}

Cells permuted(const Cells& cells, std::span<const std::uint32_t> order, Context* context) {
  const std::size_t count = cells.count();
  std::vector<std::uint32_t> rank(count);
  Cells result;
  result.site_begin.resize(count + 1);
  result.neighbour_begin.resize(count + 1);
  result.hull.resize(count);
  base::for_indices(count, [&](std::size_t r) {
    rank[order[r]] = static_cast<std::uint32_t>(r);
    result.site_begin[r + 1] = static_cast<std::uint32_t>(cells.sites_of(order[r]).size());
    result.neighbour_begin[r + 1] = static_cast<std::uint32_t>(cells.neighbours_of(order[r]).size());
    result.hull[r] = cells.hull[order[r]];
  });
  tbb::parallel_invoke(
      [&] {
        base::prefix_sum(result.site_begin);
        result.sites.resize(result.site_begin.back());
      },
      [&] {
        base::prefix_sum(result.neighbour_begin);
        result.neighbours.resize(result.neighbour_begin.back());
      });
  const std::size_t chunks = base::chunks_for(count);
  base::for_chunks(chunks, context, "merge", 0.78, 0.8, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(count, chunk, chunks);
    for (std::size_t r = begin; r < end; ++r) {
      std::ranges::copy(cells.sites_of(order[r]), result.sites.begin() + result.site_begin[r]);
      std::uint32_t at = result.neighbour_begin[r];
      for (const std::uint32_t n : cells.neighbours_of(order[r])) result.neighbours[at++] = n < kPruned ? rank[n] : n;
    }
  });
  return result;
}

namespace {

// Walks around the edges of a range of polytopes. A Delaunay edge whose star of polytopes closes is a face of the core;
// it belongs to its smallest polytope, so a walk ends where it meets a smaller one than it started at.
class EdgeStarWalker {
 public:
  // Faces in the order they are found.
  struct Faces {
    std::vector<std::array<std::uint32_t, 2>> sites;  // ascending
    std::vector<std::uint32_t> offsets{0}, corners;   // cyclic order of polytopes, from the smallest

    std::span<const std::uint32_t> corners_of(std::size_t face) const {
      return {corners.data() + offsets[face], corners.data() + offsets[face + 1]};
    }
  };

  EdgeStarWalker(const Cells& cells, const Hulls& hulls) : cells_(cells), hulls_(hulls) {}

  Faces run(std::size_t first, std::size_t last) {
    faces_.sites.reserve((last - first) * 5 / 4);
    faces_.offsets.reserve((last - first) * 5 / 4);
    faces_.corners.reserve((last - first) * 6);
    for (std::size_t p = first; p < last; ++p) {
      const auto polytope = static_cast<std::uint32_t>(p);
      const Hull& hull = hulls_[cells_.hull[p]];
      const auto neighbours = cells_.neighbours_of(polytope);
      for (std::uint32_t halfedge = 0; halfedge < hull.origin.size(); ++halfedge) {
        const std::uint32_t a = hull.origin[halfedge], b = hull.origin[hull.next(halfedge)];
        if (a > b) continue;
        // Both polytopes next to it in the star.
        const std::uint32_t n = neighbours[hull.facet[halfedge]], m = neighbours[hull.facet[hull.twin[halfedge]]];
        if (n < polytope || m < polytope || n >= kPruned || m >= kPruned) continue;
        walk(polytope, halfedge, cells_.sites_of(polytope)[a], cells_.sites_of(polytope)[b]);
      }
    }
    return std::move(faces_);
  }

 private:
  void walk(std::uint32_t start, std::uint32_t halfedge, std::uint32_t a, std::uint32_t b) {
    star_.assign(1, start);
    for (std::uint32_t polytope = start;;) {
      const std::uint32_t next = cells_.neighbours_of(polytope)[hulls_[cells_.hull[polytope]].facet[halfedge]];
      if (next == start) break;
      if (next >= kPruned || next < start) return;
      halfedge = halfedge_after(cells_, hulls_, polytope, next, b);
      if (star_.size() > cells_.count()) star_does_not_close();
      star_.push_back(next);
      polytope = next;
    }
    faces_.sites.push_back({a, b});
    faces_.corners.insert(faces_.corners.end(), star_.begin(), star_.end());
    base::check_index(faces_.corners.size());
    faces_.offsets.push_back(static_cast<std::uint32_t>(faces_.corners.size()));
  }

  const Cells& cells_;
  const Hulls& hulls_;
  std::vector<std::uint32_t> star_;
  Faces faces_;
};

class Assembly {
 public:
  Assembly(Cells cells, const Hulls& hulls, std::size_t site_count, bool complete, Context* context)
      : cells_(std::move(cells)), hulls_(hulls), site_count_(site_count), complete_(complete), context_(context) {}

  DualComplex run() {
    dual_.complex.vertex_count = cells_.count();
    collect_edges();
    collect_faces();
    dual_.vertex_site_offsets = std::move(cells_.site_begin);
    dual_.vertex_sites = std::move(cells_.sites);
    cells_ = {};
    sort_faces();
    store_faces();
    return std::move(dual_);
  }

 private:
  using Faces = EdgeStarWalker::Faces;
  struct FaceKey {
    std::uint32_t list, face;  // in found_
  };

  // Pairs of polytopes that share a facet, sorted.
  void collect_edges() {
    const std::size_t chunks = base::chunks_for(cells_.count());
    edge_begin_.assign(std::size_t{cells_.count()} + 1, 0);
    const auto for_larger = [&](std::size_t p, const auto& visit) {
      for (const std::uint32_t n : cells_.neighbours_of(static_cast<std::uint32_t>(p))) {
        if (n == kUnmatched && complete_)
          throw Error(ErrorCode::invariant, "a facet of the voxel core's dual is unmatched");
        if (n < kPruned && n > p) visit(n);
      }
    };
    base::for_chunks(chunks, context_, "merge", 0.8, 0.81, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(cells_.count(), chunk, chunks);
      for (std::size_t p = first; p < last; ++p) for_larger(p, [&](std::uint32_t) { ++edge_begin_[p + 1]; });
    });
    base::prefix_sum(edge_begin_);
    auto& edges = dual_.complex.edges;
    edges.resize(edge_begin_.back());
    base::for_chunks(chunks, context_, "merge", 0.81, 0.83, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(cells_.count(), chunk, chunks);
      for (std::size_t p = first; p < last; ++p) {
        std::uint32_t e = edge_begin_[p];
        for_larger(p, [&](std::uint32_t n) { edges[e++] = {static_cast<std::uint32_t>(p), n}; });
        std::sort(edges.begin() + edge_begin_[p], edges.begin() + e);
      }
    });
  }

  void collect_faces() {
    const std::size_t chunks = base::chunks_for(cells_.count());
    found_.resize(chunks);
    base::for_chunks(chunks, context_, "merge", 0.83, 0.9, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(cells_.count(), chunk, chunks);
      found_[chunk] = EdgeStarWalker(cells_, hulls_).run(first, last);
    });
  }

  // Puts them into buckets by their smaller sites, then sorts each.
  void sort_faces() {
    std::vector<std::uint32_t> bucket(site_count_ + 1, 0);
    base::for_chunks(found_.size(), context_, "merge", 0.9, 0.91, [&](std::size_t list) {
      for (const auto& s : found_[list].sites) count_up(bucket[s[0] + 1]);
    });
    base::prefix_sum(bucket);
    order_.resize(bucket.back());
    std::vector<std::uint32_t> next(bucket.begin(), bucket.end() - 1);
    base::for_chunks(found_.size(), context_, "merge", 0.91, 0.92, [&](std::size_t list) {
      for (std::uint32_t f = 0; f < found_[list].sites.size(); ++f)
        order_[count_up(next[found_[list].sites[f][0]])] = {static_cast<std::uint32_t>(list), f};
    });
    const std::size_t chunks = base::chunks_for(site_count_);
    base::for_chunks(chunks, context_, "merge", 0.92, 0.93, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(site_count_, chunk, chunks);
      for (std::size_t s = first; s < last; ++s)
        std::ranges::sort(order_.begin() + bucket[s], order_.begin() + bucket[s + 1], {},
                          [&](const FaceKey& key) { return found_[key.list].sites[key.face][1]; });
    });
  }

  void store_faces() {
    CellComplex& complex = dual_.complex;
    const std::size_t count = order_.size(), chunks = base::chunks_for(count);
    tbb::parallel_invoke([&] { complex.face_offsets.assign(count + 1, 0); }, [&] { dual_.face_sites.resize(count); });
    const auto for_faces = [&](double begin, double end, const auto& visit) {
      base::for_chunks(chunks, context_, "merge", begin, end, [&](std::size_t chunk) {
        const auto [first, last] = base::part_of(count, chunk, chunks);
        for (std::size_t f = first; f < last; ++f) visit(f, found_[order_[f].list], order_[f].face);
      });
    };
    for_faces(0.93, 0.94, [&](std::size_t f, const Faces& faces, std::uint32_t face) {
      dual_.face_sites[f] = faces.sites[face];
      complex.face_offsets[f + 1] = static_cast<std::uint32_t>(faces.corners_of(face).size());
    });
    base::prefix_sum(complex.face_offsets);
    tbb::parallel_invoke([&] { complex.face_vertices.resize(complex.face_offsets.back()); },
                         [&] { complex.face_edges.resize(complex.face_offsets.back()); });
    for_faces(0.94, 1, [&](std::size_t f, const Faces& faces, std::uint32_t face) {
      const auto corners = faces.corners_of(face);
      std::size_t place = complex.face_offsets[f];
      for (std::size_t i = 0; i < corners.size(); ++i, ++place) {
        complex.face_vertices[place] = corners[i];
        complex.face_edges[place] = edge_between(corners[i], corners[i + 1 == corners.size() ? 0 : i + 1]);
      }
    });
  }

  std::uint32_t edge_between(std::uint32_t u, std::uint32_t v) const {
    const std::uint32_t low = std::min(u, v), high = std::max(u, v);
    for (std::uint32_t edge = edge_begin_[low]; edge < edge_begin_[low + 1]; ++edge)
      if (dual_.complex.edges[edge][1] == high) return edge;
    throw Error(ErrorCode::invariant, "consecutive corners of a face of the voxel core do not share an edge");
  }

  Cells cells_;
  const Hulls& hulls_;
  const std::size_t site_count_;
  const bool complete_;  // no facet may be unmatched
  Context* context_;
  DualComplex dual_;
  std::vector<std::uint32_t> edge_begin_;  // edge_begin_[v]: the first edge whose smaller end is v
  std::vector<Faces> found_;
  std::vector<FaceKey> order_;
};

}  // namespace

DualComplex assemble(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context) {
  cells = permuted(cells, order_of(cells, site_count, context), context);
  return Assembly(std::move(cells), hulls, site_count, true, context).run();
}

DualComplex assemble_part(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context) {
  return Assembly(std::move(cells), hulls, site_count, false, context).run();
}

}  // namespace quench::dual
