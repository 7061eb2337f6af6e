// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "base/memory.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/voxelize.h"
#include "values.h"

namespace quench::python {

double Axis::resolve(const std::string& text, const std::string& argument) const {
  const Length length = parse_length(text, argument);
  const double voxel = spacing.minCoeff();
  if (length.unit == Length::Unit::voxels && voxel == 0)
    throw Error(ErrorCode::usage, fmt::format("{} {} needs a voxel size, which the medial axis does not say; give a "
                                              "fraction (0.01) or a world length (3.5abs)",
                                              argument, text));
  return length.resolve(core.longest_side, voxel);
}

Coordinates Axis::coordinates() const {
  if (shape) return shape->coordinates;
  const auto text = [&](const char* name) -> std::string {
    const DataArray* array = file ? find_array(file->field_data, name) : nullptr;
    const auto* texts = array ? std::get_if<std::vector<std::string>>(&array->values) : nullptr;
    return texts && texts->size() == 1 ? texts->front() : std::string();
  };
  return {text("units"), text("SPACE")};
}

Record Axis::data(const Fire* with) const {
  Record result = file ? *file : core_file(core, shape->coordinates, shape->parameters);
  if (with) add_burning(result, with->burning);
  return result;
}

std::shared_ptr<Shape> finished(Shape shape, const Cut& cut) {
  if (cut.subdivide < 1 || cut.subdivide > 64)
    throw Error(ErrorCode::usage, fmt::format("subdivide={} is not from 1 to 64", cut.subdivide));
  if (shape.longest_side == 0) shape.longest_side = shape.voxels.longest_side();
  if (cut.subdivide > 1) {
    const double parts = static_cast<double>(cut.subdivide) * cut.subdivide;
    const double bytes = parts * static_cast<double>(predicted_core_bytes(count_boundary_vertices(shape.voxels)));
    require_memory(static_cast<std::int64_t>(std::min(bytes, 0x1p62)), fmt::format("subdivide={}", cut.subdivide),
                   "a smaller one");
    shape.voxels = subdivide(shape.voxels, cut.subdivide);
  }
  shape.topology = topology(shape.voxels);
  return std::make_shared<Shape>(std::move(shape));
}

std::shared_ptr<Axis> compute_axis(std::shared_ptr<Shape> shape, const std::string& lambda, bool ball_rule,
                                   Context& context) {
  CheckedCoreOptions options;
  if (lambda != "auto")
    options.lambda = parse_length(lambda, "lambda_").resolve(shape->longest_side, shape->smallest());
  options.rule = ball_rule ? LambdaRule::ball : LambdaRule::coface;
  const std::int64_t sites = count_boundary_vertices(shape->voxels);
  const std::int64_t at_once = predicted_core_bytes(shape->voxels),
                     in_bricks = predicted_core_bytes_in_bricks(shape->voxels);
  options.in_bricks = at_once > base::available_memory() && in_bricks < at_once;
  require_memory(options.in_bricks ? in_bricks : at_once,
                 fmt::format("the medial axis of a shape with {} boundary vertices", sites),
                 "a lower resolution, or a part of the image");
  auto result = std::make_shared<Axis>();
  result->core = checked_core(shape->voxels, shape->topology, shape->longest_side, options, &context);
  if (result->core.reconstructed < 0.9)
    note(&context, fmt::format("the balls of the pruned medial axis contain only {:.4f} of the shape; use a smaller "
                               "lambda_ or 'auto'",
                               result->core.reconstructed));
  result->spacing = shape->voxels.grid().spacing;
  result->shape = std::move(shape);
  return result;
}

std::shared_ptr<const Fire> compute_fire(const Axis& axis, double omega, bool family,
                                         const std::shared_ptr<const Fire>& known, Context& context) {
  const MedialAxis& m = axis.axis();
  if (omega == 0) omega = default_omega(m.complex, m.points);
  const bool same = known && (known->burning.options.omega == omega || m.complex.edges.empty());
  if (same && (!family || known->family)) return known;
  auto fire = std::make_shared<Fire>();
  const Burning* burning = same ? &known->burning : &fire->burning;
  if (!same) {
    BurnOptions options;
    options.omega = omega;
    options.radius = axis.voxel_core ? RadiusRule::exact : RadiusRule::linear;
    require_memory(predicted_burn_bytes(m.complex, m.points, options), "burning the medial axis",
                   "a larger omega or lambda_");
    fire->burning = burn(m.complex, m.points, m.radius, options, &context);
  }
  if (!family) return fire;
  require_memory(predicted_skeleton_bytes(*burning), "the curves of this medial axis", "a larger omega or lambda_");
  RefinedAxis refined = quench_curves(m.complex, m.points, m.radius, *burning, &context);
  if (same) fire->burning = *burning;
  fire->burning.sectors.reset();
  fire->family = std::make_shared<const SkeletonFamily>(skeletons(std::move(refined), &context));
  return fire;
}

std::shared_ptr<SkeletonValue> compute_skeleton(std::shared_ptr<Axis> axis, const Fire& fire, double theta2,
                                                double theta1, Context& context) {
  auto result = std::make_shared<SkeletonValue>();
  const double voxel = axis->spacing.minCoeff();
  CheckedSkeletonOptions options;
  options.theta2 = theta2;
  options.theta1 = theta1;
  options.tips = voxel > 0 ? voxel : fire.burning.options.omega;
  result->checked = checked_skeleton(*fire.family, axis->core.topology, options, &context);
  result->about.field_data = axis->data(&fire).field_data;
  result->axis = std::move(axis);
  return result;
}

std::int64_t predicted_bytes(const VoxelShape& shape) {
  // 1.4 to 4.1 KB per site on a board, a torus, a root and smooth noise, with automatic lambda and omega.
  return predicted_core_bytes(0) + 4500 * count_boundary_vertices(shape);
}

}  // namespace quench::python
