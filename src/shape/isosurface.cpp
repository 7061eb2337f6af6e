// SPDX-License-Identifier: Apache-2.0
#include "shape/isosurface.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "quench/error.h"
#include "shape/surface_fans.h"

namespace quench::shape {

TriangleMesh all_layers(const VoxelShape& shape, const SignedSamples* samples, Context* context) {
  constexpr std::int64_t kLayers = 16;  // of one task
  const std::int64_t layers = shape.grid().dims[2] + 1;
  const auto chunks = static_cast<std::size_t>((layers + kLayers - 1) / kLayers);
  std::vector<TriangleMesh> parts(chunks);
  TriangleMesh whole;
  base::in_arena(context, [&] {
    base::for_chunks(chunks, context, "surface", 0, 1, [&](std::size_t chunk) {
      const std::int64_t first = static_cast<std::int64_t>(chunk) * kLayers;
      SurfaceLayers part(shape, samples, first - 1);
      for (std::int64_t layer = first; layer < std::min(first + kLayers, layers); ++layer) part.add_layer();
      parts[chunk] = std::move(part.mesh);
    });
  });
  std::size_t points = 0, triangles = 0;
  for (const TriangleMesh& part : parts) {
    points += part.points.size();
    triangles += part.triangles.size();
  }
  if (points >= kNone) throw Error(ErrorCode::failed, "the surface has more than 2^32 vertices; use the voxels alone");
  whole.points.reserve(points);
  whole.triangles.reserve(triangles);
  for (TriangleMesh& part : parts) {
    const auto base = static_cast<std::uint32_t>(whole.points.size());
    whole.points.insert(whole.points.end(), part.points.begin(), part.points.end());
    for (const auto& t : part.triangles) whole.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    part = {};
  }
  return whole;
}

}  // namespace quench::shape

namespace quench {
namespace {

/// The axis along which a vertex lies between two voxels; 3: it lies inside a cell.
int edge_axis(const Vec3& vertex) {
  int axis = 3;
  for (int a = 0; a < 3; ++a) {
    if (vertex[a] - 0.5 == std::floor(vertex[a] - 0.5)) continue;
    if (axis != 3) return 3;
    axis = a;
  }
  return axis;
}

/// Whether a vertex on an edge lies between the shape and its background.
bool on_boundary(const VoxelShape& shape, const Vec3& vertex, int axis) {
  std::array<std::int64_t, 3> voxel;
  for (std::size_t a = 0; a < 3; ++a)
    voxel[a] = static_cast<std::int64_t>(std::floor(vertex[static_cast<Eigen::Index>(a)] - 0.5));
  const bool first = shape.contains(voxel[0], voxel[1], voxel[2]);
  ++voxel[static_cast<std::size_t>(axis)];
  return first != shape.contains(voxel[0], voxel[1], voxel[2]);
}

}  // namespace

void restrict_surface(TriangleMesh& surface, const VoxelShape& shape) {
  // All vertices of a component of the surface lie between one component of the foreground and one of the background.
  std::erase_if(surface.triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
    for (const std::uint32_t corner : triangle)
      if (const int axis = edge_axis(surface.points[corner]); axis < 3)
        return !on_boundary(shape, surface.points[corner], axis);
    return false;
  });
  shape::drop_unused_points(surface);
}

TriangleMesh midpoint_surface(const VoxelShape& shape, Context* context) {
  return shape::all_layers(shape, nullptr, context);
}

void to_world(TriangleMesh& surface, const Grid& grid) {
  for (Vec3& point : surface.points) point = grid.world(point);
  if (grid.direction.determinant() < 0)
    for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
}

}  // namespace quench
