// SPDX-License-Identifier: Apache-2.0
#include "lattice/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace quench::lattice {
namespace {

constexpr std::uint32_t kOutside = kNone - 1;

// Turns counts[i+1] = size of bucket i into offsets.
void prefix_sum(std::vector<std::uint32_t>& counts) {
  std::uint64_t sum = 0;
  for (std::uint32_t& c : counts) {
    sum += c;
    if (sum >= kOutside)
      throw Error(ErrorCode::failed, "the voxel core outgrows 32-bit indices; use a lower resolution");
    c = static_cast<std::uint32_t>(sum);
  }
}

// Polytopes of the Delaunay complex inside O.
class Merger {
 public:
  Merger(const VoxelShape& shape, const Delaunay& delaunay, Context* context)
      : shape_(shape), delaunay_(delaunay), cell_of(delaunay.tetrahedra().size(), kNone) {
    const auto& tetrahedra = delaunay.tetrahedra();
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      if ((t & 0xFFFFF) == 0) checkpoint(context, "merge", 0.4 * t / static_cast<double>(tetrahedra.size()));
      if (cell_of[t] != kNone) continue;
      if (tetrahedra[t].corner[0] == kNone || delaunay.touches_box(tetrahedra[t]) || !inside(tetrahedra[t]))
        cell_of[t] = kOutside;
      else
        flood(t);
    }
  }

  std::uint32_t cell_count() const { return static_cast<std::uint32_t>(offsets.size() - 1); }

  // Numbers the cells by their site lists: by smallest site through counting, then by comparison.
  void sort_cells(std::size_t site_count) {
    const std::uint32_t count = cell_count();
    std::vector<std::uint32_t> bucket(site_count + 1, 0);
    for (std::uint32_t c = 0; c < count; ++c) ++bucket[sites[offsets[c]] + 1];
    prefix_sum(bucket);
    std::vector<std::uint32_t> order(count);
    {
      std::vector<std::uint32_t> next(bucket.begin(), bucket.end() - 1);
      for (std::uint32_t c = 0; c < count; ++c) order[next[sites[offsets[c]]]++] = c;
    }
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
      return std::lexicographical_compare(sites.begin() + offsets[a], sites.begin() + offsets[a + 1],
                                          sites.begin() + offsets[b], sites.begin() + offsets[b + 1]);
    };
    for (std::size_t s = 0; s < site_count; ++s)
      std::sort(order.begin() + bucket[s], order.begin() + bucket[s + 1], less);

    std::vector<std::uint32_t> rank(count), new_offsets{0}, new_sites;
    new_offsets.reserve(count + 1);
    new_sites.reserve(sites.size());
    for (std::uint32_t r = 0; r < count; ++r) {
      rank[order[r]] = r;
      new_sites.insert(new_sites.end(), sites.begin() + offsets[order[r]], sites.begin() + offsets[order[r] + 1]);
      new_offsets.push_back(static_cast<std::uint32_t>(new_sites.size()));
    }
    offsets.swap(new_offsets);
    sites.swap(new_sites);
    for (std::uint32_t& c : cell_of)
      if (c < kOutside) c = rank[c];
  }

 private:
  // The boundary faces and edges of O are Delaunay (Yan 2018, Thm. 2.4.1), so a tetrahedron is inside O or outside as
  // a whole, and the voxel that contains its centroid tells. A centroid between voxels needs no care: it is not on the
  // boundary of O, so all voxels around it agree.
  bool inside(const Tetrahedron& t) const {
    std::int64_t x = 0, y = 0, z = 0;
    for (std::uint32_t c : t.corner) {
      const Point& p = delaunay_.points()[c];
      x += p.x;
      y += p.y;
      z += p.z;
    }
    return shape_.contains(x >> 2, y >> 2, z >> 2);
  }

  void flood(std::uint32_t seed) {
    const auto& tetrahedra = delaunay_.tetrahedra();
    const auto& points = delaunay_.points();
    const std::uint32_t cell = cell_count();
    if (cell >= kOutside - 1) throw Error(ErrorCode::failed, "the voxel core has more than 2^32 vertices");
    stack_.assign(1, seed);
    cell_of[seed] = cell;
    const std::size_t first = sites.size();
    for (std::size_t s = 0; s < stack_.size(); ++s) {
      const Tetrahedron& t = tetrahedra[stack_[s]];
      for (std::uint32_t i = 0; i < 4; ++i) sites.push_back(points[t.corner[i]].site);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t n = t.neighbour[i] >> 2;
        if (cell_of[n] != kNone) continue;
        const std::uint32_t apex = tetrahedra[n].corner[t.neighbour[i] & 3];
        if (apex < Delaunay::kBoxPoints) continue;
        // A facet on the boundary of O is a facet of the Delaunay complex, so the two sides of it are never
        // cospherical.
        if (delaunay_.predicates().in_sphere(points[t.corner[0]], points[t.corner[1]], points[t.corner[2]],
                                             points[t.corner[3]], points[apex]) == 0) {
          cell_of[n] = cell;
          stack_.push_back(n);
        }
      }
    }
    const auto begin = sites.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, sites.end());
    sites.erase(std::unique(begin, sites.end()), sites.end());
    if (sites.size() >= kOutside)
      throw Error(ErrorCode::failed, "the voxel core outgrows 32-bit indices; use a lower resolution");
    offsets.push_back(static_cast<std::uint32_t>(sites.size()));
  }

  const VoxelShape& shape_;
  const Delaunay& delaunay_;
  std::vector<std::uint32_t> stack_;

 public:
  std::vector<std::uint32_t> cell_of;     // per tetrahedron; kOutside outside O
  std::vector<std::uint32_t> offsets{0};  // per cell, into sites
  std::vector<std::uint32_t> sites;
};

// Pairs of cells that share a facet, sorted. `begin[c]` is the first edge whose smaller end is c.
void collect_edges(const Delaunay& delaunay, const Merger& cells, CellComplex& complex,
                   std::vector<std::uint32_t>& begin) {
  const auto& tetrahedra = delaunay.tetrahedra();
  std::vector<std::uint32_t> offsets(cells.cell_count() + 1, 0);
  const auto each_pair = [&](auto&& visit) {
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      const std::uint32_t a = cells.cell_of[t];
      if (a >= kOutside) continue;
      for (std::uint32_t n : tetrahedra[t].neighbour) {
        const std::uint32_t b = cells.cell_of[n >> 2];
        if (b < kOutside && a < b) visit(a, b);
      }
    }
  };
  each_pair([&](std::uint32_t a, std::uint32_t) { ++offsets[a + 1]; });
  prefix_sum(offsets);
  std::vector<std::uint32_t> upper(offsets.back());
  {
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    each_pair([&](std::uint32_t a, std::uint32_t b) { upper[next[a]++] = b; });
  }
  begin.assign(1, 0);
  begin.reserve(offsets.size());
  // A facet of more than three corners is met once per triangle of it.
  std::size_t count = 0;
  for (std::uint32_t a = 0; a < cells.cell_count(); ++a) {
    const auto first = upper.begin() + offsets[a];
    std::sort(first, upper.begin() + offsets[a + 1]);
    const auto last = std::unique(first, upper.begin() + offsets[a + 1]);
    std::move(first, last, upper.begin() + static_cast<std::ptrdiff_t>(count));
    count += static_cast<std::size_t>(last - first);
    begin.push_back(static_cast<std::uint32_t>(count));
  }
  complex.edges.reserve(count);
  for (std::uint32_t a = 0; a < cells.cell_count(); ++a)
    for (std::uint32_t e = begin[a]; e < begin[a + 1]; ++e) complex.edges.push_back({a, upper[e]});
}

// The six edges (i, j) of a tetrahedron and the other two corners (k, l), (i, j, k, l) an even permutation.
constexpr std::uint8_t kEdge[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                      {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
constexpr std::uint8_t kEdgeOf[4][4] = {{0, 0, 1, 2}, {0, 0, 3, 4}, {1, 3, 0, 5}, {2, 4, 5, 0}};

// Faces in the order they are found.
struct RawFaces {
  std::vector<std::array<std::uint32_t, 2>> sites;
  std::vector<std::uint32_t> offsets{0}, corners;
};

// Walks around every edge of the triangulation inside O. An edge is an edge of the Delaunay complex, not a diagonal of
// a polytope or facet, exactly when at least three polytopes surround it. Each polytope is convex, so its tetrahedra
// are consecutive around the edge.
RawFaces collect_faces(const Delaunay& delaunay, const Merger& cells, Context* context) {
  const auto& tetrahedra = delaunay.tetrahedra();
  const auto& points = delaunay.points();
  RawFaces faces;
  std::vector<std::uint8_t> done(tetrahedra.size(), 0);  // bit e: edge kEdge[e] of the tetrahedron was walked around
  std::vector<std::uint32_t> ring;
  for (std::uint32_t start = 0; start < tetrahedra.size(); ++start) {
    if ((start & 0xFFFFF) == 0)
      checkpoint(context, "merge", 0.5 + 0.4 * start / static_cast<double>(tetrahedra.size()));
    if (cells.cell_of[start] >= kOutside) continue;
    for (std::uint32_t e = 0; e < 6; ++e) {
      if (done[start] >> e & 1) continue;
      const Tetrahedron& first = tetrahedra[start];
      std::uint32_t a = first.corner[kEdge[e][0]], b = first.corner[kEdge[e][1]];
      std::uint32_t leave_index = kEdge[e][2], keep = first.corner[kEdge[e][3]];
      if (points[a].site > points[b].site) {
        std::swap(a, b);
        leave_index = kEdge[e][3];
        keep = first.corner[kEdge[e][2]];
      }
      ring.assign(1, cells.cell_of[start]);
      bool closed = true;
      for (std::uint32_t t = start;;) {
        const std::uint32_t across = tetrahedra[t].neighbour[leave_index];
        t = across >> 2;
        if (t == start) break;
        const std::uint32_t cell = cells.cell_of[t];
        if (cell >= kOutside) {  // an edge on the boundary of O
          closed = false;
          break;
        }
        const Tetrahedron& next = tetrahedra[t];
        std::uint32_t ia = 0, ib = 0;
        for (std::uint32_t i = 0; i < 4; ++i) {
          if (next.corner[i] == a) ia = i;
          if (next.corner[i] == b) ib = i;
          if (next.corner[i] == keep) leave_index = i;
        }
        keep = next.corner[across & 3];
        done[t] = static_cast<std::uint8_t>(done[t] | 1u << kEdgeOf[ia][ib]);
        if (cell != ring.back()) ring.push_back(cell);
      }
      if (!closed) continue;
      if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
      if (ring.size() < 3) continue;
      std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
      faces.sites.push_back({points[a].site, points[b].site});
      faces.corners.insert(faces.corners.end(), ring.begin(), ring.end());
      if (faces.corners.size() >= kOutside)
        throw Error(ErrorCode::failed, "the voxel core outgrows 32-bit indices; use a lower resolution");
      faces.offsets.push_back(static_cast<std::uint32_t>(faces.corners.size()));
    }
  }
  return faces;
}

// Sorts the faces by their sites and looks up their edges.
void store_faces(const RawFaces& raw, std::size_t site_count, const std::vector<std::uint32_t>& edge_begin,
                 DualComplex& dual) {
  const std::size_t count = raw.sites.size();
  std::vector<std::uint32_t> bucket(site_count + 1, 0);
  for (const auto& s : raw.sites) ++bucket[s[0] + 1];
  prefix_sum(bucket);
  std::vector<std::uint32_t> order(count);
  {
    std::vector<std::uint32_t> next(bucket.begin(), bucket.end() - 1);
    for (std::uint32_t f = 0; f < count; ++f) order[next[raw.sites[f][0]]++] = f;
  }
  for (std::size_t s = 0; s < site_count; ++s)
    std::sort(order.begin() + bucket[s], order.begin() + bucket[s + 1],
              [&](std::uint32_t a, std::uint32_t b) { return raw.sites[a][1] < raw.sites[b][1]; });
  CellComplex& complex = dual.complex;
  complex.face_offsets.reserve(count + 1);
  complex.face_vertices.reserve(raw.corners.size());
  complex.face_edges.reserve(raw.corners.size());
  dual.face_sites.reserve(count);
  for (std::uint32_t f : order) {
    const std::span<const std::uint32_t> corners(raw.corners.data() + raw.offsets[f],
                                                 raw.corners.data() + raw.offsets[f + 1]);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::uint32_t u = corners[i], v = corners[i + 1 == corners.size() ? 0 : i + 1];
      const std::uint32_t low = std::min(u, v), high = std::max(u, v);
      std::uint32_t edge = edge_begin[low];
      while (edge < edge_begin[low + 1] && complex.edges[edge][1] != high) ++edge;
      if (edge == edge_begin[low + 1])
        throw Error(ErrorCode::invariant, "a face of the voxel core has a side that is no edge");
      complex.face_vertices.push_back(u);
      complex.face_edges.push_back(edge);
    }
    complex.face_offsets.push_back(static_cast<std::uint32_t>(complex.face_vertices.size()));
    dual.face_sites.push_back(raw.sites[f]);
  }
}

}  // namespace

DualComplex dual_complex(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay, std::size_t site_count,
                         Context* context) {
  DualComplex dual;
  std::vector<std::uint32_t> edge_begin;
  RawFaces raw;
  {
    Merger cells(shape, *delaunay, context);
    cells.sort_cells(site_count);
    dual.complex.vertex_count = cells.cell_count();
    collect_edges(*delaunay, cells, dual.complex, edge_begin);
    raw = collect_faces(*delaunay, cells, context);
    dual.vertex_site_offsets = std::move(cells.offsets);
    dual.vertex_sites = std::move(cells.sites);
  }
  delaunay.reset();
  store_faces(raw, site_count, edge_begin, dual);
  checkpoint(context, "merge", 1);
  return dual;
}

}  // namespace quench::lattice
