// SPDX-License-Identifier: Apache-2.0
// Results in parts for pickles: python/quench/_pickles.py puts them together.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include "archive.h"
#include "values.h"

namespace quench::python {

// All members of a struct in their order: structured bindings take no fewer and no more, so that none is forgotten.
#define QUENCH_FIELDS(Type, ...)                     \
  void fields(auto& archive, Is<Type> auto& value) { \
    auto& [__VA_ARGS__] = value;                     \
    archive(__VA_ARGS__);                            \
  }

QUENCH_FIELDS(Grid, dims, spacing, origin, direction, dimension)
QUENCH_FIELDS(Coordinates, units, space, y_down, y_recorded)
QUENCH_FIELDS(TriangleMesh, points, triangles)
QUENCH_FIELDS(CellComplex, vertex_count, edges, face_offsets, face_vertices, face_edges)
QUENCH_FIELDS(CellValues, vertex, edge, face)
QUENCH_FIELDS(Topology, euler, betti)
QUENCH_FIELDS(Volume, grid, samples, coordinates, spacing_source, picture)
QUENCH_FIELDS(DataArray, name, components, values)
QUENCH_FIELDS(Record, points, verts, lines, poly_offsets, poly_corners, point_data, cell_data, field_data)
QUENCH_FIELDS(Table::Column, name, unit, meaning, values)
QUENCH_FIELDS(Table, columns, rows)

// Shapes.
QUENCH_FIELDS(ForegroundReport, voxels_before, components_removed, voxels_removed, cavities_filled, voxels_filled,
              voxels_closed, voxels_joined, components_joined, weak_dropped)
QUENCH_FIELDS(PreparationReport, before, done)
QUENCH_FIELDS(ProposedThreshold, rule, threshold, reason, seed)
QUENCH_FIELDS(SurfaceTopology, euler, components, manifold, surface_euler, boundary_edges)
QUENCH_FIELDS(SurfaceDefects, open_edges, unbalanced_edges, degenerate_faces, duplicate_faces, flipped_faces,
              filled_holes, flipped_components, scanlines, defective_scanlines, winding_share, doubtful_share)
QUENCH_FIELDS(TopologyRepair, before, after, added, removed, places, working_resolution)
QUENCH_FIELDS(Voxelization, shape, longest_side, surface, solid_betti, topology, repair, topology_known,
              topology_changed, topology_difference, fill, fill_reason, sound, defects)
QUENCH_FIELDS(Polygons, rings)
QUENCH_FIELDS(PolygonFeature, polygons, number, id, properties, fill, y_down)
QUENCH_FIELDS(pipeline::LoadedShape, shape, topology, longest_side, image, coordinates, parameters, from_mesh,
              mesh_points, mesh_triangles, voxelization, resolution, mesh, polygon, spacing_source, cleaned, prepared,
              chosen, values, surface)

inline void fields(Writer& archive, const VoxelShape& shape) {
  std::vector<std::uint32_t> sizes;
  if (!shape.empty())
    for (std::int64_t z = 0; z < shape.grid().dims[2]; ++z)
      for (std::int64_t y = 0; y < shape.grid().dims[1]; ++y)
        sizes.push_back(static_cast<std::uint32_t>(shape.row(y, z).size()));
  archive(shape.grid());
  archive.own(std::move(sizes));
  archive(shape.runs());
}
inline void fields(Reader& archive, VoxelShape& shape) {
  const auto grid = archive.take<Grid>();
  const auto sizes = archive.take<std::vector<std::uint32_t>>();
  const auto runs = archive.take<std::vector<Run>>();
  shape = VoxelShape(grid);
  std::span<const Run> left(runs);
  for (const std::uint32_t size : sizes) {
    shape.append_row(left.first(std::min<std::size_t>(size, left.size())));
    left = left.subspan(std::min<std::size_t>(size, left.size()));
  }
  if (!runs.empty()) shape.validate();
}
inline void fields(Writer& archive, const Surface& surface) { archive(surface.mesh(), surface.kind()); }
template <>
inline Surface Reader::take<Surface>() {
  auto mesh = take<TriangleMesh>();
  return Surface(std::move(mesh), take<SurfaceKind>());
}

// Axes.
QUENCH_FIELDS(Measure, name, values, levels)
QUENCH_FIELDS(MedialAxis, complex, points, radius, measures, face_sites, edge_sites, sites, grid, voxel_points,
              voxel_radius, surface)
QUENCH_FIELDS(pipeline::PlaneSites, grid, sites)
QUENCH_FIELDS(SurfaceFit, moved, outside, mean_move, largest_move)
QUENCH_FIELDS(pipeline::Length, number, unit, text)
QUENCH_FIELDS(pipeline::CorePlan, sites, held, at_once, bricks, in_bricks)
QUENCH_FIELDS(pipeline::CellCounts, vertices, edges, faces)
QUENCH_FIELDS(pipeline::AxisOptions, pruning, rule, full, measures, bricks_in)
QUENCH_FIELDS(pipeline::CoreResult, axis, options, plan, threshold, longest_side, topology, reconstructed, coverage,
              whole, all, kept, coordinates, parameters, fit)
QUENCH_FIELDS(BurnOptions, omega, radius, propagation, plane, parents, rounded)

inline void fields(Writer& archive, const pipeline::Pruning& pruning) {
  archive(std::string(pruning.measure), pruning.threshold);
}
inline void fields(Reader& archive, pipeline::Pruning& pruning) {
  const auto measure = archive.take<std::string>();
  const MeasureKind* kind = find_measure_kind(measure);
  pruning.measure = kind ? kind->name : kDetail;
  archive(pruning.threshold);
}

// Skeletons, their graphs and parts.
QUENCH_FIELDS(Skeleton, theta2, theta1, theta1_radii, full_tips, rims_above, smooth, plane, main_axes, complex, points,
              radius, burn_time, curve_burn_time, on_curve, mgf, edge_thickness, edge_level, edge_branch,
              face_thickness, face_level, face_sheet)
QUENCH_FIELDS(pipeline::SkeletonResult, skeleton, topology, reconstructed)
QUENCH_FIELDS(CurveGraph::Node, point, radius, kind, component, degree, sheet, vertex)
QUENCH_FIELDS(CurveGraph::Branch, from, to, points, radius, length, mean_radius, min_radius, max_radius, thickness,
              tortuosity, component, vertices, erosion_thickness, mgf)
QUENCH_FIELDS(CurveGraph, nodes, branches, components, sheets, sheet_only)
QUENCH_FIELDS(Structure, sheets, seams, face_sheet, edge_seam, vertex_seam, junction)
QUENCH_FIELDS(Sheet, faces, component, area, mean_thickness, min_thickness, max_thickness, mean_erosion, max_erosion,
              rim_length, seam_length, borders, euler, orientable, centre, normal, flatness, largest_off, seams,
              neighbours)
QUENCH_FIELDS(Seam, edges, length, mean_thickness, min_thickness, max_thickness, sheets, ends, closed)
QUENCH_FIELDS(Junction, vertex, point, thickness, seams, sheets)
QUENCH_FIELDS(Parts, structure, sheets, seams, junctions)
QUENCH_FIELDS(SheetMesh, points, radius, erosion, triangles, sheet, seam_edges, seam, fixed)
QUENCH_FIELDS(PartsOptions, more_radius)
QUENCH_FIELDS(pipeline::PartsRun, parts, mesh, options)

// Trees.
QUENCH_FIELDS(Traits, axes, branches, sample, sholl, depths)
QUENCH_FIELDS(TreeEdit, kind, from, to, radius, length, cost, grey)
QUENCH_FIELDS(Tree::Branch, parent, axis, plant, points, radius, bridged, strahler, order, type, source)
QUENCH_FIELDS(Tree::Axis, parent, level, plant, branches, children, points, radius, position, stem, label, foreign)
QUENCH_FIELDS(Tree::Plant, root, main_axis, soma, label, foreign)
QUENCH_FIELDS(Tree, branches, axes, plants, down, rule, coordinates, foreign)
QUENCH_FIELDS(pipeline::TreeRun, tree, traits, edits, components_before, loops_before, length_before, edited,
              edited_topology)

// Solids and simplifications.
QUENCH_FIELDS(DistanceFigures, mean, p99, largest)
QUENCH_FIELDS(OneSidedDistances, outside, either, places)
QUENCH_FIELDS(VolumeErrors, shape, envelope, missing, added)
QUENCH_FIELDS(pipeline::SolidErrors, surface, from_solid, from_surface, volume)
QUENCH_FIELDS(Collapse, kept, removed, point, radius)
QUENCH_FIELDS(CollapseSequence, start, steps)
QUENCH_FIELDS(Simplified, axis, errors, sequence)
QUENCH_FIELDS(BoundaryPoints, points, areas)

#undef QUENCH_FIELDS

namespace {

/// What a pickle begins with: numbers are as they are in memory, and members those of this version.
std::string mark_of(const std::string& kind) { return fmt::format("quench {} {}", QUENCH_VERSION, kind); }

Writer begin_pickle(std::shared_ptr<const void> owner, const std::string& kind) {
  Writer writer(std::move(owner));
  writer(mark_of(kind));
  return writer;
}

/// (bytes, list of arrays, what else it is made of ...)
template <class... Others>
py::tuple pieces(Writer&& writer, const Others&... others) {
  py::list large;
  for (Array& array : writer.large) large.append(py::cast(std::move(array)));
  return py::make_tuple(py::bytes(writer.small), large, others...);
}

/// The bytes and arrays of a pickle while they are read.
class Unpickled {
 public:
  Unpickled(const std::string& kind, const py::bytes& small, const py::list& large) : held_(small) {
    std::vector<std::span<const std::byte>> arrays;
    for (const py::handle& array : large) {
      kept_.push_back(py::reinterpret_borrow<py::buffer>(array).request());
      const py::buffer_info& info = kept_.back();
      arrays.emplace_back(static_cast<const std::byte*>(info.ptr), static_cast<std::size_t>(info.size * info.itemsize));
    }
    reader.emplace(static_cast<std::string_view>(held_), std::move(arrays));
    if (const auto mark = reader->take<std::string>(); mark != mark_of(kind))
      throw Error(ErrorCode::input, fmt::format("this pickle is of '{}', and this is '{}'; pickles are read by the "
                                                "version that wrote them, files (save()) by later ones too",
                                                mark, mark_of(kind)));
  }
  template <class... T>
  void operator()(T&... values) {
    (*reader)(values...);
  }
  void finish() const { reader->finish(); }
  std::optional<Reader> reader;

 private:
  py::bytes held_;
  std::vector<py::buffer_info> kept_;
};

/// The states of a burning as files have them; of the plane none, as it is burned in no time.
void write_fire(Writer& writer, const Axis& axis) {
  writer(axis.fire != nullptr);
  if (!axis.fire) return;
  const Fire& fire = *axis.fire;
  writer(fire.burning.options);
  std::vector<DataArray> sequence = fire.sequence;
  if (!fire.family && !fire.stored && !fire.burning.options.plane) sequence = burn_sequence(axis.axis(), fire.burning);
  writer.own(std::move(sequence));
}

std::shared_ptr<const Fire> read_fire(Unpickled& from) {
  if (!from.reader->take<bool>()) return nullptr;
  auto fire = std::make_shared<Fire>();
  from(fire->burning.options, fire->sequence);
  fire->stored = true;
  return fire;
}

py::tuple pieces_of_shape(const std::shared_ptr<Shape>& s) {
  Writer writer = begin_pickle(s, "Shape");
  writer(*s);
  return pieces(std::move(writer));
}

py::tuple pieces_of_axis(const std::shared_ptr<Axis>& a) {
  Writer writer = begin_pickle(a, "Axis");
  writer(a->core, a->file, a->spacing, a->sites, a->voxel_core);
  write_fire(writer, *a);
  return pieces(std::move(writer), a->shape);
}

std::shared_ptr<Axis> unpickled_axis(const py::bytes& small, const py::list& large, std::shared_ptr<Shape> shape) {
  Unpickled from("Axis", small, large);
  auto axis = std::make_shared<Axis>();
  axis->shape = std::move(shape);
  from(axis->core, axis->file, axis->spacing, axis->sites, axis->voxel_core);
  axis->fire = read_fire(from);
  from.finish();
  return axis;
}

py::tuple pieces_of_skeleton(const std::shared_ptr<SkeletonValue>& s) {
  Writer writer = begin_pickle(s, "Skeleton");
  writer(s->has_axis, s->checked, s->drawn, s->member, s->about);
  return pieces(std::move(writer), s->axis);
}

std::shared_ptr<SkeletonValue> unpickled_skeleton(const py::bytes& small, const py::list& large,
                                                  std::shared_ptr<Axis> axis) {
  Unpickled from("Skeleton", small, large);
  auto skeleton = std::make_shared<SkeletonValue>();
  skeleton->axis = std::move(axis);
  from(skeleton->has_axis, skeleton->checked, skeleton->drawn, skeleton->member, skeleton->about);
  from.finish();
  return skeleton;
}

py::tuple pieces_of_graph(const std::shared_ptr<GraphValue>& g) {
  Writer writer = begin_pickle(g, "Graph");
  writer(g->graph);
  return pieces(std::move(writer), g->skeleton);
}

py::tuple pieces_of_parts(const std::shared_ptr<PartsValue>& p) {
  Writer writer = begin_pickle(p, "Parts");
  writer(p->run, p->about, p->units);
  return pieces(std::move(writer));
}

py::tuple pieces_of_tree(const std::shared_ptr<TreeValue>& t) {
  Writer writer = begin_pickle(t, "Tree");
  writer(t->run, t->upright);
  return pieces(std::move(writer), t->axis);
}

py::tuple pieces_of_solid(const std::shared_ptr<SolidValue>& s) {
  Writer writer = begin_pickle(s, "Solid");
  const pipeline::SolidResult& r = s->result;
  writer(s->coordinates, r.envelope.kind(), r.voxels, r.on_grid, r.cut_off, r.topology, r.of_axis, r.errors, r.surface);
  return pieces(std::move(writer), s->shape, s->axis, s->skeleton);
}

std::shared_ptr<SolidValue> unpickled_solid(const py::bytes& small, const py::list& large, std::shared_ptr<Shape> shape,
                                            std::shared_ptr<Axis> axis, std::shared_ptr<SkeletonValue> skeleton) {
  Unpickled from("Solid", small, large);
  Coordinates coordinates;
  from(coordinates);
  const auto kind = from.reader->take<EnvelopeKind>();
  const MedialAxis of = skeleton ? balls_of(*skeleton) : MedialAxis();
  pipeline::SolidResult r{Envelope(skeleton ? of : axis->axis(), kind), {}, {}, 0, {}, {}, {}, {}};
  from(r.voxels, r.on_grid, r.cut_off, r.topology, r.of_axis, r.errors, r.surface);
  from.finish();
  return std::make_shared<SolidValue>(
      SolidValue{std::move(shape), std::move(axis), std::move(skeleton), std::move(coordinates), std::move(r)});
}

py::tuple pieces_of_simplification(const std::shared_ptr<SimplificationValue>& s) {
  Writer writer = begin_pickle(s, "Simplification");
  writer(s->boundary, s->boundary_is, s->result, s->fits);
  return pieces(std::move(writer), s->from);
}

std::shared_ptr<SimplificationValue> unpickled_simplification(const py::bytes& small, const py::list& large,
                                                              std::shared_ptr<Axis> axis) {
  Unpickled from("Simplification", small, large);
  auto value = std::make_shared<SimplificationValue>();
  value->from = std::move(axis);
  from(value->boundary, value->boundary_is, value->result, value->fits);
  from.finish();
  return value;
}

}  // namespace

void bind_pickles(py::module_& m) {
  m.def("pieces_of", &pieces_of_shape);
  m.def("pieces_of", &pieces_of_axis);
  m.def("pieces_of", &pieces_of_skeleton);
  m.def("pieces_of", &pieces_of_graph);
  m.def("pieces_of", &pieces_of_parts);
  m.def("pieces_of", &pieces_of_tree);
  m.def("pieces_of", &pieces_of_solid);
  m.def("pieces_of", &pieces_of_simplification);

  m.def("restore_Shape", [](const py::bytes& small, const py::list& large) {
    Unpickled from("Shape", small, large);
    auto shape = std::make_shared<Shape>();
    from(*shape);
    from.finish();
    return shape;
  });
  m.def("restore_Axis", &unpickled_axis);
  m.def("restore_Skeleton", &unpickled_skeleton);
  m.def("restore_Graph", [](const py::bytes& small, const py::list& large, std::shared_ptr<SkeletonValue> skeleton) {
    Unpickled from("Graph", small, large);
    auto graph = std::make_shared<GraphValue>();
    graph->skeleton = std::move(skeleton);
    from(graph->graph);
    from.finish();
    return graph;
  });
  m.def("restore_Parts", [](const py::bytes& small, const py::list& large) {
    Unpickled from("Parts", small, large);
    auto parts = std::make_shared<PartsValue>();
    from(parts->run, parts->about, parts->units);
    from.finish();
    return parts;
  });
  m.def("restore_Tree", [](const py::bytes& small, const py::list& large, std::shared_ptr<Axis> axis) {
    Unpickled from("Tree", small, large);
    auto tree = std::make_shared<TreeValue>();
    tree->axis = std::move(axis);
    from(tree->run, tree->upright);
    from.finish();
    return tree;
  });
  m.def("restore_Solid", &unpickled_solid);
  m.def("restore_Simplification", &unpickled_simplification);
}

}  // namespace quench::python
