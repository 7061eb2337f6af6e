// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "envelope/surface_places.h"
#include "quench/envelope.h"
#include "quench/simplify.h"
#include "simplification/patches.h"

namespace quench {

BoundaryPoints boundary_points(const Surface& surface, std::size_t count) {
  const TriangleMesh& mesh = surface.mesh();
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm() / 2;
  BoundaryPoints boundary;
  boundary.points = envelope::places_on(mesh, count);
  boundary.areas.assign(boundary.points.size(), area / static_cast<double>(count));
  boundary.points.insert(boundary.points.end(), mesh.points.begin(), mesh.points.end());
  boundary.areas.resize(boundary.points.size(), 0);
  return boundary;
}

BoundaryPoints boundary_points(const VoxelShape& shape, std::size_t count) {
  BoundaryPoints boundary;
  const std::vector<LatticePoint> vertices = boundary_vertices(shape);
  const Vec3& spacing = shape.grid().spacing;
  // Of the vertices each stands for about the face of a voxel.
  const double face = std::pow(spacing.prod(), 2.0 / 3);
  const std::size_t n = vertices.size(), step = std::max<std::size_t>(1, n / std::max<std::size_t>(1, count));
  for (std::size_t i = 0; i < n; ++i) {
    boundary.points.push_back(shape.grid().world_of(vertices[i]));
    boundary.areas.push_back(i % step == 0 ? face * static_cast<double>(std::min(step, n - i)) : 0);
  }
  return boundary;
}

BoundaryPoints boundary_points(const MedialAxis& axis, std::size_t count, Context* context) {
  const MedialAxis mesh = medial_mesh_of(axis);
  const Envelope envelope(mesh, EnvelopeKind::full, context);
  const simplification::Patches patches(mesh);
  const double area = patches.area();
  BoundaryPoints boundary;
  if (!(area > 0)) return boundary;
  const double step = area / static_cast<double>(std::max<std::size_t>(1, count));
  const std::vector<Vec3> points = patches.points(step);
  // What lies inside a cell farther away is not on the boundary.
  const double inside = -1e-9 * (envelope.high() - envelope.low()).maxCoeff();
  std::vector<char> seen(points.size());
  base::in_arena(context, [&] {
    base::for_indices(points.size(),
                      [&](std::size_t i) { seen[i] = envelope.nearest(points[i], inside).element == kNone; });
  });
  for (std::size_t i = 0; i < points.size(); ++i)
    if (seen[i]) boundary.points.push_back(points[i]);
  boundary.areas.assign(boundary.points.size(), step);
  return boundary;
}

OneSidedDistances errors_of(const MedialAxis& mesh, const BoundaryPoints& boundary, Context* context) {
  const Envelope envelope(mesh, EnvelopeKind::full, context);
  const std::size_t n = boundary.points.size();
  std::vector<envelope::Weighted> outside(n), either(n);
  base::in_arena(context, [&] {
    const std::size_t chunks = base::chunks_for(n, 1024);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(n, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        const double distance = envelope.distance(boundary.points[i]);
        outside[i] = {std::max(distance, 0.0), boundary.areas[i]};
        either[i] = {std::abs(distance), boundary.areas[i]};
      }
    });
  });
  OneSidedDistances errors;
  errors.places = n;
  errors.outside = envelope::figures_of(outside);
  errors.either = envelope::figures_of(either);
  return errors;
}

}  // namespace quench
