// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "quench/error.h"
#include "quench/solid_stages.h"
#include "values.h"

namespace quench::python {
namespace {

// "auto": nothing.
std::optional<double> length_in(const Shape& shape, const std::string& text, const char* field) {
  const std::optional<pipeline::Length> length = pipeline::parse_length_or_auto(text, field);
  if (!length) return {};
  return shape.scale().resolve(*length, field);
}

py::tuple thickness_of_voxels(const std::shared_ptr<Shape>& shape, const std::shared_ptr<Shape>& mask, bool between,
                              const std::string& correction, const py::object& listener, int threads) {
  const std::optional<double> given = length_in(*shape, correction, "correction");
  std::vector<float> values = run(listener, threads, [&](Context& context) {
    const MedialAxis core = pipeline::whole_core(*shape, &context);
    ThicknessOptions options;
    options.between = between;
    options.correction = given.value_or(thickness_correction(core));
    options.mask = mask ? &mask->shape : nullptr;
    return thickness_volume(shape->shape, core, options, &context);
  });
  return py::make_tuple(own(std::move(values)), sides_of(shape->shape.grid()));
}

py::dict thickness_of_surface(const std::shared_ptr<Shape>& shape, const std::string& tolerance,
                              const py::object& listener, int threads) {
  const std::optional<double> given = length_in(*shape, tolerance, "tolerance");
  pipeline::MeasuredSurface found =
      run(listener, threads, [&](Context& context) { return pipeline::measured_surface(*shape, given, &context); });
  py::dict result;
  result["vertices"] = own(std::move(found.mesh.points));
  result["faces"] = own(std::move(found.mesh.triangles));
  result["thickness"] = own(std::move(found.thickness.thickness));
  result["across"] = own(std::move(found.thickness.across));
  return result;
}

}  // namespace

void bind_thickness(py::module_& m) {
  m.def("local_thickness", &thickness_of_voxels);
  m.def("surface_thickness", &thickness_of_surface);
}

}  // namespace quench::python
