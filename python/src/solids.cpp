// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "quench/envelope.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/solid_stages.h"
#include "values.h"

namespace quench::python {
namespace {

using Solid = std::shared_ptr<SolidValue>;

Grid grid_for(const Axis& axis, const MedialAxis& of, EnvelopeKind kind, int resolution) {
  if (axis.shape) return axis.shape->shape.grid();
  if (axis.file && resolution == 0)
    if (const auto grid = pipeline::grid_of(*axis.file)) return *grid;
  constexpr int kDefault = 256;
  const Envelope envelope(of, kind);
  const double side = (envelope.high() - envelope.low()).maxCoeff();
  if (!(side > 0)) throw Error(ErrorCode::input, "one point without a radius has no solid");
  Grid grid = grid_around(envelope, side / (resolution > 0 ? resolution : kDefault));
  if (of.grid.is_plane()) {
    grid.dims[2] = 1;
    grid.origin[2] = 0;
    grid.make_plane();
  }
  return grid;
}

// Of an axis, or of a skeleton of it.
Solid make_solid(const std::shared_ptr<Axis>& from, const std::shared_ptr<SkeletonValue>& skeleton, bool full,
                 int resolution, Context& context) {
  const Axis& axis = skeleton ? *skeleton->axis : *from;
  const MedialAxis balls = skeleton ? balls_of(*skeleton) : MedialAxis();
  const MedialAxis& of = skeleton ? balls : axis.axis();
  const EnvelopeKind kind = full ? EnvelopeKind::full : EnvelopeKind::balls;
  const Grid grid = grid_for(axis, of, kind, resolution);
  return std::make_shared<SolidValue>(SolidValue{
      axis.shape, from, skeleton, axis.core.coordinates, pipeline::solid_of(of, kind, grid, axis.shape.get(), &context)});
}

void fill_voxels(const SolidValue& solid, const py::buffer& mask) {
  const py::buffer_info held = mask.request(true);
  const Grid in_buffer = grid_of(held, {1, 1, 1});
  const VoxelShape& voxels = solid.result.on_grid;
  if (in_buffer.dims != voxels.grid().dims) throw Error(ErrorCode::usage, "the array has not the shape of the voxels");
  const auto steps = steps_of(held);
  auto* data = static_cast<std::uint8_t*>(held.ptr);
  for (std::int64_t z = 0; z < in_buffer.dims[2]; ++z)
    for (std::int64_t y = 0; y < in_buffer.dims[1]; ++y)
      for (const Run& run : voxels.row(y, z))
        for (std::int64_t x = run.begin; x < run.end; ++x) data[x * steps[0] + y * steps[1] + z * steps[2]] = 1;
}

py::dict figures(const DistanceFigures& f) {
  py::dict d;
  d["mean"] = f.mean;
  d["p99"] = f.p99;
  d["largest"] = f.largest;
  return d;
}

py::object errors_of(const SolidValue& solid) {
  if (!solid.result.errors) return py::none();
  const pipeline::SolidErrors& errors = *solid.result.errors;
  py::dict d, volume;
  if (errors.from_solid) {
    d["surface"] = name_of(errors.surface);
    d["surface_from_solid"] = dict_of(*errors.from_solid);
    d["solid_from_surface"] = dict_of(*errors.from_surface);
  }
  volume["shape"] = errors.volume.shape;
  volume["solid"] = errors.volume.envelope;
  volume["missing"] = errors.volume.missing;
  volume["added"] = errors.volume.added;
  d["volume"] = volume;
  return d;
}

}  // namespace

py::dict dict_of(const OneSidedDistances& of) {
  py::dict d;
  d["outside"] = figures(of.outside);
  d["either_side"] = figures(of.either);
  d["places"] = of.places;
  return d;
}

MedialAxis balls_of(const SkeletonValue& skeleton) {
  MedialAxis of;
  of.complex = skeleton.checked.skeleton.complex;
  of.points = skeleton.checked.skeleton.points;
  of.radius = skeleton.checked.skeleton.radius;
  of.grid = skeleton.axis->axis().grid;
  return of;
}

void bind_solids(py::module_& m) {
  py::class_<SolidValue, Solid>(m, "Solid")
      .def_property_readonly("envelope",
                             [](const Solid& s) { return s->result.envelope.kind() == EnvelopeKind::full; })
      .def_property_readonly("dims", [](const Solid& s) { return sides_of(s->result.on_grid.grid()); })
      .def_property_readonly("dimension", [](const Solid& s) { return s->result.on_grid.grid().dimension; })
      .def_property_readonly("cut_off", [](const Solid& s) { return s->result.cut_off; })
      .def_property_readonly(
          "topology",
          [](const Solid& s) { return py::make_tuple(s->result.topology.euler, s->result.topology.betti); })
      .def("fill", [](const Solid& s, const py::buffer& mask) { fill_voxels(*s, mask); })
      .def("errors", [](const Solid& s) { return errors_of(*s); })
      .def("distance",
           [](const Solid& s, const py::buffer& points, const py::object& listener, int threads) {
             const std::vector<Vec3> at = points_of(points);
             return own(run(listener, threads, [&](Context& c) {
               std::vector<double> distance(at.size());
               base::in_arena(&c, [&] {
                 base::for_indices(at.size(), [&](std::size_t i) { distance[i] = s->result.envelope.distance(at[i]); });
               });
               return distance;
             }));
           })
      .def("mesh",
           [](const Solid& s, const py::object& listener, int threads) {
             const auto mesh = std::make_shared<const TriangleMesh>(run(
                 listener, threads, [&](Context& c) { return mesh_of(s->result.envelope, s->result.voxels, &c); }));
             return py::make_tuple(view(mesh, std::span<const Vec3>(mesh->points)),
                                   view(mesh, std::span<const std::array<std::uint32_t, 3>>(mesh->triangles)));
           })
      .def("save", [](const Solid& s, const std::string& file, bool as_volume, const py::object& listener, int threads) {
        run_cancellable(listener, threads, [&](Context& c) {
          if (as_volume)
            io::write_volume(file, s->result.on_grid, s->coordinates, &c);
          else
            io::write_record(file, pipeline::mesh_of(s->result, &c), {"distance"});
        });
      });
  m.def("solid_of_axis",
        [](const std::shared_ptr<Axis>& a, bool full, int resolution, const py::object& listener, int threads) {
          return run(listener, threads, [&](Context& c) { return make_solid(a, nullptr, full, resolution, c); });
        });
  m.def("solid_of_skeleton", [](const std::shared_ptr<SkeletonValue>& s, bool full, int resolution,
                                const py::object& listener, int threads) {
    return run(listener, threads, [&](Context& c) { return make_solid(nullptr, s, full, resolution, c); });
  });
}

}  // namespace quench::python
