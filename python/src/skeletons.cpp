// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <ostream>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/verify.h"
#include "rasters.h"
#include "values.h"

namespace quench::python {

namespace {

using Pointer = std::shared_ptr<SkeletonValue>;

const Shape& shape_of(const SkeletonValue& s) {
  if (!s.axis->shape)
    throw Error(ErrorCode::usage,
                "the medial axis of this skeleton comes from a file, which does not hold the shape; medial_axis() "
                "keeps the shape it is of");
  return *s.axis->shape;
}

Record file_of(const SkeletonValue& s) { return pipeline::skeleton_file(s.checked, s.about); }

std::shared_ptr<GraphValue> graph_of(const Pointer& s, int smooth, const std::string& resample,
                                     const py::object& listener, int threads) {
  pipeline::GraphOptions options = graph_options(*s->axis);
  options.smooth = smooth;
  options.resample = pipeline::parse_resample(resample);
  auto result = std::make_shared<GraphValue>();
  result->skeleton = s;
  result->graph =
      run(listener, threads, [&](Context&) { return pipeline::measured_graph(s->member, options, s->axis->scale()); });
  if (s->member.plane) add_measures(result->graph, with_branches(s->member, result->graph));
  return result;
}

// Columns of a table: one array per member.
template <class Rows, class Get>
Array column(const Rows& rows, const Get& get) {
  using T = std::decay_t<decltype(get(rows[0]))>;
  std::vector<T> values;
  values.reserve(rows.size());
  for (const auto& row : rows) values.push_back(get(row));
  return own(std::move(values));
}

py::dict nodes_of(const CurveGraph& g) {
  using Node = CurveGraph::Node;
  py::dict table;
  table["point"] = column(g.nodes, [](const Node& n) { return n.point; });
  table["radius"] = column(g.nodes, [](const Node& n) { return n.radius; });
  table["kind"] = column(g.nodes, [](const Node& n) { return static_cast<std::uint8_t>(n.kind); });
  table["component"] = column(g.nodes, [](const Node& n) { return n.component; });
  table["degree"] = column(g.nodes, [](const Node& n) { return n.degree; });
  table["sheet"] = column(g.nodes, [](const Node& n) { return n.sheet; });
  return table;
}

py::dict branches_of(const CurveGraph& g) {
  using Branch = CurveGraph::Branch;
  py::dict table;
  table["from"] = column(g.branches, [](const Branch& b) { return b.from; });
  table["to"] = column(g.branches, [](const Branch& b) { return b.to; });
  table["component"] = column(g.branches, [](const Branch& b) { return b.component; });
  table["from_point"] = column(g.branches, [&](const Branch& b) { return g.nodes[b.from].point; });
  table["to_point"] = column(g.branches, [&](const Branch& b) { return g.nodes[b.to].point; });
  table["from_kind"] =
      column(g.branches, [&](const Branch& b) { return static_cast<std::uint8_t>(g.nodes[b.from].kind); });
  table["to_kind"] = column(g.branches, [&](const Branch& b) { return static_cast<std::uint8_t>(g.nodes[b.to].kind); });
  table["length"] = column(g.branches, [](const Branch& b) { return b.length; });
  table["mean_radius"] = column(g.branches, [](const Branch& b) { return b.mean_radius; });
  table["min_radius"] = column(g.branches, [](const Branch& b) { return b.min_radius; });
  table["max_radius"] = column(g.branches, [](const Branch& b) { return b.max_radius; });
  table["thickness"] = column(g.branches, [](const Branch& b) { return b.thickness; });
  table["tortuosity"] = column(g.branches, [](const Branch& b) { return b.tortuosity; });
  return table;
}

py::list paths_of(const std::shared_ptr<GraphValue>& g) {
  py::list result;
  for (const CurveGraph::Branch& b : g->graph.branches)
    result.append(py::make_tuple(view(g, b.points), view(g, b.radius), view(g, b.erosion_thickness), view(g, b.mgf)));
  return result;
}

py::dict write_swc_file(const GraphValue& g, const std::string& file, const std::optional<std::array<double, 3>>& root,
                        const std::string& type) {
  io::SwcOptions options;
  options.type = io::swc_type_of(type, "swc_type");
  if (root) options.root = Vec3((*root)[0], (*root)[1], (*root)[2]);
  options.coordinates = g.skeleton->axis->core.coordinates;
  const io::SwcReport report = io::write_swc(file, g.graph, options);
  py::dict result;
  result["trees"] = report.trees;
  result["samples"] = report.samples;
  result["sheet_links"] = report.sheet_links;
  result["cuts"] = report.cuts.size();
  return result;
}

}  // namespace

void bind_skeletons(py::module_& m) {
  py::class_<SkeletonValue, Pointer>(m, "Skeleton")
      .def_property_readonly("vertices", [](const Pointer& s) { return view(s, s->checked.skeleton.points); })
      .def_property_readonly("dimension", [](const Pointer& s) { return s->checked.skeleton.plane ? 2 : 3; })
      .def_property_readonly("y_down", [](const Pointer& s) { return s->axis->core.coordinates.y_down; })
      .def_property_readonly("units", [](const Pointer& s) { return s->axis->core.coordinates.units; })
      .def("rows_and_columns",
           [](const Pointer& s) { return rows_and_columns(s->checked.skeleton.points, shape_of(*s).image); })
      .def_property_readonly("radius", [](const Pointer& s) { return view(s, s->checked.skeleton.radius); })
      .def_property_readonly("burn_time", [](const Pointer& s) { return view(s, s->checked.skeleton.burn_time); })
      .def_property_readonly("edges",
                             [](const Pointer& s) {
                               return view(
                                   s, std::span<const std::array<std::uint32_t, 2>>(s->checked.skeleton.complex.edges));
                             })
      .def_property_readonly("edge_thickness",
                             [](const Pointer& s) { return view(s, s->checked.skeleton.edge_thickness); })
      .def_property_readonly("edge_branch", [](const Pointer& s) { return view(s, s->checked.skeleton.edge_branch); })
      .def_property_readonly("face_thickness",
                             [](const Pointer& s) { return view(s, s->checked.skeleton.face_thickness); })
      .def_property_readonly("polygon_offsets",
                             [](const Pointer& s) { return view(s, s->checked.skeleton.complex.face_offsets); })
      .def_property_readonly("polygon_corners",
                             [](const Pointer& s) { return view(s, s->checked.skeleton.complex.face_vertices); })
      .def_property_readonly("polygon_edges",
                             [](const Pointer& s) { return view(s, s->checked.skeleton.complex.face_edges); })
      .def_property_readonly("axis_shape", [](const Pointer& s) { return s->axis->shape; })
      .def_property_readonly("theta2", [](const Pointer& s) { return s->checked.skeleton.theta2; })
      .def_property_readonly("theta1", [](const Pointer& s) { return s->checked.skeleton.theta1; })
      .def_property_readonly("theta1_radii", [](const Pointer& s) { return s->checked.skeleton.theta1_radii; })
      .def_property_readonly("axis", [](const Pointer& s) { return s->has_axis ? s->axis : nullptr; })
      .def_property_readonly(
          "topology",
          [](const Pointer& s) { return py::make_tuple(s->checked.topology.euler, s->checked.topology.betti); })
      .def("reconstructed",
           [](const Pointer& s, const py::object& listener, int threads) {
             const Shape& shape = shape_of(*s);
             return run(listener, threads, [&](Context& c) {
               return pipeline::reconstructed_share(shape.shape, s->checked.skeleton, &c);
             });
           })
      .def("verify",
           [](const Pointer& s, std::size_t samples, const py::object& listener, int threads) {
             const Shape& shape = shape_of(*s);
             const VerifyOptions options = verify_options(shape, samples);
             const Certificate certificate =
                 run(listener, threads, [&](Context& c) { return verify(shape.shape, file_of(*s), options, &c); });
             return checks_of(certificate);
           })
      .def("mark_balls",
           [](const Pointer& s, const py::buffer& mask, const py::object& listener, int threads) {
             const Skeleton& k = s->checked.skeleton;
             mark_balls_in(mask, k.points, k.radius, shape_of(*s).image, listener, threads);
           })
      .def("mark_cells",
           [](const Pointer& s, const py::buffer& mask, const py::object& listener, int threads) {
             const Skeleton& k = s->checked.skeleton;
             mark_cells_in(mask, k.complex, k.points, shape_of(*s).image, listener, threads);
           })
      .def("graph", &graph_of)
      .def("save", [](const Pointer& s, const std::string& file, const std::string& quality, const py::object& listener,
                      int threads) {
        run_cancellable(listener, threads, [&](Context&) { io::write_record(file, file_of(*s), {quality}); });
      });
  using Graph = std::shared_ptr<GraphValue>;
  py::class_<GraphValue, Graph>(m, "Graph")
      .def_property_readonly("dimension", [](const Graph& g) { return g->skeleton->checked.skeleton.plane ? 2 : 3; })
      .def_property_readonly("y_down", [](const Graph& g) { return g->skeleton->axis->core.coordinates.y_down; })
      .def_property_readonly("units", [](const Graph& g) { return g->skeleton->axis->core.coordinates.units; })
      // Of places x, y, z where they are in the image: whole numbers at centres of voxels. None without a shape.
      .def("indices",
           [](const Graph& g, const py::buffer& points) -> py::object {
             if (!g->skeleton->axis->shape) return py::none();
             const Grid& grid = g->skeleton->axis->shape->image;
             std::vector<Vec3> places = points_of(points);
             for (Vec3& p : places) p = grid.lattice(p) - grid.first_centre();
             return py::cast(own(std::move(places)));
           })
      .def("nodes", [](const Graph& g) { return nodes_of(g->graph); })
      .def("branches", [](const Graph& g) { return branches_of(g->graph); })
      .def("paths", &paths_of)
      .def_property_readonly("components", [](const Graph& g) { return g->graph.components; })
      .def_property_readonly("sheets", [](const Graph& g) { return g->graph.sheets; })
      .def_property_readonly("sheet_only", [](const Graph& g) { return g->graph.sheet_only; })
      .def("write_swc", [](const Graph& g, const std::string& file, const std::optional<std::array<double, 3>>& root,
                           const std::string& type) { return write_swc_file(*g, file, root, type); })
      .def("write_graphml",
           [](const Graph& g, const std::string& file) {
             io::write_graphml(file, g->graph, g->skeleton->axis->core.coordinates);
           })
      .def("write_csv", [](const Graph& g, const std::string& file) { io::write_branches(file, g->graph); });
  m.def("write_text", [](const std::string& file, const std::string& text) {
    io::write_atomically(file, [&](std::ostream& out) { out << text; });
  });
  py::list kinds;
  for (int k = 0; k <= static_cast<int>(CurveGraph::NodeKind::border); ++k)
    kinds.append(name_of(static_cast<CurveGraph::NodeKind>(k)));
  m.attr("NODE_KINDS") = kinds;
}

}  // namespace quench::python
