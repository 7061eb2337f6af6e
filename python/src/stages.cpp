// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>

#include "values.h"

namespace quench::python {

double Axis::resolve(const std::string& text, const std::string& field) const {
  return scale().resolve(pipeline::parse_length(text, field), field);
}

Record Axis::data(const Fire* with, bool sequence) const {
  Record result = file ? *file : pipeline::core_file(core);
  if (!with) return result;
  if (!sequence || axis().grid.is_plane())
    add_burning(result, with->burning);
  else
    add_burning(result, with->burning, with->family ? with->sequence : burn_sequence(axis(), with->burning));
  return result;
}

std::shared_ptr<Axis> compute_axis(std::shared_ptr<Shape> shape, const pipeline::AxisOptions& options,
                                   Context& context) {
  auto result = std::make_shared<Axis>();
  result->core = pipeline::core_of(*shape, options, &context);
  result->voxel_core = !result->axis().is_fitted();
  result->spacing = shape->shape.grid().spacing;
  if (shape->shape.grid().is_plane()) result->sites = {shape->shape.grid(), boundary_vertices(shape->shape)};
  result->shape = std::move(shape);
  return result;
}

std::shared_ptr<const Fire> restored(const Axis& axis, std::shared_ptr<const Fire> fire, Context& context) {
  if (!fire || !fire->stored) return fire;
  const BurnOptions& options = fire->burning.options;
  Record burned;
  burned.field_data = fire->sequence;
  if (std::optional<Burning> kept = kept_burning(burned, axis.axis(), options, &context)) {
    auto result = std::make_shared<Fire>();
    result->burning = std::move(*kept);
    return result;
  }
  // Of the plane, in no time.
  return compute_fire(axis, {options.plane ? 0 : options.omega, options.propagation}, false, nullptr, context);
}

std::shared_ptr<const Fire> compute_fire(const Axis& axis, const FireOptions& how, bool family,
                                         const std::shared_ptr<const Fire>& last, Context& context) {
  const MedialAxis& m = axis.axis();
  pipeline::BurningOptions options;
  if (how.omega > 0) options.omega = pipeline::world_length(how.omega);
  options.propagation = how.propagation;
  if (axis.file) pipeline::take_recorded(options, *axis.file);
  const double wanted = options.omega ? options.omega->value : default_omega(m.complex, m.points);
  const bool same = last && ((last->burning.options.omega == wanted && last->burning.options.propagation ==
                                                                           options.propagation.value_or(Propagation::segments)) ||
                             m.complex.edges.empty());
  const std::shared_ptr<const Fire> known = same ? restored(axis, last, context) : nullptr;
  if (same && (!family || known->family)) return known;
  auto fire = std::make_shared<Fire>();
  if (same) {
    fire->burning = known->burning;
  } else {
    std::optional<Burning> kept;
    if (axis.file) kept = pipeline::kept_burning_of(m, *axis.file, axis.voxel_core, options, axis.scale(), &context);
    fire->burning =
        kept ? std::move(*kept) : pipeline::burning_of(m, axis.voxel_core, options, true, axis.scale(), &context);
  }
  if (!family) return fire;
  RefinedAxis refined = pipeline::curves_of(m, fire->burning, &context);
  if (refined.plane && refined.mgf.empty() && axis.file)  // of a file the values are not measures of the axis
    if (const DataArray* mgf = find_array(axis.file->point_data, kMgf); mgf && mgf->size() == refined.points.size())
      refined.mgf = mgf->numbers();
  if (!m.grid.is_plane()) fire->sequence = burn_sequence(m, fire->burning);
  fire->burning.sectors.reset();  // what the curves needed, most of its memory
  fire->family = std::make_shared<const pipeline::FamilyResult>(
      pipeline::family_of(std::move(refined), axis.core.topology, {}, &context));
  return fire;
}

pipeline::GraphOptions graph_options(const Axis& axis) {
  pipeline::GraphOptions options;
  if (axis.voxel_core) {
    if (axis.shape) options.shape = &axis.shape->shape;
    options.voxel = axis.spacing;
  } else if (axis.shape && axis.shape->surface) {
    options.surface = &*axis.shape->surface;
  }
  if (axis.sites) options.sites = &*axis.sites;
  return options;
}

std::shared_ptr<SkeletonValue> compute_skeleton(std::shared_ptr<Axis> axis, const Fire& fire, const Thetas& thetas,
                                                Context& context) {
  pipeline::SkeletonOptions options;
  options.theta2 = pipeline::parse_length_or_auto(thetas.theta2, "theta2");
  options.theta1 = pipeline::parse_theta1(thetas.theta1);
  options.full_tips = thetas.full_tips;
  auto result = std::make_shared<SkeletonValue>();
  result->checked = pipeline::skeleton_of(*fire.family, options, axis->scale(), fire.burning.options.omega, &context);
  result->member = result->checked.skeleton;
  result->drawn = pipeline::draw_branches(result->checked, graph_options(*axis), axis->scale(), &context);
  result->about.field_data = axis->data(&fire).field_data;
  result->axis = std::move(axis);
  return result;
}

}  // namespace quench::python
