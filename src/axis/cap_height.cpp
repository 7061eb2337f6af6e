// SPDX-License-Identifier: Apache-2.0
// Relatives of the measure: square-root pruning of the integer medial axis (Hesselink and Roerdink 2008), residuals
// (Ogniewicz and Kuebler 1995). docs/algorithms/pruning.md.
#include <algorithm>
#include <cmath>

#include "axis/measures.h"
#include "base/constants.h"
#include "base/parallel.h"

namespace quench::axis {

double cap_height(double lambda, double radius) {
  const double half_chord = std::min(lambda, radius);
  if (!(half_chord > 0)) return 0;
  // The same as r - sqrt(r^2 - lambda^2), without the difference of nearly equal numbers where r is large.
  return half_chord * half_chord / (radius + std::sqrt((radius - half_chord) * (radius + half_chord)));
}

CellValues cap_heights_of_top_cells(const MedialAxis& axis, const CellValues& lambda) {
  const CellComplex& complex = axis.complex;
  const std::vector<double>& radius = axis.radius_of_voxels();
  CellValues height{std::vector<double>(complex.vertex_count, kNoTopCell),
                    std::vector<double>(complex.edges.size(), kNoTopCell), std::vector<double>(complex.face_count())};
  std::vector<char> has_faces(complex.edges.size(), 0), has_edges(complex.vertex_count, 0);
  for (const std::uint32_t e : complex.face_edges) has_faces[e] = 1;
  for (const auto& ends : complex.edges)
    for (const std::uint32_t v : ends) has_edges[v] = 1;
  // With the same two sites the cap is the higher the smaller the ball.
  base::for_indices(complex.face_count(), [&](std::size_t f) {
    double least = base::kNever;
    for (const std::uint32_t v : complex.corners(f)) least = std::min(least, radius[v]);
    height.face[f] = cap_height(lambda.face[f], least);
  });
  base::for_indices(complex.edges.size(), [&](std::size_t e) {
    const auto [a, b] = complex.edges[e];
    if (!has_faces[e]) height.edge[e] = cap_height(lambda.edge[e], std::min(radius[a], radius[b]));
  });
  base::for_indices(complex.vertex_count, [&](std::size_t v) {
    if (!has_edges[v]) height.vertex[v] = cap_height(lambda.vertex[v], radius[v]);
  });
  return height;
}

void spread_to_sides(const CellComplex& complex, CellValues& value) {
  base::for_indices(complex.face_count(), [&](std::size_t f) {
    for (const std::uint32_t e : complex.sides(f)) base::raise(value.edge[e], value.face[f]);
  });
  base::for_indices(complex.edges.size(), [&](std::size_t e) {
    for (const std::uint32_t v : complex.edges[e]) base::raise(value.vertex[v], value.edge[e]);
  });
}

CellValues cap_heights(const MedialAxis& axis, const CellValues& lambda) {
  CellValues height = cap_heights_of_top_cells(axis, lambda);
  spread_to_sides(axis.complex, height);
  return height;
}

}  // namespace quench::axis
