// SPDX-License-Identifier: Apache-2.0
#include "lattice/cells.h"

#include <algorithm>

#include "lattice/polytopes.h"

namespace quench::lattice {
namespace {

// Pairs of polytopes that share a facet, sorted. Returns per polytope the first edge whose smaller end it is.
std::vector<std::uint32_t> collect_edges(const Polytopes& polytopes, CellComplex& complex) {
  std::vector<std::uint32_t> begin{0}, upper;
  begin.reserve(polytopes.count() + 1);
  std::size_t t = 0;
  for (std::uint32_t p = 0; p < polytopes.count(); ++p) {
    upper.clear();
    for (; t < polytopes.tetrahedra.size() && polytopes.polytope_of[t] == p; ++t)
      for (std::uint32_t n : polytopes.tetrahedra[t].neighbour)
        if (n != kNone && polytopes.polytope_of[n >> 2] > p) upper.push_back(polytopes.polytope_of[n >> 2]);
    // A facet of more than three corners is met once per triangle of it.
    std::sort(upper.begin(), upper.end());
    upper.erase(std::unique(upper.begin(), upper.end()), upper.end());
    for (std::uint32_t q : upper) complex.edges.push_back({p, q});
    check_index(complex.edges.size());
    begin.push_back(static_cast<std::uint32_t>(complex.edges.size()));
  }
  return begin;
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
class FaceCollector {
 public:
  explicit FaceCollector(const Polytopes& polytopes) : polytopes_(polytopes), done_(polytopes.tetrahedra.size(), 0) {}

  RawFaces run(Context* context) {
    const auto& tetrahedra = polytopes_.tetrahedra;
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      if ((t & 0xFFFFF) == 0) checkpoint(context, "merge", 0.5 + 0.4 * t / static_cast<double>(tetrahedra.size()));
      for (std::uint32_t e = 0; e < 6; ++e)
        if (!(done_[t] >> e & 1)) walk_around(t, e);
    }
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
    if (!walk(start, a, b, leave, corner[keep])) {
      walk(start, a, b, keep, corner[leave]);  // an edge on the boundary of O: only to mark the other side as done
      return;
    }
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
      done_[t] = static_cast<std::uint8_t>(done_[t] | 1u << kEdgeOf[ia][ib]);
      if (polytopes_.polytope_of[t] != ring_.back()) ring_.push_back(polytopes_.polytope_of[t]);
    }
  }

  const Polytopes& polytopes_;
  HugeVector<std::uint8_t> done_;  // bit e: edge kEdge[e] of the tetrahedron was walked around
  std::vector<std::uint32_t> ring_;
  RawFaces faces_;
};

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
    Polytopes polytopes = polytopes_inside(shape, std::move(delaunay), site_count, context);
    dual.complex.vertex_count = polytopes.count();
    edge_begin = collect_edges(polytopes, dual.complex);
    raw = FaceCollector(polytopes).run(context);
    dual.vertex_site_offsets = std::move(polytopes.site_offsets);
    dual.vertex_sites = std::move(polytopes.sites);
  }
  store_faces(raw, site_count, edge_begin, dual);
  checkpoint(context, "merge", 1);
  return dual;
}

}  // namespace quench::lattice
