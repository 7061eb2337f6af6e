// SPDX-License-Identifier: Apache-2.0
// Yan 2018, sec. 2.4 and 2.6 step 2.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "axis/mgf.h"
#include "axis/rest_of_core.h"
#include "base/parallel.h"
#include "base/return_memory.h"
#include "delaunay/delaunay.h"
#include "dual/dual_complex.h"
#include "dual/peel/peel.h"
#include "dual/plane/dual_of_plane.h"
#include "quench/axis.h"
#include "shape/boundary_count.h"

namespace quench {
namespace {

using dual::DualComplex;

// In the plane: the shorter way along the boundary between the contacts of an edge, of vertices the longest over their
// edges or, where there are none, over their sites.
Measure boundary_distances(const VoxelShape& shape, const MedialAxis& axis, const DualComplex& dual) {
  const std::size_t edges = axis.complex.edges.size();
  Measure mgf{std::string(kMgf), {}, {}};
  std::vector<double>& vertex = mgf.value.vertex;
  vertex.assign(axis.complex.vertex_count, -1);
  for (const auto& ends : axis.complex.edges)
    for (const std::uint32_t v : ends) vertex[v] = 0;
  std::vector<std::array<std::uint32_t, 2>> pairs = axis.edge_sites;
  std::vector<std::uint32_t> isolated;  // per pair beyond those of the edges
  for (std::uint32_t v = 0; v < vertex.size(); ++v)
    if (vertex[v] < 0)
      for (const std::uint32_t a : dual.sites_of(v))
        for (const std::uint32_t b : dual.sites_of(v))
          if (a < b) {
            pairs.push_back({a, b});
            isolated.push_back(v);
          }
  std::vector<double> distance = axis::mgf_of_edges(shape, axis.sites, pairs);
  for (std::size_t i = 0; i < isolated.size(); ++i) base::raise(vertex[isolated[i]], distance[edges + i]);
  distance.resize(edges);
  for (std::size_t e = 0; e < edges; ++e)
    for (const std::uint32_t v : axis.complex.edges[e]) base::raise(vertex[v], distance[e]);
  mgf.value.edge = std::move(distance);
  return mgf;
}

}  // namespace

static MedialAxis compute(const VoxelShape& shape, const CoreOptions& options, Context* context) {
  if (shape.empty()) throw Error(ErrorCode::input, "the voxel shape is empty; there is no medial axis to compute");
  const auto spacing = integer_spacing(shape.grid());
  std::vector<LatticePoint> sites = boundary_vertices(shape);
  checkpoint(context, "peel", 0);
  const bool plane = shape.grid().is_plane();
  DualComplex dual = plane ? dual::plane::dual_complex(shape, sites, spacing, context)
                           : dual::peel::dual_complex(shape, sites, spacing, {}, context);

  base::return_free_memory();
  MedialAxis axis = axis::axis_of(dual, std::move(sites), shape.grid(), options.rule, {}, context);
  if (plane) axis.measures.push_back(boundary_distances(shape, axis, dual));
  return axis;
}

MedialAxis voxel_core(const VoxelShape& shape, const CoreOptions& options, Context* context) {
  return base::in_arena(context, [&] { return compute(shape, options, context); });
}

namespace {

// Measured on 18 shapes, notes/detail.md; several threads have buffers of their own. In the plane there are fewer
// cells.
constexpr double kBytesPerSiteOfPlane = 220;
constexpr double kBytesPerSite = 355, kBytesPerSiteInBricks = 430, kFewestBytesPerSiteInBricks = 222;

std::int64_t core_bytes(double per_site, double sites) {
  constexpr double always = 6 << 20, of_threads = 6 << 20, of_threads_per_site = 8;
  return static_cast<std::int64_t>(always + per_site * sites +
                                   (base::several_threads() ? of_threads + of_threads_per_site * sites : 0));
}

}  // namespace

std::int64_t predicted_core_bytes(const VoxelShape& shape) {
  const shape::BoundaryCount count = shape::count_boundary(shape);
  if (count.sites == 0) return predicted_core_bytes(0);
  // Opposite flat walls share vertices of the core, and a wall of one voxel has few of them.
  const auto sites = static_cast<double>(count.sites);
  if (shape.grid().is_plane()) return core_bytes(kBytesPerSiteOfPlane, sites);
  const double flat = static_cast<double>(count.flat) / sites;
  const double thickness = static_cast<double>(shape.voxel_count()) / sites;
  return core_bytes(std::min({kBytesPerSite, 468 - 214 * flat, 210 + 58 * thickness}), sites);
}

std::int64_t predicted_core_bytes(std::int64_t sites) { return core_bytes(kBytesPerSite, static_cast<double>(sites)); }

std::int64_t predicted_core_bytes_in_bricks(const VoxelShape& shape) {
  if (shape.grid().is_plane()) return predicted_core_bytes(shape);  // made at once in any case
  return core_bytes(kBytesPerSiteInBricks, static_cast<double>(count_boundary_vertices(shape)));
}

std::int64_t predicted_core_bytes_in_bricks(std::int64_t sites) {
  return core_bytes(kFewestBytesPerSiteInBricks, static_cast<double>(sites));
}

}  // namespace quench
