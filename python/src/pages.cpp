// SPDX-License-Identifier: Apache-2.0
// Interactive pages of results: as `quench run` writes them.
#include <pybind11/stl.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>

#include "page_program.h"
#include "quench/error.h"
#include "quench/page.h"
#include "values.h"

namespace quench::python {
namespace {

// Layers share the triangles: a fifth for the surface, a third of the rest for the medial axis if a skeleton follows.
struct Builder {
  Page page;
  std::size_t left = kPageTriangles;
  void take(std::size_t triangles) { left -= std::min(left, triangles); }
};

Builder begin(const Axis& axis, const std::vector<Vec3>& points, const std::string& file) {
  if (program::page_program().empty())
    throw Error(ErrorCode::failed,
                "this quench was built without its interactive page; build it again with Node.js and npm installed");
  Builder b;
  b.page.program = "quench " QUENCH_VERSION;
  b.page.title = std::filesystem::path(file).stem().string();
  b.page.side = axis.core.longest_side;
  b.page.voxel = axis.spacing.minCoeff();
  b.page.topology = axis.core.topology;
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()) > 16 * (high - low).maxCoeff())
    b.page.origin = (0.5 * (low + high)).array().round();
  if (axis.shape) {
    b.page.unit = axis.shape->coordinates.units;
    b.take(add_surface(b.page, axis.shape->voxels, b.left / 5));
    add_sites(b.page, axis.shape->voxels);
    add_samples(b.page, axis.shape->voxels);
  }
  return b;
}

void write_axis(const Axis& axis, const Fire& fire, const std::optional<std::pair<double, double>>& thetas,
                const std::string& file) {
  Builder b = begin(axis, axis.axis().points, file);
  b.page.lambda = axis.core.lambda;
  b.page.burning = fire.burning.options;
  MedialAxis leveled;  // an axis from a file has no levels: it is all there, at every lambda
  const MedialAxis* cells = &axis.axis();
  if (std::ranges::all_of(cells->measures, [](const Measure& m) { return m.level.empty(); })) {
    leveled.complex = cells->complex;
    leveled.points = cells->points;
    leveled.radius = cells->radius;
    constexpr double kAlways = std::numeric_limits<double>::infinity();
    Measure lambda{std::string(kLambda), {}, {}};
    lambda.level.vertex.assign(cells->points.size(), kAlways);
    lambda.level.edge.assign(cells->complex.edges.size(), kAlways);
    lambda.level.face.assign(cells->complex.face_count(), kAlways);
    leveled.measures.push_back(std::move(lambda));
    cells = &leveled;
  }
  b.take(add_core(b.page, *cells, axis.data(&fire).point_data, thetas ? b.left / 3 : b.left));
  if (thetas) {
    b.page.theta2 = thetas->first;
    b.page.theta1 = thetas->second;
    b.take(add_skeleton(b.page, *fire.family, b.left));
  }
  write_page(file, b.page, program::page_program());
}

void write_skeleton(const SkeletonValue& s, const std::string& file) {
  const Record data = skeleton_file(s.checked.skeleton, s.checked.topology, s.about);
  Builder b = begin(*s.axis, data.points, file);
  b.page.theta2 = s.checked.skeleton.theta2;
  b.page.theta1 = s.checked.skeleton.theta1;
  add_still(b.page, data, b.left);
  write_page(file, b.page, program::page_program());
}

}  // namespace

void bind_pages(py::module_& m) {
  m.def("page_of_axis", [](const std::shared_ptr<Axis>& axis, const std::optional<std::pair<double, double>>& thetas,
                           const std::string& file, const py::object& listener, int threads) {
    const auto known = axis->fire;
    // Of the last omega; the axis is burned with the default one where it was not.
    const double omega = known ? known->burning.options.omega : 0;
    const auto fire = run(listener, threads, [&](Context& c) {
      auto burned = compute_fire(*axis, omega, thetas.has_value(), known, c);
      write_axis(*axis, *burned, thetas, file);
      return burned;
    });
    axis->fire = fire;
  });
  m.def("page_of_skeleton", [](const std::shared_ptr<SkeletonValue>& skeleton, const std::string& file) {
    run_cancellable(py::none(), 0, [&](Context&) { write_skeleton(*skeleton, file); });
  });
  m.attr("has_pages") = !program::page_program().empty();
}

}  // namespace quench::python
