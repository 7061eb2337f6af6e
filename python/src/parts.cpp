// SPDX-License-Identifier: Apache-2.0
#include "quench/parts.h"

#include <pybind11/stl.h>

#include "quench/io.h"
#include "quench/solid_stages.h"
#include "quench/tree.h"
#include "values.h"

namespace quench::python {

namespace {

using PartsPointer = std::shared_ptr<PartsValue>;

// A sheet by itself: points, triangles, and named arrays.
py::tuple sheet_of(const Record& sheet) {
  std::vector<std::array<std::uint32_t, 3>> triangles(sheet.poly_count());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) triangles[t][i] = sheet.poly_corners[3 * t + i];
  auto kept = std::make_shared<const std::vector<std::array<std::uint32_t, 3>>>(std::move(triangles));
  py::dict arrays;
  for (const DataArray& array : sheet.point_data)
    std::visit(
        [&](const auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          if constexpr (!std::is_same_v<T, std::string>) arrays[array.name.c_str()] = own(values);
        },
        array.values);
  return py::make_tuple(own(sheet.points), view(kept, std::span<const std::array<std::uint32_t, 3>>(*kept)), arrays);
}

Record file_of_parts(const PartsValue& p) {
  Record all = to_record(p.run.mesh, p.run.options);
  pipeline::add_parts_fields(all, p.about);
  return all;
}

}  // namespace

void bind_parts(py::module_& m) {
  py::class_<PartsValue, PartsPointer>(m, "Parts")
      .def_property_readonly("units", [](const PartsPointer& p) { return p->units; })
      .def_property_readonly("more_radius", [](const PartsPointer& p) { return p->run.options.more_radius; })
      .def_property_readonly("vertices", [](const PartsPointer& p) { return view(p, p->run.mesh.points); })
      .def_property_readonly("radius", [](const PartsPointer& p) { return view(p, p->run.mesh.radius); })
      .def_property_readonly("erosion_thickness", [](const PartsPointer& p) { return view(p, p->run.mesh.erosion); })
      .def_property_readonly("faces",
                             [](const PartsPointer& p) {
                               return view(p, std::span<const std::array<std::uint32_t, 3>>(p->run.mesh.triangles));
                             })
      .def_property_readonly("face_sheet", [](const PartsPointer& p) { return view(p, p->run.mesh.sheet); })
      .def_property_readonly("seam_edges",
                             [](const PartsPointer& p) {
                               return view(p, std::span<const std::array<std::uint32_t, 2>>(p->run.mesh.seam_edges));
                             })
      .def_property_readonly("edge_seam", [](const PartsPointer& p) { return view(p, p->run.mesh.seam); })
      .def("table",
           [](const PartsPointer& p, const std::string& name) {
             return columns_of(name == "sheets"  ? sheet_table(p->run.parts, p->units)
                               : name == "seams" ? seam_table(p->run.parts, p->units)
                                                 : junction_table(p->run.parts, p->units));
           })
      .def("meshes",
           [](const PartsPointer& p) {
             py::list meshes;
             for (const Record& sheet : sheet_records(p->run.mesh, p->run.options)) meshes.append(sheet_of(sheet));
             return meshes;
           })
      .def("save",
           [](const PartsPointer& p, const std::string& file) {
             io::write_record(file, file_of_parts(*p), {.quality_array = "thickness"});
           })
      .def("save_table", [](const PartsPointer& p, const std::string& file) {
        io::write_table(file, sheet_table(p->run.parts, p->units));
      });
  m.def("parts_of", [](const std::shared_ptr<SkeletonValue>& s, const std::optional<std::string>& remesh,
                       const py::object& listener, int threads) {
    return run(listener, threads, [&](Context& c) {
      std::optional<pipeline::Length> length;
      if (remesh) length = pipeline::parse_length(*remesh, "remesh");
      auto parts = std::make_shared<PartsValue>();
      parts->run =
          pipeline::run_parts(s->checked.skeleton, graph_options(*s->axis).voxel, length, s->axis->scale(), &c);
      parts->about = s->about;
      parts->units = s->axis->core.coordinates.units;
      return parts;
    });
  });
}

}  // namespace quench::python
