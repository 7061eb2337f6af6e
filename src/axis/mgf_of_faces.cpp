// SPDX-License-Identifier: Apache-2.0
// Dey and Sun 2006; Yan 2018, sec. 3.2. docs/algorithms/mgf.md. The chord residual: Ogniewicz and Kuebler 1995.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "axis/measures.h"
#include "axis/mgf.h"
#include "base/parallel.h"
#include "geodesic/pair_distances.h"
#include "geodesic/voxel_surface.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/measures.h"

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
using SitePair = std::array<LatticePoint, 2>;

/// Pairs of boundary vertices, and which cell each is of: edges without faces, then vertices without edges.
struct OwnPairs {
  std::vector<SitePair> pairs;
  std::vector<std::pair<std::uint32_t, std::size_t>> of_edges, of_vertices;  // cell, and where its pairs end
};

OwnPairs own_pairs(const MedialAxis& axis, const VoxelShape& shape) {
  const CellComplex& complex = axis.complex;
  OwnPairs list;
  std::vector<char> has_faces(complex.edges.size(), axis.grid.is_plane()), has_edges(complex.vertex_count, 0);
  for (const std::uint32_t e : complex.face_edges) has_faces[e] = 1;
  for (const auto& ends : complex.edges)
    for (const std::uint32_t v : ends) has_edges[v] = 1;
  if (std::ranges::all_of(has_faces, [](char x) { return x; }) &&
      std::ranges::all_of(has_edges, [](char x) { return x; }))
    return list;
  const NearestSites nearest(axis, shape);
  const auto add_all = [&](const std::vector<LatticePoint>& sites) {
    for (std::size_t i = 0; i < sites.size(); ++i)
      for (std::size_t j = i + 1; j < sites.size(); ++j) list.pairs.push_back({sites[i], sites[j]});
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

// Of the faces, where they are wanted, and then of pairs: world units, negative where two do not see each other inside
// of the shape.
std::vector<double> ways(const MedialAxis& axis, const VoxelShape& shape, bool of_faces,
                         const std::vector<SitePair>& pairs, Context* context) {
  checkpoint(context, "geodesics", 0);
  const geodesic::VoxelSurface surface(shape);
  const std::size_t faces = of_faces ? axis.complex.face_count() : 0;
  std::vector<Pair> all(faces + pairs.size());
  base::for_indices(all.size(), [&](std::size_t i) {
    const LatticePoint& a = i < faces ? axis.sites[axis.face_sites[i][0]] : pairs[i - faces][0];
    const LatticePoint& b = i < faces ? axis.sites[axis.face_sites[i][1]] : pairs[i - faces][1];
    all[i] = {surface.point_towards(a, b), surface.point_towards(b, a)};
  });
  const auto is_seen = [](const Pair& pair) { return pair[0] != kNone && pair[1] != kNone; };
  if (!std::all_of(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(faces), is_seen))
    throw Error(ErrorCode::usage,
                "the medial axis is not that of the voxel shape: two nearest boundary vertices of a "
                "face do not see each other inside of it");
  std::vector<char> seen(pairs.size());
  std::transform(all.begin() + static_cast<std::ptrdiff_t>(faces), all.end(), seen.begin(), is_seen);
  std::erase_if(all, [&](const Pair& pair) { return !is_seen(pair); });
  std::vector<double> distance = geodesic::pair_distances(surface, all, kMostLandmarkBytes, context);
  for (double& d : distance) d *= surface.unit();
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) distance.insert(distance.begin() + static_cast<std::ptrdiff_t>(faces + i), -1);
  return distance;
}

// From values of the faces, in the plane of the edges, and of the own pairs of other cells.
Measure measure_of(std::string_view name, const MedialAxis& axis, std::vector<double> of_top, const OwnPairs& own,
                   std::span<const double> of_pairs) {
  const CellComplex& complex = axis.complex;
  Measure measure{std::string(name), {}, {}};
  measure.value.vertex.resize(complex.vertex_count, 0);
  measure.value.edge.resize(complex.edges.size(), 0);
  (axis.grid.is_plane() ? measure.value.edge : measure.value.face) = std::move(of_top);
  std::size_t next = 0;
  for (const auto& [e, end] : own.of_edges)
    for (; next < end; ++next) base::raise(measure.value.edge[e], of_pairs[next]);
  for (const auto& [v, end] : own.of_vertices)
    for (; next < end; ++next) base::raise(measure.value.vertex[v], of_pairs[next]);
  axis::spread_to_sides(complex, measure.value);
  return measure;
}

Measure mgf_of(const MedialAxis& axis, const VoxelShape& shape, Context* context) {
  const OwnPairs own = own_pairs(axis, shape);
  std::vector<double> distance = ways(axis, shape, true, own.pairs, context);
  const std::vector<double> of_pairs(distance.begin() + static_cast<std::ptrdiff_t>(axis.complex.face_count()),
                                     distance.end());
  distance.resize(axis.complex.face_count());
  return measure_of(kMgf, axis, std::move(distance), own, of_pairs);
}

// What a way is longer than the chord. A difference that is rounding counts as none; -1 where there is no way.
double residual(double way, const Grid& grid, const LatticePoint& a, const LatticePoint& b) {
  constexpr double kRounding = 1e-9;
  const double chord = grid.spacing.cwiseProduct(Vec3(a[0] - b[0], a[1] - b[1], a[2] - b[2])).norm();
  if (way < 0 || std::isinf(way)) return way;
  return way - chord > kRounding * way ? way - chord : 0;
}

// In the plane, of pairs that are not those of edges.
std::vector<double> ways_in_plane(const VoxelShape& shape, const std::vector<SitePair>& pairs) {
  const std::vector<LatticePoint> sites = boundary_vertices(shape);
  const auto row = [&](const LatticePoint& p) {
    const auto at = std::ranges::lower_bound(sites, p, [](const LatticePoint& a, const LatticePoint& b) {
      return a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
    });
    return static_cast<std::uint32_t>(at - sites.begin());
  };
  std::vector<Pair> rows;
  for (const auto& [a, b] : pairs) rows.push_back({row(a), row(b)});
  return rows.empty() ? std::vector<double>{} : axis::mgf_of_edges(shape, sites, rows);
}

Measure chord_residual_of(const MedialAxis& axis, const VoxelShape& shape, Context* context) {
  const OwnPairs own = own_pairs(axis, shape);
  const bool plane = axis.grid.is_plane();
  const auto& sites_of = plane ? axis.edge_sites : axis.face_sites;
  std::vector<double> of_pairs, of_top;
  if (const Measure* mgf = axis.find_measure(kMgf); mgf && mgf->value.complete(axis.complex)) {
    of_top = plane ? mgf->value.edge : mgf->value.face;
    if (plane)
      of_pairs = ways_in_plane(shape, own.pairs);
    else if (!own.pairs.empty())
      of_pairs = ways(axis, shape, false, own.pairs, context);
  } else {
    of_top = ways(axis, shape, true, own.pairs, context);
    of_pairs.assign(of_top.begin() + static_cast<std::ptrdiff_t>(sites_of.size()), of_top.end());
    of_top.resize(sites_of.size());
  }
  for (std::size_t i = 0; i < of_top.size(); ++i)
    of_top[i] = residual(of_top[i], axis.grid, axis.sites[sites_of[i][0]], axis.sites[sites_of[i][1]]);
  for (std::size_t i = 0; i < of_pairs.size(); ++i)
    of_pairs[i] = residual(of_pairs[i], axis.grid, own.pairs[i][0], own.pairs[i][1]);
  return measure_of(kChordResidual, axis, std::move(of_top), own, of_pairs);
}

}  // namespace

static void require_core_of(const MedialAxis& axis, const VoxelShape& shape) {
  const bool has_sites = axis.grid.is_plane()
                             ? axis.edge_sites.size() == axis.complex.edges.size() && axis.find_measure(kMgf)
                             : axis.face_sites.size() == axis.complex.face_count();
  if (!has_sites || axis.grid.dims != shape.grid().dims)
    throw Error(ErrorCode::usage,
                "the medial axis is not a voxel core of the voxel shape, whose boundary its MGF is measured on; "
                "voxel_core() makes one that is");
}

void add_mgf(MedialAxis& axis, const VoxelShape& shape, Context* context) {
  if (axis.find_measure(kMgf)) return;
  require_core_of(axis, shape);
  axis.measures.push_back(base::in_arena(context, [&] { return mgf_of(axis, shape, context); }));
}

void add_chord_residual(MedialAxis& axis, const VoxelShape& shape, Context* context) {
  if (axis.find_measure(kChordResidual)) return;
  require_core_of(axis, shape);
  axis.measures.push_back(base::in_arena(context, [&] { return chord_residual_of(axis, shape, context); }));
}

std::int64_t predicted_mgf_bytes(const VoxelShape& shape, std::size_t faces, int threads) {
  const auto points = static_cast<double>(count_boundary_vertices(shape));
  const double landmarks =
      std::min(4 * points * std::sqrt(static_cast<double>(faces)), static_cast<double>(kMostLandmarkBytes));
  return static_cast<std::int64_t>((kBytesPerPoint + kBytesPerPointAndThread * threads) * points + landmarks +
                                   24 * static_cast<double>(faces));
}

}  // namespace quench
