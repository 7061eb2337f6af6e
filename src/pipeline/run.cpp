// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/run_measures.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/solid_stages.h"

namespace quench::pipeline {
namespace {

void add_axis(PageBuilder& builder, const MedialAxis& axis, const AxisRun& result, const Scale& scale,
              const RunOptions& options) {
  for (const MeasureKind& measure : kMeasures)
    if (const auto threshold = field_number(result.file, std::string(measure.name).c_str()))
      builder.page.pruning = {std::string(measure.name), *threshold};
  builder.page.burning = result.burned.options;
  if (!axis.grid.is_plane()) builder.page.theta2 = theta2_of(options.skeleton, scale);
  builder.page.theta1 = theta1_of(options.skeleton, scale);
  if (axis.has_levels() && options.page_sliders) builder.add_core(axis, result.file.point_data, true);
}

/// The surface, and the origin that suits the whole grid.
void add_shape(PageBuilder& builder, LoadedShape& shape) {
  const Grid& grid = shape.shape.grid();
  const Vec3 dims(static_cast<double>(grid.dims[0]), static_cast<double>(grid.dims[1]),
                  static_cast<double>(grid.dims[2]));
  builder.set_origin(grid.world(Vec3::Zero()), grid.world(dims));
  builder.add_shape(shape);
}

}  // namespace

AxisRun run_axis(const MedialAxis& axis, Record&& file, bool voxel_core, const Topology& wanted, const Scale& scale,
                 const RunOptions& options, Context* context) {
  if (options.skeleton.main_axes && !axis.grid.is_plane() && std::isfinite(theta2_of(options.skeleton, scale)))
    throw Error(ErrorCode::usage, "main axes are those of skeletons of curves, not of sheets; take theta2 'inf'",
                "theta2");
  AxisRun result;
  result.file = std::move(file);
  std::optional<Burning> kept = kept_burning_of(axis, result.file, voxel_core, options.burning, scale, context);
  Burning burning = kept ? std::move(*kept) : burning_of(axis, voxel_core, options.burning, true, scale, context);
  result.burned = figures_of(burning);
  result.burned.from_file = kept.has_value();
  if (axis.grid.is_plane()) result.medial_points = medial_points(axis, burning);
  if (options.on_burned) options.on_burned(result.burned);
  const bool sequence = options.keep_sequence && !axis.grid.is_plane();
  add_burning(result.file, burning, sequence ? burn_sequence(axis, burning) : std::vector<DataArray>());
  if (options.page) {
    add_axis(*options.page, axis, result, scale, options);
    checkpoint(context, "page", 1);
  }
  RefinedAxis refined = curves_of(axis, std::move(burning), context);
  // An axis that was read has no values of measures; its file has them.
  const DataArray* mgf = find_array(result.file.point_data, kMgf);
  if (refined.plane && refined.mgf.empty() && mgf && mgf->components == 1)
    if (std::vector<double> values = mgf->numbers(); values.size() == refined.points.size())
      refined.mgf = std::move(values);
  FamilyResult family =
      family_of(std::move(refined), wanted, floor_of(options.skeleton, scale, result.burned.options.omega), context);
  result.curves = family.curves;
  result.skeleton = skeleton_of(family, options.skeleton, scale, result.burned.options.omega, context);
  result.graph = draw_branches(result.skeleton, options.graph, scale, context);
  if (options.measures && !result.skeleton.skeleton.plane)
    result.parts = parts_of(result.skeleton.skeleton, parts_options(options.graph.voxel), context);
  if (options.page) {
    options.page->add_skeleton(result.skeleton.skeleton, result.graph);
    if (result.parts) options.page->add_sheets(*result.parts);
    if (options.page_sliders) options.page->add_family(std::move(family.family));
    checkpoint(context, "page", 1);
  }
  return result;
}

RunResult run(LoadedShape& shape, const RunOptions& options, Context* context) {
  if (options.graph.extend && shape.surface)
    throw Error(ErrorCode::usage,
                "branches can only be drawn out to the boundary of the voxels or pixels that the axis is that of; take "
                "the surface 'voxels'",
                "extend");
  RunResult result;
  if (options.page) {
    add_shape(*options.page, shape);
    checkpoint(context, "page", 1);
  }
  result.core = core_of(shape, options.axis, context);
  if (options.on_core) options.on_core(result.core);
  RunOptions of_axis = options;
  of_axis.keep_sequence = true;
  if (result.core.axis.is_fitted()) {
    of_axis.graph.surface = &*shape.surface;
  } else {
    of_axis.graph.shape = &shape.shape;
    of_axis.graph.voxel = shape.shape.grid().spacing;
  }
  PlaneSites sites;
  if (shape.shape.grid().is_plane()) {
    sites = {shape.shape.grid(), boundary_vertices(shape.shape)};
    of_axis.graph.sites = &sites;
  }
  result.axis = run_axis(result.core.axis, core_file(result.core), !result.core.axis.is_fitted(), result.core.topology,
                         shape.scale(), of_axis, context);
  result.axis.skeleton.reconstructed = reconstructed_share(shape.shape, result.axis.skeleton.skeleton, context);
  if (options.measures) {
    result.thickness = thickness_of(shape, result.core.axis, result.axis.skeleton.skeleton, context);
    if (options.page && options.page_sliders) {
      options.page->add_thickness(result.core.axis, context);
      add_meshes_of(shape, result.core.axis, *options.page, context);
    }
  }
  if (options.narrower) {
    const double width = shape.scale().resolve(*options.narrower, "narrower");
    const VoxelShape::Box box = shape.shape.foreground_box();
    std::int64_t bytes = 1;
    for (std::size_t a = 0; a < 3; ++a) bytes *= box.end[a] - box.begin[a];
    require_memory(bytes, "what is wider than asked for", {"a lower resolution"}, context);
    result.wide = wide_part(shape.shape, result.core.axis, width, context);
    result.axis.graph = outside_of(result.axis.graph, *result.wide);
  }
  checkpoint(context, "skeleton", 1);
  return result;
}

}  // namespace quench::pipeline
