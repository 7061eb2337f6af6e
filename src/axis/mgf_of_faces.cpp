// SPDX-License-Identifier: Apache-2.0
// Dey and Sun 2006; Yan 2018, sec. 3.2. docs/algorithms/mgf.md.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "axis/measures.h"
#include "base/parallel.h"
#include "geodesic/pair_distances.h"
#include "geodesic/voxel_surface.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

/// The boundary vertices nearest to a place, up to rounding, which are found around it.
class NearestSites {
 public:
  NearestSites(const MedialAxis& axis, const VoxelShape& shape)
      : axis_(axis), grid_(shape.grid()), all_(boundary_vertices(shape)) {}

  std::vector<LatticePoint> of(std::uint32_t vertex) const {
    const Vec3 place = grid_.lattice(axis_.points_of_voxels()[vertex]);
    const double radius = axis_.radius_of_voxels()[vertex] * (1 + kRounding) + kRounding * grid_.spacing.minCoeff();
    std::array<std::int32_t, 3> low, high;
    for (int i = 0; i < 3; ++i) {
      low[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(std::ceil(place[i] - radius / grid_.spacing[i]));
      high[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(std::floor(place[i] + radius / grid_.spacing[i]));
    }
    std::vector<LatticePoint> sites;
    for (std::int32_t z = low[2]; z <= high[2]; ++z)
      for (std::int32_t y = low[1]; y <= high[1]; ++y)
        for (auto s = std::ranges::lower_bound(all_, LatticePoint{low[0], y, z}, comes_before);
             s != all_.end() && (*s)[2] == z && (*s)[1] == y && (*s)[0] <= high[0]; ++s)
          if (grid_.spacing.cwiseProduct(Vec3((*s)[0], (*s)[1], (*s)[2]) - place).norm() <= radius) sites.push_back(*s);
    return sites;
  }

 private:
  static constexpr double kRounding = 1e-6;
  static bool comes_before(const LatticePoint& a, const LatticePoint& b) {
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
  }

  const MedialAxis& axis_;
  const Grid& grid_;
  const std::vector<LatticePoint> all_;
};

using Pair = std::array<std::uint32_t, 2>;

/// Pairs of points of the surface, and which cell each is of: first all faces, then edges without faces, then vertices
/// without edges.
struct ContactPairs {
  std::vector<Pair> pairs;
  std::vector<std::pair<std::uint32_t, std::size_t>> of_edges, of_vertices;  // cell, and where its pairs end
};

ContactPairs contact_pairs(const MedialAxis& axis, const VoxelShape& shape, const geodesic::VoxelSurface& surface) {
  const CellComplex& complex = axis.complex;
  ContactPairs list;
  list.pairs.resize(complex.face_count());
  base::for_indices(complex.face_count(), [&](std::size_t f) {
    const LatticePoint &a = axis.sites[axis.face_sites[f][0]], &b = axis.sites[axis.face_sites[f][1]];
    list.pairs[f] = {surface.point_towards(a, b), surface.point_towards(b, a)};
  });
  for (const Pair& pair : list.pairs)
    if (pair[0] == kNone || pair[1] == kNone)
      throw Error(ErrorCode::usage,
                  "the medial axis is not that of the voxel shape: two nearest boundary vertices of a "
                  "face do not see each other inside of it");
  std::vector<char> has_faces(complex.edges.size(), 0), has_edges(complex.vertex_count, 0);
  for (const std::uint32_t e : complex.face_edges) has_faces[e] = 1;
  for (const auto& ends : complex.edges)
    for (const std::uint32_t v : ends) has_edges[v] = 1;
  if (std::ranges::all_of(has_faces, [](char x) { return x; }) &&
      std::ranges::all_of(has_edges, [](char x) { return x; }))
    return list;
  const NearestSites nearest(axis, shape);
  const auto add_all = [&](const std::vector<LatticePoint>& sites) {
    for (std::size_t i = 0; i < sites.size(); ++i)
      for (std::size_t j = i + 1; j < sites.size(); ++j)
        if (const Pair pair{surface.point_towards(sites[i], sites[j]), surface.point_towards(sites[j], sites[i])};
            pair[0] != kNone && pair[1] != kNone)
          list.pairs.push_back(pair);
  };
  for (std::uint32_t e = 0; e < has_faces.size(); ++e) {
    if (has_faces[e]) continue;
    const auto [u, v] = complex.edges[e];
    const std::vector<LatticePoint> of_u = nearest.of(u), of_v = nearest.of(v);
    std::vector<LatticePoint> shared;
    std::ranges::copy_if(of_u, std::back_inserter(shared),
                         [&](const LatticePoint& s) { return std::ranges::find(of_v, s) != of_v.end(); });
    add_all(shared);
    list.of_edges.emplace_back(e, list.pairs.size());
  }
  for (std::uint32_t v = 0; v < has_edges.size(); ++v) {
    if (has_edges[v]) continue;
    add_all(nearest.of(v));
    list.of_vertices.emplace_back(v, list.pairs.size());
  }
  return list;
}

constexpr std::int64_t kMostLandmarkBytes = std::int64_t{1} << 30;
constexpr double kBytesPerPoint = 190, kBytesPerPointAndThread = 90;

Measure mgf_of(const MedialAxis& axis, const VoxelShape& shape, Context* context) {
  checkpoint(context, "geodesics", 0);
  const geodesic::VoxelSurface surface(shape);
  const CellComplex& complex = axis.complex;
  const ContactPairs list = contact_pairs(axis, shape, surface);
  std::vector<double> distance = geodesic::pair_distances(surface, list.pairs, kMostLandmarkBytes, context);
  for (double& d : distance) d *= surface.unit();
  Measure mgf{std::string(kMgf), {}, {}};
  mgf.value.vertex.resize(complex.vertex_count, 0);
  mgf.value.edge.resize(complex.edges.size(), 0);
  std::size_t next = complex.face_count();
  for (const auto& [e, end] : list.of_edges)
    for (; next < end; ++next) base::raise(mgf.value.edge[e], distance[next]);
  for (const auto& [v, end] : list.of_vertices)
    for (; next < end; ++next) base::raise(mgf.value.vertex[v], distance[next]);
  distance.resize(complex.face_count());
  mgf.value.face = std::move(distance);
  axis::spread_to_sides(complex, mgf.value);
  return mgf;
}

}  // namespace

void add_mgf(MedialAxis& axis, const VoxelShape& shape, Context* context) {
  if (axis.find_measure(kMgf)) return;
  if (axis.grid.is_plane() || axis.face_sites.size() != axis.complex.face_count() ||
      axis.grid.dims != shape.grid().dims)
    throw Error(ErrorCode::usage,
                "the medial axis is not a voxel core of the voxel shape, whose boundary its MGF is measured on; "
                "voxel_core() makes one that is");
  axis.measures.push_back(base::in_arena(context, [&] { return mgf_of(axis, shape, context); }));
}

std::int64_t predicted_mgf_bytes(const VoxelShape& shape, std::size_t faces, int threads) {
  const auto points = static_cast<double>(count_boundary_vertices(shape));
  const double landmarks =
      std::min(4 * points * std::sqrt(static_cast<double>(faces)), static_cast<double>(kMostLandmarkBytes));
  return static_cast<std::int64_t>((kBytesPerPoint + kBytesPerPointAndThread * threads) * points + landmarks +
                                   24 * static_cast<double>(faces));
}

}  // namespace quench
