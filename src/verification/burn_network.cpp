// SPDX-License-Identifier: Apache-2.0
#include "verification/burn_network.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/union_find.h"

namespace quench::verification {

BurnNetwork::BurnNetwork(const Result& result, double omega, bool exact) : result_(result), exact_(exact) {
  const CellComplex& complex = result.complex;
  at_edge_ = base::Csr<std::uint32_t>::group(complex.edges.size(), [&](const auto& emit) {
    for (std::uint32_t c = 0; c < complex.face_edges.size(); ++c) emit(complex.face_edges[c], c);
  });
  number_sectors();
  split_edges(omega);
}

void BurnNetwork::stops_of(std::uint32_t f, std::vector<Stop>& stops) const {
  const CellComplex& complex = result_.complex;
  stops.clear();
  for (std::uint32_t c = complex.face_offsets[f]; c < complex.face_offsets[f + 1]; ++c) {
    const std::uint32_t v = complex.face_vertices[c], e = complex.face_edges[c], each = states_per_node(e);
    stops.push_back({sector_of_[c], result_.ball_radius[v], point(v)});
    const auto [a, b] = complex.edges[e];
    const auto all = at_edge_[e];
    const auto own = each == 1 ? 0 : static_cast<std::uint32_t>(std::find(all.begin(), all.end(), c) - all.begin());
    for (std::uint32_t i = 1; i < pieces_[e]; ++i) {
      const std::uint32_t k = a == v ? i : pieces_[e] - i;
      const double t = static_cast<double>(k) / pieces_[e];
      stops.push_back(
          {first_state_[e] + (k - 1) * each + own, radius_at(a, b, t), Vec3((1 - t) * point(a) + t * point(b))});
    }
  }
}

// The distance to a point that the ends share as nearest, or linear.
double BurnNetwork::radius_at(std::uint32_t a, std::uint32_t b, double t) const {
  const double ra = result_.ball_radius[a], rb = result_.ball_radius[b], length = (point(b) - point(a)).norm();
  if (!exact_ || std::abs(ra - rb) > length || length > ra + rb) return (1 - t) * ra + t * rb;
  return std::sqrt(std::max(0.0, (1 - t) * ra * ra + t * rb * rb - t * (1 - t) * length * length));
}

// Corners of one vertex are of one sector where they meet in an edge of two polygons. Sectors are numbered by their
// vertices, those of one in the order of their first corners.
void BurnNetwork::number_sectors() {
  const CellComplex& complex = result_.complex;
  const auto corners = static_cast<std::uint32_t>(complex.face_vertices.size());
  std::vector<std::uint32_t> next(corners);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t c = complex.face_offsets[f]; c < complex.face_offsets[f + 1]; ++c)
      next[c] = c + 1 == complex.face_offsets[f + 1] ? complex.face_offsets[f] : c + 1;
  base::UnionFind same(corners);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (const auto at = std::as_const(at_edge_)[e]; at.size() == 2)
      for (const std::uint32_t x : {at[0], next[at[0]]})
        for (const std::uint32_t y : {at[1], next[at[1]]})
          if (complex.face_vertices[x] == complex.face_vertices[y]) same.unite(x, y);
  sectors_.assign(std::size_t{complex.vertex_count} + 1, 0);
  for (std::uint32_t c = 0; c < corners; ++c)
    if (same.find(c) == c) ++sectors_[complex.face_vertices[c] + 1];
  std::partial_sum(sectors_.begin(), sectors_.end(), sectors_.begin());
  std::vector<std::uint32_t> free(sectors_.begin(), sectors_.end() - 1);
  sector_of_.resize(corners);
  for (std::uint32_t c = 0; c < corners; ++c) {  // the root of a set is its first corner
    const std::uint32_t root = same.find(c);
    sector_of_[c] = root == c ? free[complex.face_vertices[c]]++ : sector_of_[root];
  }
}

// Equal parts no longer than omega, two at least at the vertices of seams. States of nodes on edges come after those of
// vertices: one of each node, or on seams one per polygon.
void BurnNetwork::split_edges(double omega) {
  const CellComplex& complex = result_.complex;
  std::vector<char> at_seam(complex.vertex_count, 0);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (at_edge_[e].size() > 2)
      for (const std::uint32_t v : complex.edges[e]) at_seam[v] = 1;
  states_ = sectors_.back();
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e) {
    const auto [a, b] = complex.edges[e];
    const double length = (point(b) - point(a)).norm(), least = at_seam[a] || at_seam[b] ? 2 : 1;
    const double parts = std::max(least, std::ceil(length / omega * (1 - 1e-12)));
    const bool split = at_edge_[e].size() > 0 && length > 0;
    pieces_.push_back(split ? static_cast<std::uint32_t>(std::min(parts, 4e9)) : 1);
    first_state_.push_back(static_cast<std::uint32_t>(states_));
    states_ += std::size_t{pieces_[e] - 1} * states_per_node(e);
  }
}

}  // namespace quench::verification
