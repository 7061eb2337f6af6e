// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "pipeline/page_program.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

constexpr double kFarFromZero = 16;     // in sides of the box: floats then lose what is seen
constexpr std::size_t kShapeShare = 5;  // what is looked at is what is around it
constexpr std::size_t kPlaneShare = 2;  // of the plane: all else is lines
constexpr std::size_t kCoreShare = 3;   // the skeleton is what one came for

}  // namespace

bool has_page_program() { return !page_program().empty(); }

void require_page_program() {
  if (!has_page_program())
    throw Error(ErrorCode::failed,
                "this quench was built without its interactive page; build it again with Node.js and npm installed");
}

std::string title_of(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(file, ignored).lexically_normal();
  std::filesystem::path stem = whole.stem();
  if (stem.extension() == ".nii") stem = stem.stem();
  if ((stem == "core" || stem == "skeleton") && whole.parent_path().has_filename())
    return whole.parent_path().filename().string();
  return stem.string();
}

PageBuilder::PageBuilder(std::size_t max_triangles) : left_(max_triangles) { page.program = "quench " QUENCH_VERSION; }

void PageBuilder::take(std::size_t triangles) {
  used_ += triangles;
  left_ -= std::min(left_, triangles);
}

void PageBuilder::set_origin(const Vec3& low, const Vec3& high) {
  const double far = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (far > kFarFromZero * (high - low).maxCoeff()) page.origin = (0.5 * (low + high)).array().round();
}

void PageBuilder::set_plane(const Vec3& pixel, bool y_down) {
  page.plane = true;
  page.y_down = y_down;
  if (page.unit.empty() && pixel == Vec3::Ones()) page.unit = "px";
}

void PageBuilder::add_shape(LoadedShape& shape) {
  page.side = shape.longest_side;
  page.voxel = shape.shape.grid().spacing.minCoeff();
  page.unit = shape.coordinates.units;
  if (shape.shape.grid().is_plane()) set_plane(shape.shape.grid().spacing, shape.coordinates.y_down);
  page.topology = shape.topology;
  if (shape.mesh && !shape.cleaned)
    take(add_surface(page, *shape.mesh, left_ / kShapeShare));
  else
    take(add_surface(page, shape.shape, left_ / (page.plane ? kPlaneShare : kShapeShare)));
  shape.mesh.reset();
  if (!shape.surface) add_sites(page, shape.shape);  // else balls touch the surface
  add_samples(page, shape.shape);
}

void PageBuilder::add_core(const MedialAxis& axis, const std::vector<DataArray>& measures, bool skeleton_follows) {
  const std::size_t share = skeleton_follows ? left_ / kCoreShare : left_;
  if (axis.has_levels()) return take(quench::add_core(page, axis, measures, share));
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  MedialAxis leveled;
  leveled.complex = axis.complex;
  leveled.points = axis.points;
  leveled.radius = axis.radius;
  Measure measure{page.pruning ? page.pruning->measure : std::string(kLambda), {}, {}};
  measure.level.vertex.assign(axis.points.size(), kAlways);
  measure.level.edge.assign(axis.complex.edges.size(), kAlways);
  measure.level.face.assign(axis.complex.face_count(), kAlways);
  leveled.measures.push_back(std::move(measure));
  take(quench::add_core(page, leveled, measures, share));
}

void PageBuilder::add_skeleton(const Skeleton& skeleton, const CurveGraph& graph) {
  take(quench::add_skeleton(page, skeleton, graph));
}

void PageBuilder::add_family(SkeletonFamily family) { take(quench::add_family(page, std::move(family), left_)); }

void PageBuilder::add_still(const Record& data) { take(quench::add_still(page, data, left_)); }

void PageBuilder::add_tree(const Tree& tree, const Traits& traits, const std::vector<TreeEdit>& edits, bool upright) {
  quench::add_tree(page, tree, traits, edits, upright);
  if (page.unit.empty()) page.unit = tree.coordinates.units;
  if (!(page.side > 0)) page.side = std::max((page.high - page.low).maxCoeff(), 1e-30);
}

void PageBuilder::write(const std::filesystem::path& file) const { write_page(file, page, page_program()); }

}  // namespace quench::pipeline
