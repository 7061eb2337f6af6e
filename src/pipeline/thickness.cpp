// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "base/text.h"
#include "quench/error.h"
#include "quench/solid_stages.h"

namespace quench::pipeline {
namespace {

// What thickness needs of a core.
MedialAxis edges_of(MedialAxis&& core) {
  MedialAxis axis;
  axis.grid = core.grid;
  axis.points = std::move(core.points);
  axis.radius = std::move(core.radius);
  axis.complex.vertex_count = core.complex.vertex_count;
  axis.complex.edges = std::move(core.complex.edges);
  return axis;
}

constexpr std::int64_t kSlices = 32;  // of thickness in memory at a time

}  // namespace

MedialAxis whole_core(const LoadedShape& shape, Context* context) {
  return base::in_arena(context, [&] {
    const Grid& grid = shape.shape.grid();
    const CorePlan plan = plan_core(shape.shape, context);
    const std::int64_t held = context && context->memory_limit > 0 ? plan.held : 0;
    const std::int64_t slices = std::min(grid.dims[2], kSlices) * grid.dims[0] * grid.dims[1] * 4;
    require_memory(held + plan.bytes() + slices,
                   fmt::format("the thickness of a shape with {}",
                               base::counted(plan.sites, "boundary vertex", "boundary vertices")),
                   shape.from_mesh || shape.polygon ? std::vector<std::string>{"a lower resolution"}
                                                    : std::vector<std::string>{"a smaller or coarser volume"},
                   context);
    if (!plan.in_bricks) return edges_of(voxel_core(shape.shape, {}, context));
    LoadedShape voxels;
    voxels.shape = shape.shape;
    voxels.topology = shape.topology;
    voxels.longest_side = shape.longest_side;
    voxels.image = shape.image;
    AxisOptions all;
    all.pruning.threshold = world_length(0);
    return edges_of(core_of(voxels, all, context).axis);
  });
}

LoadedShape complement_of(const LoadedShape& shape) {
  const Grid& grid = shape.shape.grid();
  VoxelShape rest(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      std::int32_t begin = 0;
      for (const Run& run : shape.shape.row(y, z)) {
        if (run.begin > begin) runs.push_back({begin, run.begin});
        begin = run.end;
      }
      if (begin < grid.dims[0]) runs.push_back({begin, static_cast<std::int32_t>(grid.dims[0])});
      rest.append_row(runs);
    }
  if (rest.empty()) throw Error(ErrorCode::input, "the shape fills its box: there are no pores in it", "invert");
  LoadedShape result = shape;
  result.shape = std::move(rest);
  result.topology = topology(result.shape);
  result.longest_side = result.shape.longest_side();
  result.surface.reset();
  result.mesh.reset();
  return result;
}

MeasuredSurface measured_surface(const LoadedShape& shape, std::optional<double> tolerance, Context* context) {
  if (shape.shape.grid().is_plane())
    throw Error(ErrorCode::usage, "thickness on a surface is for volumes and meshes, not for images and polygons",
                "surface");
  return base::in_arena(context, [&] {
    MeasuredSurface result;
    result.coordinates = shape.coordinates;
    result.axis = core_of(shape, {}, context).axis;
    if (shape.mesh) {
      result.mesh = *shape.mesh;
    } else if (shape.surface) {
      result.mesh = shape.surface->mesh();
    } else {
      result.mesh = midpoint_surface(shape.shape, context);
      to_world(result.mesh, shape.shape.grid());
    }
    const Surface surface = shape.surface ? *shape.surface : Surface(result.mesh, SurfaceKind::mesh, context);
    result.tolerance = tolerance.value_or(auto_detail(shape.shape.grid()));
    result.correction = thickness_correction(result.axis);
    result.thickness =
        surface_thickness(result.mesh.points, &surface, result.axis, {result.tolerance, result.correction}, context);
    const std::vector<double>& at = result.thickness.thickness;
    const double largest = at.empty() ? 0 : *std::max_element(at.begin(), at.end());
    result.distribution = ThicknessDistribution(automatic_bin_width(shape.shape.grid(), largest));
    const auto& p = result.mesh.points;
    for (const auto& [a, b, c] : result.mesh.triangles)
      result.distribution.add((at[a] + at[b] + at[c]) / 3, (p[b] - p[a]).cross(p[c] - p[a]).norm() / 2);
    return result;
  });
}

Record surface_file(const MeasuredSurface& surface) {
  Record data = to_record(surface.mesh);
  data.point_data.push_back({"thickness", 1, surface.thickness.thickness});
  for (const auto& [name, axis] : {std::pair{"across_x", 0}, {"across_y", 1}, {"across_z", 2}}) {
    std::vector<double> values;  // single numbers, which every format has
    values.reserve(surface.thickness.across.size());
    for (const Vec3& p : surface.thickness.across) values.push_back(p[axis]);
    data.point_data.push_back({name, 1, std::move(values)});
  }
  std::vector<double> cells;
  const std::vector<double>& at = surface.thickness.thickness;
  for (const auto& [a, b, c] : surface.mesh.triangles) cells.push_back((at[a] + at[b] + at[c]) / 3);
  data.cell_data.push_back({"thickness", 1, std::move(cells)});
  data.field_data.push_back({"stage", 1, std::vector<std::string>{"thickness"}});
  data.field_data.push_back({"tolerance", 1, std::vector<double>{surface.tolerance}});
  data.field_data.push_back({"correction", 1, std::vector<double>{surface.correction}});
  for (const auto& [name, text] : {std::pair{"units", surface.coordinates.units}, {"SPACE", surface.coordinates.space}})
    if (!text.empty()) data.field_data.push_back({name, 1, std::vector<std::string>{text}});
  data.field_data.push_back({"version", 1, std::vector<std::string>{QUENCH_VERSION}});
  return data;
}

Table summary_of(const ThicknessDistribution& d, const Coordinates& coordinates) {
  Table table;
  table.rows = 1;
  const auto add = [&](const char* name, const std::string& unit, const char* meaning, double value) {
    table.columns.push_back({name, unit, meaning, std::vector<double>{value}});
  };
  const std::string& unit = coordinates.units;
  add("count", "", "Voxels or pixels, or the area of a surface.", d.weight());
  add("mean", unit, "Mean thickness.", d.mean());
  add("sd", unit, "Standard deviation of the thickness.", d.deviation());
  add("min", unit, "Least thickness.", d.least());
  for (const auto& [name, share] : {std::pair{"p1", 0.01},
                                    {"p5", 0.05},
                                    {"p10", 0.1},
                                    {"p25", 0.25},
                                    {"median", 0.5},
                                    {"p75", 0.75},
                                    {"p90", 0.9},
                                    {"p95", 0.95},
                                    {"p99", 0.99}})
    add(name, unit, "Thickness that this share does not exceed.", d.percentile(share));
  add("max", unit, "Largest thickness.", d.largest());
  return table;
}

Table histogram_of(const ThicknessDistribution& d, const Coordinates& coordinates) {
  Table table;
  std::vector<double> from, to, weight, share, cumulative;
  double below = 0;
  std::size_t first = 0, last = d.bins().size();
  while (last > 0 && d.bins()[last - 1] == 0) --last;
  while (first < last && d.bins()[first] == 0) ++first;
  for (std::size_t b = first; b < last; ++b) {
    below += d.bins()[b];
    from.push_back(static_cast<double>(b) * d.bin_width());
    to.push_back(static_cast<double>(b + 1) * d.bin_width());
    weight.push_back(d.bins()[b]);
    share.push_back(d.bins()[b] / d.weight());
    cumulative.push_back(below / d.weight());
  }
  table.rows = from.size();
  const std::string& unit = coordinates.units;
  table.columns = {{"from", unit, "Least thickness of the bin.", from},
                   {"to", unit, "Thickness below which it ends.", to},
                   {"count", "", "Voxels or pixels in it, or the area.", weight},
                   {"share", "", "Share of them.", share},
                   {"cumulative", "", "Share of all below the end of the bin.", cumulative}};
  return table;
}

}  // namespace quench::pipeline
