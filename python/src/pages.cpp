// SPDX-License-Identifier: Apache-2.0
// Interactive pages and pictures of results: as `quench run` writes them.
#include <pybind11/stl.h>

#include <filesystem>

#include "values.h"

namespace quench::python {
namespace {

using pipeline::PageBuilder;

/// Whether a file is a picture, not a page.
bool is_picture(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return ending == ".png";
}

void say_pruning(Page& page, const Axis& axis) {
  if (axis.is_pruned()) page.pruning = {std::string(axis.core.options.pruning.measure), axis.core.threshold};
}

PageBuilder begin(const Axis& axis, const std::vector<Vec3>& points, const std::string& file) {
  if (!is_picture(file)) pipeline::require_page_program();
  PageBuilder builder;
  Page& page = builder.page;
  page.title = pipeline::title_of(file);
  page.side = axis.core.longest_side;
  page.voxel = axis.spacing.minCoeff();
  page.topology = axis.core.topology;
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  builder.set_origin(low, high);
  if (axis.axis().grid.is_plane()) builder.set_plane(axis.spacing, axis.core.coordinates.y_down);
  if (axis.shape) builder.add_shape(*axis.shape);
  return builder;
}

void add_skeleton(PageBuilder& builder, const SkeletonValue& s) {
  if (!builder.page.plane) builder.page.theta2 = s.checked.skeleton.theta2;
  builder.page.theta1 = s.checked.skeleton.theta1;
  builder.add_skeleton(s.checked.skeleton, s.drawn);
}

void write(const PageBuilder& builder, const std::string& file, const PictureSize& size, Context& context) {
  if (is_picture(file))
    write_png(file, draw_page(builder.page, options_of(size), &context), &context);
  else
    builder.write(file);
}

/// `fire`: of a page; a picture without one has the colours of the radius.
void write_axis(const Axis& axis, const Fire* fire, const SkeletonValue* skeleton, const std::string& file,
                const PictureSize& size, Context& context) {
  PageBuilder builder = begin(axis, axis.axis().points, file);
  say_pruning(builder.page, axis);
  if (fire) builder.page.burning = fire->burning.options;
  builder.add_core(axis.axis(), axis.data(fire).point_data, skeleton != nullptr);
  if (skeleton) {
    add_skeleton(builder, *skeleton);
    builder.add_family(fire->family->family);
  }
  write(builder, file, size, context);
}

void write_skeleton(const SkeletonValue& s, const std::string& file, const PictureSize& size, Context& context) {
  PageBuilder builder = begin(*s.axis, s.checked.skeleton.points, file);
  if (s.has_axis) say_pruning(builder.page, *s.axis);
  add_skeleton(builder, s);
  write(builder, file, size, context);
}

}  // namespace

PictureOptions options_of(const PictureSize& size) {
  PictureOptions options;
  if (size) std::tie(options.width, options.height, options.caption) = *size;
  return options;
}

void bind_pages(py::module_& m) {
  m.def("page_of_axis", [](const std::shared_ptr<Axis>& axis, const std::shared_ptr<SkeletonValue>& skeleton,
                           const std::string& file, const PictureSize& size, const py::object& listener,
                           int threads) {
    const auto known = axis->fire;
    // As the last time; the axis is burned by default where it was not.
    const auto fire = run(listener, threads, [&](Context& c) {
      auto burned = compute_fire(*axis, FireOptions::of(known), skeleton != nullptr, known, c);
      write_axis(*axis, burned.get(), skeleton.get(), file, size, c);
      return burned;
    });
    axis->fire = fire;
  });
  // Of an axis that nothing is burned for.
  m.def("picture_of_axis", [](const std::shared_ptr<Axis>& axis, const std::string& file, const PictureSize& size,
                              const py::object& listener, int threads) {
    const auto known = axis->fire;
    run_cancellable(listener, threads, [&](Context& c) {
      write_axis(*axis, restored(*axis, known, c).get(), nullptr, file, size, c);
    });
  });
  m.def("page_of_skeleton", [](const std::shared_ptr<SkeletonValue>& skeleton, const std::string& file,
                               const PictureSize& size, const py::object& listener, int threads) {
    run_cancellable(listener, threads, [&](Context& c) { write_skeleton(*skeleton, file, size, c); });
  });
  m.attr("has_pages") = pipeline::has_page_program();
}

}  // namespace quench::python
