// SPDX-License-Identifier: Apache-2.0
#include "voxelization/surface_edges.h"

#include <numeric>

namespace quench::voxelization {

std::vector<Triangle> weld(std::span<const FixedPoint> points, std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> order(points.size()), first(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t p, std::uint32_t q) { return points[p] != points[q] ? points[p] < points[q] : p < q; });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && points[order[i]] == points[order[i - 1]] ? first[order[i - 1]] : order[i];
  std::vector<Triangle> welded(triangles.begin(), triangles.end());
  for (Triangle& t : welded)
    for (std::uint32_t& corner : t) corner = first[corner];
  return welded;
}

std::vector<BoundaryEdge> boundary_chain(std::size_t points, std::span<const Triangle> faces) {
  std::vector<BoundaryEdge> chain;
  for_each_edge(points, faces, [&](std::uint32_t low, std::uint32_t high, std::span<const FaceSide> sides) {
    std::int32_t times = 0;
    for (const FaceSide& s : sides) times += is_upward(faces, s.side) ? 1 : -1;
    if (times > 0) chain.push_back({low, high, times});
    if (times < 0) chain.push_back({high, low, -times});
  });
  return chain;
}

base::Csr<std::uint32_t> edges_from(std::size_t points, std::span<const BoundaryEdge> chain) {
  return base::Csr<std::uint32_t>::group(points, [&](const auto& emit) {
    for (std::uint32_t e = 0; e < chain.size(); ++e) emit(chain[e].from, e);
  });
}

}  // namespace quench::voxelization
