// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "delaunay/delaunay.h"
#include "delaunay/polytopes.h"
#include "dual/dual_complex.h"
#include "quench/shape.h"

/// The dual complex read off the triangulation of all sites: no hulls, no facets, no matching. Slow and serial.
namespace quench::oracles {

/// Walks around the edges of the tetrahedra inside O. An edge of one belongs to the Delaunay complex, and is not a
/// diagonal of a polytope or facet, exactly when at least three polytopes surround it. Polytopes are convex, so the
/// tetrahedra of each are consecutive around the edge.
class EdgeRings {
 public:
  explicit EdgeRings(const delaunay::Polytopes& polytopes) : polytopes_(polytopes) {}

  /// By the ends of the edge: polytopes counter-clockwise around the direction from the smaller end to the larger one,
  /// from the smallest polytope.
  std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> run() {
    // The edges (i, j) of a tetrahedron and the other two corners (k, l), (i, j, k, l) an even permutation.
    constexpr std::uint32_t kEdge[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                           {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
    std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> rings;
    for (std::uint32_t t = 0; t < polytopes_.tetrahedra.size(); ++t)
      for (const auto& [i, j, k, l] : kEdge) {
        const auto& corner = polytopes_.tetrahedra[t].corner;
        const bool ascending = corner[i] < corner[j];
        if (!walk(t, ascending ? k : l, corner[ascending ? l : k]) || ring_.size() < 3) continue;
        std::rotate(ring_.begin(), std::min_element(ring_.begin(), ring_.end()), ring_.end());
        rings[{std::min(corner[i], corner[j]), std::max(corner[i], corner[j])}] = ring_;
      }
    return rings;
  }

 private:
  // Crosses the facet opposite to corner `leave`, and so on around the edge between the other two corners; `keep` is
  // the site of the last corner. False: the walk leaves O, or has been made from a smaller tetrahedron.
  bool walk(std::uint32_t start, std::uint32_t leave, std::uint32_t keep) {
    ring_.assign(1, polytopes_.polytope_of[start]);
    for (std::uint32_t t = start;;) {
      const std::uint32_t across = polytopes_.tetrahedra[t].neighbour[leave];
      if (across == kNone || across >> 2 < start) return false;
      t = across >> 2;
      if (t == start) break;
      const auto& corner = polytopes_.tetrahedra[t].corner;
      leave = static_cast<std::uint32_t>(std::ranges::find(corner, keep) - corner.begin());
      keep = corner[across & 3];
      if (polytopes_.polytope_of[t] != ring_.back()) ring_.push_back(polytopes_.polytope_of[t]);
    }
    if (ring_.size() > 1 && ring_.front() == ring_.back()) ring_.pop_back();
    return true;
  }

  const delaunay::Polytopes& polytopes_;
  std::vector<std::uint32_t> ring_;
};

/// The polytopes in the order of their site lists.
inline std::vector<std::uint32_t> sorted(const delaunay::Polytopes& polytopes) {
  std::vector<std::uint32_t> order(polytopes.count());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return std::ranges::lexicographical_compare(polytopes.sites_of(a), polytopes.sites_of(b));
  });
  return order;
}

inline dual::DualComplex dual_of_triangulation(const VoxelShape& shape, std::span<const LatticePoint> sites) {
  delaunay::Polytopes polytopes = delaunay::polytopes_inside(
      shape, std::make_unique<delaunay::Delaunay>(sites, integer_spacing(shape.grid()), nullptr), sites, nullptr);
  dual::DualComplex dual;
  dual.vertex_site_offsets = {0};
  std::vector<std::uint32_t> number(polytopes.count());
  for (const std::uint32_t p : sorted(polytopes)) {
    number[p] = static_cast<std::uint32_t>(dual.vertex_site_offsets.size() - 1);
    const auto corners = polytopes.sites_of(p);
    dual.vertex_sites.insert(dual.vertex_sites.end(), corners.begin(), corners.end());
    dual.vertex_site_offsets.push_back(static_cast<std::uint32_t>(dual.vertex_sites.size()));
  }
  for (std::uint32_t& p : polytopes.polytope_of) p = number[p];
  CellComplex& complex = dual.complex;
  complex.vertex_count = polytopes.count();
  auto& edges = complex.edges;
  for (std::uint32_t t = 0; t < polytopes.tetrahedra.size(); ++t)
    for (const std::uint32_t n : polytopes.tetrahedra[t].neighbour) {
      if (n == kNone) continue;
      const std::uint32_t u = polytopes.polytope_of[t], v = polytopes.polytope_of[n >> 2];
      if (u < v) edges.push_back({u, v});
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [ends, ring] : EdgeRings(polytopes).run()) {
    dual.face_sites.push_back(ends);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const auto [u, v] = std::minmax(ring[i], ring[(i + 1) % ring.size()]);
      complex.face_vertices.push_back(ring[i]);
      complex.face_edges.push_back(
          static_cast<std::uint32_t>(std::ranges::lower_bound(edges, std::array{u, v}) - edges.begin()));
    }
    complex.face_offsets.push_back(static_cast<std::uint32_t>(complex.face_vertices.size()));
  }
  return dual;
}

}  // namespace quench::oracles
