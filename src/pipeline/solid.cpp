// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/text.h"
#include "quench/envelope.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/solid_stages.h"

namespace quench::pipeline {
namespace {

constexpr double kMostVoxels = 16384;  // along an axis

/// Voxels of a grid that `shape`, of a larger one of the same lattice, covers.
VoxelShape cropped(const VoxelShape& shape, const Grid& grid) {
  const Vec3 offset = shape.grid().lattice(grid.origin) - grid.first_centre();
  std::array<std::int64_t, 3> shift{};
  for (int a = 0; a < grid.dimension; ++a) shift[static_cast<std::size_t>(a)] = std::llround(offset[a]);
  VoxelShape part(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      for (const Run& run : shape.row(y + shift[1], z + shift[2])) {
        const std::int64_t begin = std::max<std::int64_t>(0, run.begin - shift[0]),
                           end = std::min(grid.dims[0], run.end - shift[0]);
        if (begin < end) runs.push_back({static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)});
      }
      part.append_row(runs);
    }
  return part;
}

}  // namespace

std::optional<Grid> grid_of(const Record& data) {
  const auto numbers = [&](const char* name, std::size_t count) -> std::vector<double> {
    const DataArray* array = find_array(data.field_data, name);
    if (!array || array->size() != count || std::holds_alternative<std::vector<std::string>>(array->values)) return {};
    std::vector<double> values = array->numbers();
    if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); })) return {};
    return values;
  };
  const std::vector<double> dims = numbers("dims", 3), spacing = numbers("spacing", 3), origin = numbers("origin", 3),
                            direction = numbers("direction", 9);
  if (dims.empty() || spacing.empty() || origin.empty() || direction.empty()) return {};
  Grid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(dims[a] >= 1 && dims[a] <= 4 * kMostVoxels) || !(spacing[a] > 0)) return {};
    grid.dims[a] = static_cast<std::int64_t>(dims[a]);
    grid.spacing[static_cast<Eigen::Index>(a)] = spacing[a];
    grid.origin[static_cast<Eigen::Index>(a)] = origin[a];
    for (std::size_t b = 0; b < 3; ++b)
      grid.direction(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = direction[3 * a + b];
  }
  if (!(grid.direction.transpose() * grid.direction).isIdentity(1e-6)) return {};
  if (field_number(data, "dimension") == 2) grid.make_plane();
  return grid;
}

SolidResult solid_of(const MedialAxis& axis, EnvelopeKind kind, const Grid& grid, const LoadedShape* shape,
                     Context* context) {
  constexpr std::int64_t kBytesPerElement = 400;  // its numbers, twice while they are sorted, and the tree
  require_memory(
      static_cast<std::int64_t>(axis.complex.face_vertices.size() + axis.complex.edges.size() + axis.points.size()) *
          kBytesPerElement,
      "the solid of this axis", {"an axis of fewer vertices"}, context);
  SolidResult result{Envelope(axis, kind, context), {}, {}, 0, {}, topology(axis.complex), {}, {}};
  result.voxels = voxels_of(result.envelope, grown_around(result.envelope, grid), context);
  result.on_grid = cropped(result.voxels, grid);
  result.cut_off = result.voxels.voxel_count() - result.on_grid.voxel_count();
  result.topology = topology(result.voxels);
  checkpoint(context, "topology", 1);
  if (!shape) return result;
  SolidErrors& errors = result.errors.emplace();
  errors.volume = volume_errors(result.voxels, shape->shape);
  if (grid.is_plane()) return result;
  result.surface = shape->surface ? *shape->surface : surface_of_voxels(shape->shape, context);
  errors.surface = result.surface->kind();
  errors.from_solid = distances_from_envelope(*result.surface, result.envelope, 100000, context);
  errors.from_surface = distances_from_surface(result.envelope, result.voxels, *result.surface, 100000, context);
  return result;
}

Record mesh_of(const SolidResult& solid, Context* context) {
  constexpr std::int64_t kBytesPerMeshSite =
      400;  // two triangles and a point, as mesh and as record, and the distances
  const std::int64_t sites = count_boundary_vertices(solid.voxels);
  require_memory(
      sites * kBytesPerMeshSite,
      fmt::format("the mesh of a solid with {}", base::counted(sites, "boundary vertex", "boundary vertices")),
      {"a lower resolution"}, context);
  Record record = to_record(quench::mesh_of(solid.envelope, solid.voxels, context));
  if (!solid.surface) return record;
  std::vector<double> distance(record.points.size());
  base::in_arena(context, [&] {
    base::for_indices(distance.size(), [&](std::size_t i) {
      const Surface::Foot foot = solid.surface->nearest(record.points[i]);
      distance[i] = foot.inside ? -foot.distance : foot.distance;
    });
  });
  record.point_data.push_back({"distance", 1, std::move(distance)});
  return record;
}

}  // namespace quench::pipeline
