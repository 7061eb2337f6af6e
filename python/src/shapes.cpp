// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "values.h"

namespace quench::python {
namespace {

using Triple = std::array<double, 3>;

Triple triple(const Vec3& v) { return {v[0], v[1], v[2]}; }

template <class T>
std::string code_of(const std::vector<T>&) {
  return py::format_descriptor<T>::format();
}

// Fortran order of volumes, axis 0 being x; C order of images, which have rows and columns.
py::buffer_info info(const Image& image) {
  const Grid& grid = image.volume->grid;
  const std::vector<py::ssize_t> shape = sides_of(grid);
  return std::visit(
      [&](const auto& samples) {
        const auto size = static_cast<py::ssize_t>(sizeof(samples[0]));
        using T = typename std::decay_t<decltype(samples)>::value_type;
        std::vector<py::ssize_t> strides{size * grid.dims[0], size};
        if (!grid.is_plane()) strides = {size, size * grid.dims[0], size * grid.dims[0] * grid.dims[1]};
        const auto axes = static_cast<py::ssize_t>(shape.size());
        return py::buffer_info(const_cast<T*>(samples.data()), size, code_of(samples), axes, shape, strides, true);
      },
      image.volume->samples);
}

/// What the caller should know of a shape, as notes.
std::shared_ptr<Shape> noted(Shape&& shape, Context& context) {
  if (shape.voxelization) {
    const Voxelization& v = *shape.voxelization;
    if (!v.fill_reason.empty()) note(&context, "fill " + std::string(fill_name(v.fill)) + ": " + v.fill_reason);
    if (!v.sound) note(&context, defects_text(v));
    if (const std::string text = v.repair ? repair_text(*v.repair) : ""; !text.empty()) note(&context, text);
    if (v.topology_changed) note(&context, "voxelization changed the topology: " + v.topology_difference);
  }
  if (shape.cleaned)
    if (const std::string much = much_dropped(*shape.cleaned, shape.shape.grid().is_plane()); !much.empty())
      note(&context, much);
  return std::make_shared<Shape>(std::move(shape));
}

std::shared_ptr<Shape> shape_of_array(const py::buffer& array, const Place* place,
                                      const pipeline::ShapeOptions& options, const py::object& listener, int threads) {
  const py::buffer_info held = array.request();
  const ImageView image = image_of(held, place ? placed(held, *place) : grid_of(held, {1, 1, 1}));
  const Coordinates coordinates = place ? place->coordinates : coordinates_of(image.grid);
  return run(listener, threads, [&](Context& context) {
    return noted(pipeline::shape_of(image, coordinates, options, &context), context);
  });
}

Place place_of(int dimension, const Triple& spacing, const Triple& origin, const std::array<Triple, 3>& direction,
               const std::string& units, const std::string& space, bool y_down) {
  Place place;
  place.coordinates = {units, space, y_down};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    place.grid.spacing[row] = spacing[a];
    place.grid.origin[row] = origin[a];
    for (std::size_t b = 0; b < 3; ++b) place.grid.direction(row, static_cast<Eigen::Index>(b)) = direction[a][b];
  }
  if (dimension == 2) place.grid.make_plane();
  return place;
}

std::shared_ptr<Shape> shape_of_mesh(const py::buffer& points, const py::buffer& triangles,
                                     const pipeline::ShapeOptions& options, const py::object& listener, int threads) {
  TriangleMesh mesh;
  mesh.points = points_of(points);
  mesh.triangles = triangles_of(triangles, mesh.points.size());
  return run(listener, threads,
             [&](Context& context) { return noted(pipeline::shape_of(std::move(mesh), options, &context), context); });
}

pipeline::ShapeOptions shape_options(const std::optional<Threshold>& threshold,
                                     const std::optional<std::int64_t>& label, bool invert, bool largest_component,
                                     std::int64_t min_component, bool fill_cavities, int subdivide,
                                     const std::optional<Triple>& spacing, std::int64_t resolution,
                                     const std::string& fill, const std::string& topology, const std::string& surface,
                                     const std::optional<Threshold>& seed_threshold, const std::string& rule,
                                     bool interpolate, int median, double blur, int close, int connectivity) {
  pipeline::ShapeOptions options;
  options.foreground = {.threshold = threshold,
                        .label = label,
                        .invert = invert,
                        .largest_component = largest_component,
                        .min_component = min_component,
                        .fill_cavities = fill_cavities};
  options.foreground.seed_threshold = seed_threshold;
  options.foreground.close = close;
  options.foreground.connectivity = connectivity;
  options.otsu = rule == "otsu";
  options.thin = rule == "thin";
  options.recommended = rule == "auto" || options.thin;
  options.preparation = {interpolate, median, blur};
  options.subdivide = subdivide;
  if (spacing) options.spacing = Vec3((*spacing)[0], (*spacing)[1], (*spacing)[2]);
  options.resolution = resolution;
  options.fill = fill_of(fill);
  options.topology = topology_of(topology);
  options.surface = surface_kind_of(surface);
  return options;
}

py::dict sample_named(const std::string& name, double noise, std::uint64_t seed, int branches, double fineness,
                      int touching) {
  Sample sample = make_sample(name, {noise, seed, branches, fineness, touching});
  py::list truth;
  for (const RootBranch& b : sample.branches) {
    py::dict entry;
    entry["parent"] = b.parent;
    entry["parent_point"] = b.parent_point;
    entry["length"] = b.length();
    entry["points"] = own(b.points);
    entry["radius"] = own(b.radius);
    truth.append(entry);
  }
  py::list damage;
  for (const RootDamage& d : sample.damage) {
    py::dict entry;
    entry["branch"] = d.branch;
    entry["other"] = d.other;
    entry["from"] = triple(d.from);
    entry["to"] = triple(d.to);
    entry["on_purpose"] = d.on_purpose;
    damage.append(entry);
  }
  py::dict result;
  result["touching"] = damage;
  result["vertices"] = own(std::move(sample.mesh.points));
  result["faces"] = own(std::move(sample.mesh.triangles));
  result["branches"] = truth;
  return result;
}

}  // namespace

Image image_of(const VoxelShape& shape, const Coordinates& coordinates) {
  auto volume = std::make_shared<Volume>();
  volume->grid = shape.grid();
  volume->coordinates = coordinates;
  const auto& dims = volume->grid.dims;
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]), 0);
  auto row = samples.begin();
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y, row += dims[0])
      for (const Run& r : shape.row(y, z)) std::fill(row + r.begin, row + r.end, std::uint8_t{1});
  volume->samples = std::move(samples);
  return {volume};
}

void bind_shapes(py::module_& m) {
  py::class_<Image>(m, "Image", py::buffer_protocol())
      .def_buffer(&info)
      .def_property_readonly("place", [](const Image& i) { return Place{i.volume->grid, i.volume->coordinates}; });
  py::class_<Place>(m, "Place")
      .def(py::init(&place_of))
      .def_property_readonly("dimension", [](const Place& p) { return p.grid.dimension; })
      .def_property_readonly("spacing", [](const Place& p) { return triple(p.grid.spacing); })
      .def_property_readonly("origin", [](const Place& p) { return triple(p.grid.origin); })
      .def_property_readonly("direction",
                             [](const Place& p) {
                               const Mat3& d = p.grid.direction;
                               return std::array<Triple, 3>{triple(d.row(0)), triple(d.row(1)), triple(d.row(2))};
                             })
      .def_property_readonly("units", [](const Place& p) { return p.coordinates.units; })
      .def_property_readonly("space", [](const Place& p) { return p.coordinates.space; })
      .def_property_readonly("y_down", [](const Place& p) { return p.coordinates.y_down; });
  py::class_<pipeline::ShapeOptions>(m, "ShapeOptions")
      .def(py::init(&shape_options), py::kw_only(), py::arg("threshold"), py::arg("label"), py::arg("invert"),
           py::arg("largest_component"), py::arg("min_component"), py::arg("fill_cavities"), py::arg("subdivide"),
           py::arg("spacing"), py::arg("resolution"), py::arg("fill"), py::arg("topology"), py::arg("surface"),
           py::arg("seed_threshold"), py::arg("rule"), py::arg("interpolate"), py::arg("median"), py::arg("blur"),
           py::arg("close"), py::arg("connectivity"))
      .def_readwrite("keep_values", &pipeline::ShapeOptions::keep_values)
      .def_readwrite("keep_mesh", &pipeline::ShapeOptions::keep_mesh);
  py::class_<Shape, std::shared_ptr<Shape>>(m, "Shape")
      .def_property_readonly("dims", [](const Shape& s) { return sides_of(s.image); })
      .def_property_readonly("spacing", [](const Shape& s) { return triple(s.shape.grid().spacing); })
      // (threshold, upper one of two or None, rule, reason) where the program has chosen one.
      .def_property_readonly("chosen",
                             [](const Shape& s) -> py::object {
                               if (!s.chosen) return py::none();
                               return py::make_tuple(s.chosen->value, s.chosen->seed, s.chosen->rule, s.chosen->reason);
                             })
      .def_property_readonly("voxel_count", [](const Shape& s) { return s.shape.voxel_count(); })
      .def("image", [](const Shape& s) { return image_of(s.shape, s.coordinates); });
  m.def("shape_of_array", &shape_of_array);
  m.def("shape_of_mesh", &shape_of_mesh);
  m.def("read_image", [](const std::string& file, const std::optional<Triple>& spacing, std::optional<int> dimension,
                         const std::string& channel, const py::object& listener, int threads) {
    io::VolumeReadOptions options;
    options.dimension = dimension;
    options.channel = channel;
    if (spacing) options.spacing = Vec3((*spacing)[0], (*spacing)[1], (*spacing)[2]);
    return run(listener, threads, [&](Context& context) {
      return Image{std::make_shared<const Volume>(io::read_volume(file, options, &context))};
    });
  });
  m.def("kind_of", [](const std::string& file) {
    const io::Kind kind = io::kind_of(file);
    return kind == io::Kind::surface    ? "surface"
           : kind == io::Kind::volume   ? "volume"
           : kind == io::Kind::polygons ? "polygons"
                                        : "unknown";
  });
  m.def("sample", &sample_named);
  m.def("refuse_unknown_kind", [](const std::string& file) { pipeline::refuse_unknown_kind(file); });
  m.def("samples", [] {
    py::dict result;
    for (const SampleInfo& s : built_in_samples()) {
      std::string text(s.description);
      if (!s.options.empty()) text += " (" + std::string(s.options) + ")";
      result[py::str(std::string(s.name))] = text;
    }
    return result;
  });
}

}  // namespace quench::python
