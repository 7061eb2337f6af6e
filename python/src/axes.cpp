// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/measures.h"
#include "quench/solid_stages.h"
#include "quench/verify.h"
#include "rasters.h"
#include "values.h"

namespace quench::python {
namespace {

std::shared_ptr<Axis> axis_of_file(Record data, const std::string& file, Context& context) {
  pipeline::LoadedAxis loaded = pipeline::axis_of(std::move(data), file, &context);
  auto result = std::make_shared<Axis>();
  result->core.axis = std::move(loaded.axis);
  result->core.longest_side = loaded.scale.longest_side;
  result->core.reconstructed = pipeline::field_number(loaded.data, "reconstructed").value_or(std::nan(""));
  result->core.coverage = pipeline::field_number(loaded.data, "coverage").value_or(std::nan(""));
  result->core.threshold = std::nan("");
  for (const MeasureKind& measure : kMeasures)
    if (const auto threshold = pipeline::field_number(loaded.data, std::string(measure.name).c_str())) {
      result->core.options.pruning.measure = measure.name;
      result->core.threshold = *threshold;
    }
  result->core.topology = topology(result->axis().complex);
  result->core.coordinates = loaded.coordinates;
  result->spacing = loaded.spacing;
  result->voxel_core = loaded.voxel_core;
  result->sites = std::move(loaded.sites);
  result->file = std::move(loaded.data);
  return result;
}

/// A simplified or smoothed axis of the same shape.
std::shared_ptr<Axis> reshaped(const Axis& from, const MedialAxis& mesh, const char* stage, Context& context) {
  auto result = axis_of_file(pipeline::reshaped_file(mesh, {}, stage), stage, context);
  result->core.longest_side = from.core.longest_side;
  result->core.coordinates = from.core.coordinates;
  result->spacing = from.spacing;
  result->shape = from.shape;
  return result;
}

using Simplification = std::shared_ptr<SimplificationValue>;

Simplification simplify_axis(const std::shared_ptr<Axis>& axis, std::size_t vertices, const std::string& error,
                             int fits, Context& context) {
  auto value = std::make_shared<SimplificationValue>();
  value->from = axis;
  value->fits = fits;
  SimplifyOptions options{vertices, {}, fits};
  if (!error.empty()) options.error = axis->resolve(error, "error");
  value->boundary = pipeline::boundary_of(axis->axis(), axis->shape.get(), &value->boundary_is, &context);
  value->result = pipeline::simplified(axis->axis(), value->boundary, options, &context);
  return value;
}

void bind_simplifications(py::module_& m) {
  py::class_<SimplificationValue, Simplification>(m, "Simplification")
      .def_property_readonly("most", [](const Simplification& s) { return s->result.sequence.most(); })
      .def_property_readonly("least", [](const Simplification& s) { return s->result.sequence.least(); })
      .def_property_readonly("boundary", [](const Simplification& s) { return s->boundary_is; })
      .def_property_readonly("errors",
                             [](const Simplification& s) { return dict_of(s->result.errors); })
      .def("axis",
           [](const Simplification& s, const py::object& listener, int threads) {
             return run(listener, threads,
                        [&](Context& c) { return reshaped(*s->from, s->result.axis, "simplified", c); });
           })
      .def("level", [](const Simplification& s, std::size_t vertices, const py::object& listener, int threads) {
        return run(listener, threads, [&](Context& c) {
          return reshaped(*s->from, fitted_level(s->result.sequence, vertices, s->boundary, s->fits, &c), "simplified",
                          c);
        });
      });
}

// The polygons of a complex as triangles, and the polygon of each.
py::tuple fans(const CellComplex& complex) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> polygon;
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
      polygon.push_back(static_cast<std::uint32_t>(f));
    }
  }
  return py::make_tuple(own(std::move(triangles)), own(std::move(polygon)));
}

const Shape& shape_of(const Axis& axis) {
  if (!axis.shape)
    throw Error(ErrorCode::usage,
                "the medial axis comes from a file, which does not hold the shape; 'quench verify' takes both, and "
                "medial_axis() keeps the shape it is of");
  return *axis.shape;
}

std::vector<std::string> measure_names(const MedialAxis& axis) {
  std::vector<std::string> names;
  for (const Measure& measure : axis.measures) names.push_back(measure.name);
  for (const std::string& name : derived_measures(axis))
    if (!axis.find_measure(name)) names.push_back(name);
  return names;
}

// Values and levels, each of vertices, edges and polygons; None where there are none.
py::tuple views(const std::shared_ptr<const void>& owner, const Measure& measure) {
  const auto of = [&](const CellValues& values) -> py::object {
    if (values.empty()) return py::none();
    return py::make_tuple(view(owner, values.vertex), view(owner, values.edge), view(owner, values.face));
  };
  return py::make_tuple(of(measure.value), of(measure.level));
}

std::shared_ptr<Axis> pruned_axis(const Axis& from, const std::string& text, Context& context) {
  if (from.file) throw Error(ErrorCode::usage, "a medial axis from a file cannot be pruned; compute it again");
  auto result = std::make_shared<Axis>();
  result->shape = from.shape;
  const std::string_view measure = from.core.options.pruning.measure;
  const pipeline::Pruning pruning = pipeline::pruning_of(measure, text, measure);
  result->core = pipeline::pruned_further(*from.shape, from.core, pruning.threshold.value(), &context);
  result->sites = from.sites;
  result->spacing = from.spacing;
  return result;
}

}  // namespace

pipeline::Pruning pruning_of(const std::string& measure, const std::string& threshold) {
  const bool own_argument = measure == kDetail || measure == kLambda;
  return pipeline::pruning_of(measure, threshold, own_argument ? measure : "prune_by");
}

VerifyOptions verify_options(const Shape& shape, std::size_t samples) {
  VerifyOptions options;
  options.samples = samples;
  if (shape.shape.grid().is_plane()) options.y_down = shape.coordinates.y_down;
  if (shape.surface) {
    options.surface = &shape.surface->mesh();
    options.surface_kind = name_of(shape.surface->kind());
    options.subdivided = shape.subdivided();
  }
  return options;
}

py::list checks_of(const Certificate& certificate) {
  py::list result;
  for (const Check& check : certificate.checks) result.append(py::make_tuple(check.name, check.passed, check.detail));
  return result;
}

void bind_axes(py::module_& m) {
  using Pointer = std::shared_ptr<Axis>;
  bind_simplifications(m);
  py::class_<Axis, Pointer>(m, "Axis")
      .def_property_readonly("vertices", [](const Pointer& a) { return view(a, a->axis().points); })
      .def_property_readonly("dimension", [](const Pointer& a) { return a->axis().grid.dimension; })
      .def_property_readonly("y_down", [](const Pointer& a) { return a->core.coordinates.y_down; })
      .def_property_readonly("units", [](const Pointer& a) { return a->core.coordinates.units; })
      .def("rows_and_columns", [](const Pointer& a) { return rows_and_columns(a->axis().points, shape_of(*a).image); })
      .def_property_readonly("radius", [](const Pointer& a) { return view(a, a->axis().radius); })
      .def_property_readonly("edges",
                             [](const Pointer& a) {
                               return view(a, std::span<const std::array<std::uint32_t, 2>>(a->axis().complex.edges));
                             })
      .def_property_readonly("polygon_offsets",
                             [](const Pointer& a) { return view(a, a->axis().complex.face_offsets); })
      .def_property_readonly("polygon_corners",
                             [](const Pointer& a) { return view(a, a->axis().complex.face_vertices); })
      .def_property_readonly("polygon_edges", [](const Pointer& a) { return view(a, a->axis().complex.face_edges); })
      .def("fans", [](const Pointer& a) { return fans(a->axis().complex); })
      .def("measure_names", [](const Pointer& a) { return measure_names(a->axis()); })
      .def("measure",
           [](const Pointer& a, const std::string& name) {
             if (const Measure* known = a->axis().find_measure(name)) return views(a, *known);
             const auto derived = std::make_shared<const Measure>(derived_measure(a->axis(), name));
             return views(derived, *derived);
           })
      // None where a file does not say it, and coverage where it was not measured.
      .def_property_readonly("pruned_by",
                             [](const Pointer& a) -> std::optional<std::string_view> {
                               if (!a->is_pruned()) return {};
                               return a->core.options.pruning.measure;
                             })
      .def_property_readonly("threshold",
                             [](const Pointer& a) -> std::optional<double> {
                               if (!a->is_pruned()) return {};
                               return a->core.threshold;
                             })
      .def_property_readonly("coverage",
                             [](const Pointer& a) -> std::optional<double> {
                               if (a->core.options.pruning.measure != kDetail || std::isnan(a->core.coverage))
                                 return {};
                               return a->core.coverage;
                             })
      .def_property_readonly("surface", [](const Pointer& a) { return name_of(a->axis().surface); })
      .def_property_readonly("reconstructed", [](const Pointer& a) { return a->core.reconstructed; })
      .def_property_readonly("longest_side", [](const Pointer& a) { return a->core.longest_side; })
      .def_property_readonly("shape", [](const Pointer& a) { return a->shape; })
      .def_property_readonly(
          "topology", [](const Pointer& a) { return py::make_tuple(a->core.topology.euler, a->core.topology.betti); })
      .def("simplified",
           [](const Pointer& a, std::size_t vertices, const std::string& error, int fits, const py::object& listener,
              int threads) {
             return run(listener, threads, [&](Context& c) { return simplify_axis(a, vertices, error, fits, c); });
           })
      .def("smoothed",
           [](const Pointer& a, double most, int iterations, const py::object& listener, int threads) {
             return run(listener, threads, [&](Context& c) {
               MedialAxis mesh;
               mesh.complex = a->axis().complex;
               mesh.points = a->axis().points;
               mesh.radius = a->axis().radius;
               smooth(mesh, most, iterations, &c);
               return reshaped(*a, mesh, "smoothed", c);
             });
           })
      .def("resolve", &Axis::resolve)
      .def("pruned",
           [](const Pointer& a, const std::string& threshold, const py::object& listener, int threads) {
             return run(listener, threads, [&](Context& c) { return pruned_axis(*a, threshold, c); });
           })
      .def("burn",
           [](const Pointer& a, double omega, const std::string& propagation, const py::object& listener, int threads) {
             const auto known = a->fire;
             auto fire = run(listener, threads,
                             [&](Context& c) { return compute_fire(*a, {omega, propagation}, false, known, c); });
             a->fire = fire;
             return py::make_tuple(view(fire, fire->burning.burn_time), view(fire, fire->burning.erosion_thickness),
                                   fire->burning.options.omega);
           })
      .def("skeleton",
           [](const Pointer& a, const std::string& theta2, const std::string& theta1, bool full_tips, double omega,
              const std::string& propagation, const py::object& listener, int threads) {
             const auto known = a->fire;
             const auto fire = run(
                 listener, threads, [&](Context& c) { return compute_fire(*a, {omega, propagation}, true, known, c); });
             a->fire = fire;
             return run(listener, threads, [&](Context& c) {
               return compute_skeleton(a, *fire, {theta2, theta1, full_tips}, c);
             });
           })
      .def("forget", [](const Pointer& a) { a->fire.reset(); })
      .def("verify",
           [](const Pointer& a, std::size_t samples, const py::object& listener, int threads) {
             const Shape& shape = shape_of(*a);
             const VerifyOptions options = verify_options(shape, samples);
             const Certificate certificate = run(listener, threads, [&](Context& context) {
               return verify(shape.shape, a->data(nullptr), options, &context);
             });
             return checks_of(certificate);
           })
      .def("mark_balls",
           [](const Pointer& a, const py::buffer& mask, const py::object& listener, int threads) {
             mark_balls_in(mask, a->axis().points, a->axis().radius, shape_of(*a).image, listener, threads);
           })
      .def("save", [](const Pointer& a, const std::string& file, const std::string& quality, const py::object& listener,
                      int threads) {
        const auto fire = a->fire;
        run_cancellable(listener, threads, [&](Context& c) {
          io::write_record(file, a->data(restored(*a, fire, c).get(), true), {quality});
        });
      });
  m.def("compute_axis",
        [](const std::shared_ptr<Shape>& shape, const std::string& measure, const std::string& threshold,
           const std::string& rule, std::vector<std::string> measures, const py::object& listener, int threads) {
          pipeline::AxisOptions options;
          options.pruning = pruning_of(measure, threshold);
          options.measures = std::move(measures);
          options.rule = pipeline::lambda_rule_of(rule).value_or(LambdaRule::coface);
          return run(listener, threads, [&](Context& context) { return compute_axis(shape, options, context); });
        });
  m.def("check_measures", [](const std::string& names) { return pipeline::parse_measures(names); });
  m.def("check_threshold", [](const std::string& measure, const std::string& text) {
    return pipeline::pruning_of(measure, text, "prune_by").measure;
  });
  m.def("check_writable", [](const std::string& file) { io::check_writable_format(file); });
  m.def("check_length", [](const std::string& text, const std::string& field) {
    field == "theta1" ? void(pipeline::parse_theta1(text)) : void(pipeline::parse_length(text, field));
  });
  // A mesh as (vertices, triangles), or a medial axis where the file has radii.
  m.def("read_surface",
        [](const std::string& file, const std::string& radii, const py::object& listener, int threads) -> py::object {
          struct Read {
            Record data;
            TriangleMesh mesh;
            std::shared_ptr<Axis> axis;
          };
          Read read = run(listener, threads, [&](Context& context) {
            Read r;
            r.data = pipeline::read_surface(file, &context);
            if (!radii.empty()) pipeline::take_radii(r.data, radii, &context);
            if (find_array(r.data.point_data, "radius"))
              r.axis = axis_of_file(std::move(r.data), file, context);
            else
              r.mesh = to_triangle_mesh(r.data);
            return r;
          });
          if (read.axis) return py::cast(read.axis);
          return py::make_tuple(own(std::move(read.mesh.points)), own(std::move(read.mesh.triangles)));
        });
}

}  // namespace quench::python
