// SPDX-License-Identifier: Apache-2.0
#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "base/text.h"
#include "quench/io.h"
#include "shape_input.h"

namespace quench::program {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json("inf"); }

Json cells_section(const pipeline::CellCounts& cells, const Topology& topology) {
  return {{"vertices", cells.vertices},
          {"edges", cells.edges},
          {"faces", cells.faces},
          {"euler", topology.euler},
          {"betti", topology.betti}};
}

double rounded(double seconds) { return std::round(seconds * 1e4) / 1e4; }

std::int64_t predicted_bytes(const pipeline::CorePlan& plan) {
  return std::max(plan.held + plan.bytes(), Session::peak_bytes());
}

/// What digitization with the topology of the mesh did.
Json topology_section(const Voxelization& v) {
  Json section = {{"rule", topology_name(v.topology)},
                  {"solid_betti", v.solid_betti ? Json(*v.solid_betti) : Json(nullptr)},
                  {"added", 0},
                  {"removed", 0}};
  if (!v.repair) return section;
  section["added"] = v.repair->added;
  section["removed"] = v.repair->removed;
  section["betti_before"] = v.repair->before.betti;
  section["betti"] = v.repair->after.betti;
  if (v.repair->after.betti == v.solid_betti) return section;
  Json& places = section["places"] = Json::array();
  for (const Vec3& p : v.repair->places) places.push_back({p[0], p[1], p[2]});
  const std::int64_t works = v.repair->working_resolution;
  section["working_resolution"] = works > 0 ? Json(works) : Json(nullptr);
  return section;
}

}  // namespace

void write_report(const std::string& file, Json report, Session& session) {
  const auto& spent = session.seconds();
  const auto of = [&](std::initializer_list<const char*> stages) {
    double sum = 0;
    for (const char* stage : stages)
      if (const auto found = spent.find(stage); found != spent.end()) sum += found->second;
    return rounded(sum);
  };
  report["seconds"] = {{"voxelize", of({"read", "foreground", "components", "cavities", "voxelize"})},
                       {"delaunay", of({"peel", "delaunay"})},
                       {"core", of({"merge", "core"})},
                       {"prune", of({"prune", "reconstruct"})},
                       {"burn", of({"burn"})},
                       {"curves", of({"curves"})},
                       {"skeleton", of({"skeleton"})},
                       {"topology", of({"topology"})},
                       {"page", of({"page"})},
                       {"picture", of({"picture"})},
                       {"write", of({"write"})},
                       {"total", rounded(session.total_seconds())}};
  if (spent.contains("tree")) report["seconds"]["tree"] = of({"repair", "tree"});
  report["peak_bytes"] = Session::peak_bytes();
  report["threads"] = session.options.threads;
  report["version"] = QUENCH_VERSION;
  const std::string text = json_text(report, 2) + "\n";
  if (file == "-")
    session.answer(text);
  else
    io::write_atomically(file, [&](std::ostream& out) { out << text; });
}

void write_report(io::OutputGroup& outputs, const Json& report, Session& session) {
  const std::string& file = session.options.report;
  if (!file.empty() && file != "-") write_report(file, report, session);
  outputs.commit();
  if (file == "-") write_report(file, report, session);
}

std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json spacing_json(const Grid& grid) {
  Json sides = {grid.spacing[0], grid.spacing[1]};
  if (!grid.is_plane()) sides.push_back(grid.spacing[2]);
  return sides;
}

std::string cells_text(const pipeline::CellCounts& cells, bool plane) {
  if (plane)
    return fmt::format("{}, {}", base::counted(cells.vertices, "vertex", "vertices"),
                       base::counted(cells.edges, "edge"));
  return fmt::format("{}, {}, {}", base::counted(cells.vertices, "vertex", "vertices"),
                     base::counted(cells.edges, "edge"), base::counted(cells.faces, "face"));
}

Json shape_section(const pipeline::LoadedShape& shape) {
  const Grid& grid = shape.shape.grid();
  const std::optional<bool> changed = shape.topology_changed();
  const bool plane = grid.is_plane();
  Json section = {{"dims", plane ? Json({grid.dims[0], grid.dims[1]}) : Json(grid.dims)},
                  {"spacing", spacing_json(grid)},
                  {plane ? "pixels" : "voxels", shape.shape.voxel_count()},
                  {"sites", count_boundary_vertices(shape.shape)},
                  {"euler", shape.topology.euler},
                  {"betti", shape.topology.betti},
                  {"voxelization_changed_topology", changed ? Json(*changed) : Json(nullptr)}};
  if (shape.voxelization) section["topology"] = topology_section(*shape.voxelization);
  return section;
}

void add_core_sections(Json& report, const pipeline::LoadedShape& shape, const pipeline::CoreResult& core) {
  report["parameters"] = Json::parse(core.parameters);
  report["shape"] = shape_section(shape);
  report["core"] = cells_section(core.all, core.topology);
  if (core.whole) report["core"]["reconstructed"] = *core.whole;
  report["core"]["in_bricks"] = core.plan.in_bricks;
  report["core"]["predicted_bytes"] = predicted_bytes(core.plan);
  report["pruned"] = {{std::string(core.options.pruning.measure), number(core.threshold)}};
  report["pruned"].update(cells_section(core.kept, core.topology));
  report["pruned"]["reconstructed"] = core.reconstructed;
  if (core.options.pruning.measure == kDetail) report["pruned"]["coverage"] = core.coverage;
  Json& surface = report["surface"];
  surface["kind"] = name_of(shape.surface ? shape.surface->kind() : SurfaceKind::voxels);
  if (!shape.surface) return;
  surface["moved"] = core.fit.moved;
  surface["mean_move"] = core.fit.mean_move;
  surface["largest_move"] = core.fit.largest_move;
  surface["outside"] = core.fit.outside;
}

/// "mesh", "isosurface of the grey values", "smoothed surface".
static std::string_view surface_text(SurfaceKind kind) {
  if (kind == SurfaceKind::grey) return "isosurface of the grey values";
  return kind == SurfaceKind::smooth ? "smoothed surface of the voxels" : "mesh";
}

void say_core(const pipeline::LoadedShape& shape, const pipeline::CoreResult& core, Session& session) {
  session.detail(fmt::format("{} boundary vertices, about {} of memory at the peak", core.plan.sites,
                             base::bytes_text(predicted_bytes(core.plan))));
  const pipeline::Pruning& pruning = core.options.pruning;
  const double threshold = core.threshold, voxel = shape.scale().voxel;
  const bool plane = shape.shape.grid().is_plane();
  if (!pruning.threshold)
    session.say(fmt::format("{} {:.6g} ({:.3g} {}, {:.3g} of the longest side; chosen by auto)", pruning.measure,
                            threshold, threshold / voxel, plane ? "pixels" : "voxels", threshold / shape.longest_side));
  if (pruning.measure == kDetail)
    session.say(plane ? fmt::format("every corner of the outline is within {:.3g} pixels of the disks of {}",
                                    core.coverage / voxel, base::counted(core.kept.edges, "edge"))
                      : fmt::format("every corner of the voxel surface is within {:.3g} voxels of the balls of {}",
                                    core.coverage / voxel, base::counted(core.kept.faces, "face")));
  if (!shape.surface) return;
  session.say(fmt::format("fitted to the {}: vertices moved by {:.2g} voxels on average, {:.2g} at most",
                          surface_text(shape.surface->kind()), core.fit.mean_move / voxel,
                          core.fit.largest_move / voxel));
  if (core.fit.outside > 0)
    session.say(fmt::format(
        "note: {} outside the {}, out of reach of its inside: radius 0 (the solid is thinner than a voxel there{})",
        base::counted(core.fit.outside, "vertex lies", "vertices lie"), surface_text(shape.surface->kind()),
        shape.from_mesh ? "; a higher --resolution may help" : ""));
}

std::string share_text(double reconstructed, bool plane) {
  return fmt::format("its {} fill {:.0f} % of the shape", plane ? "disks" : "balls", 100 * reconstructed);
}

void say_written(Session& session, const std::string& axis, const std::string& report, const pipeline::CoreResult& core,
                 const pipeline::LoadedShape& shape) {
  const bool plane = shape.shape.grid().is_plane();
  std::string stages;
  for (const auto& [stage, seconds] : session.seconds())
    stages += fmt::format("{}{} {:.2f} s", stages.empty() ? "" : ", ", stage, seconds);
  session.detail(fmt::format("{}; {} of memory at the peak", stages, base::bytes_text(Session::peak_bytes())));
  session.say(fmt::format("{}: {}; topology as that of the shape; {}; lengths in {}; {:.1f} s{}", axis,
                          cells_text(core.options.full ? core.all : core.kept, plane),
                          share_text(core.options.full && core.whole ? *core.whole : core.reconstructed, plane),
                          shape.coordinates.units.empty() ? "the input's units" : shape.coordinates.units,
                          session.total_seconds(), report.empty() ? "" : fmt::format("; report in {}", report)));
}

Json parameters_section(const pipeline::BurningOptions& options) {
  const auto named = [](const auto& value) { return value ? std::string(pipeline::name_of(*value)) : "auto"; };
  return {{"omega", pipeline::text_of(options.omega)},
          {"propagation", named(options.propagation)},
          {"radius", named(options.radius)}};
}

void add_burn_section(Json& report, const pipeline::BurnFigures& burned) {
  if (burned.options.plane) {
    report["burn"] = {{"unburned", burned.unburned}, {"max_burn_time", burned.max_burn_time}};
    return;
  }
  report["burn"] = {{"omega", burned.options.omega}, {"nodes", burned.nodes},
                    {"unburned", burned.unburned},   {"max_burn_time", burned.max_burn_time},
                    {"propagation", pipeline::name_of(burned.options.propagation)}, {"radius_rule", pipeline::name_of(burned.options.radius)}};
}

Json thickness_section(const pipeline::RunThickness& thickness, bool plane) {
  const auto section = [](const ThicknessDistribution& of) {
    if (!(of.weight() > 0)) return Json(nullptr);
    Json percentiles;
    for (const int share : {5, 25, 50, 75, 95}) percentiles[std::to_string(share)] = of.percentile(share / 100.0);
    return Json{{"mean", of.mean()},
                {"deviation", of.deviation()},
                {"min", of.least()},
                {"max", of.largest()},
                {"percentiles", percentiles}};
  };
  Json shape = section(thickness.shape);
  if (!shape.is_null()) shape["samples"] = thickness.shape.weight();
  return {
      {plane ? "curves" : "sheets", section(thickness.sheets)}, {"shape", shape}, {"correction", thickness.correction}};
}

void say_burned(const pipeline::BurnFigures& burned, std::size_t vertices, Session& session) {
  const bool plane = burned.options.plane;
  session.detail(plane ? fmt::format("burned; longest burn time {:.6g}", burned.max_burn_time)
                       : fmt::format("{} on {} nodes, {:.4g} apart; longest burn time {:.6g}",
                                     burned.from_file ? "the file is burned" : "burned", burned.nodes,
                                     burned.options.omega, burned.max_burn_time));
  if (burned.unburned > 0)
    session.say(
        fmt::format("note: {} of {} {} on {}, where no fire comes: the burn time there is infinite (array "
                    "'unburned')",
                    burned.unburned, base::counted(vertices, "vertex", "vertices"),
                    burned.unburned == 1 ? "lies" : "lie", plane ? "loops and between them" : "closed pockets"));
}

void say_not_of_plane(const pipeline::SkeletonOptions& skeleton, const pipeline::BurningOptions& burning,
                      Session& session) {
  if (skeleton.theta2)
    session.say("note: --theta2 is for sheets and is ignored: axes of images and polygons have none");
  if (burning.omega || burning.radius || burning.propagation)
    session.say(
        "note: --omega, --radius and --propagation are for solids and are ignored: fire on axes of images and polygons is exact");
}

void add_axis_sections(Json& report, const pipeline::AxisRun& run) {
  const Skeleton& skeleton = run.skeleton.skeleton;
  const Topology& topology = run.skeleton.topology;
  add_burn_section(report, run.burned);
  if (!skeleton.plane) report["curves"] = cells_section(run.curves, topology);
  report["skeleton"] = Json::object();
  if (!skeleton.plane) report["skeleton"]["theta2"] = number(skeleton.theta2);
  report["skeleton"]["theta1"] = number(skeleton.theta1);
  report["skeleton"]["theta1_radii"] = skeleton.theta1_radii;
  report["skeleton"].update(cells_section(pipeline::counts_of(skeleton.complex), topology));
  if (skeleton.plane) {
    constexpr std::size_t kMost = 1000;
    Json points = Json::array();
    for (const MedialPoint& p : run.medial_points) {
      if (points.size() == kMost) break;
      points.push_back({{"point", {p.point[0], p.point[1]}}, {"radius", p.radius}, {"burn_time", p.burn_time}});
    }
    report["skeleton"]["medial_points"] = points;
    return;
  }
  const auto last = std::max_element(skeleton.face_sheet.begin(), skeleton.face_sheet.end());
  report["skeleton"]["sheets"] = last == skeleton.face_sheet.end() ? 0 : *last + 1;
}

void write_graph(const CurveGraph& graph, const GraphFiles& files, const GraphFileOptions& options, const Vec3& voxel,
                 const Coordinates& coordinates, Json& report, Session& session) {
  Json& section = report["skeleton"];
  double length = 0;
  std::size_t ends = 0, junctions = 0;
  for (const auto& b : graph.branches) length += b.length;
  for (const auto& n : graph.nodes) {
    ends += n.kind == CurveGraph::NodeKind::end;
    junctions += n.kind == CurveGraph::NodeKind::junction;
  }
  section["branches"] = graph.branches.size();
  section["ends"] = ends;
  section["junctions"] = junctions;
  section["curve_length"] = length;
  section["patches"] = graph.sheets;
  section["radius_offset"] = 0.5 * voxel.minCoeff();
  if (!files.swc.empty()) {
    const int type = io::swc_type_of(options.swc_type, "--swc-type");
    const io::SwcReport swc = io::write_swc(files.swc, graph, {options.root, type, coordinates});
    Json cuts = Json::array();
    for (const auto& cut : swc.cuts)
      cuts.push_back({{"branch", cut.branch},
                      {"from", {cut.from[0], cut.from[1], cut.from[2]}},
                      {"to", {cut.to[0], cut.to[1], cut.to[2]}}});
    section["swc"] = {{"type", type},
                      {"trees", swc.trees},
                      {"samples", swc.samples},
                      {"sheet_links", swc.sheet_links},
                      {"cuts", cuts}};
    if (!swc.cuts.empty())
      session.say(fmt::format("note: {} {} cut in {}, as SWC holds trees only; the header of the file lists where",
                              base::counted(swc.cuts.size(), "loop"), swc.cuts.size() == 1 ? "is" : "are",
                              files.swc.string()));
  }
  if (!graph.sheet_only.empty())
    session.say(
        fmt::format("note: components that are sheets without curves: {}; the graph files hold nothing of them (a "
                    "larger --theta2, or inf, turns sheets into curves)",
                    graph.sheet_only.size()));
  if (!files.graphml.empty()) io::write_graphml(files.graphml, graph, coordinates);
  if (!files.csv.empty()) io::write_branches(files.csv, graph);
}

void write_page(const pipeline::PageBuilder& builder, const std::filesystem::path& file, Json& report,
                const io::OutputGroup& outputs) {
  builder.write(file);
  Json& section = report["page"];
  section = {{"file", file.string()}, {"triangles", builder.triangles()}, {"notes", builder.page.notes}};
  section["bytes"] = outputs.size_of(file);
  const auto floor = [&](const char* name, const std::optional<double>& value) {
    if (value) section["floor"][name] = *value;
  };
  for (const PageMeasure& measure : builder.page.measures) section["floor"][measure.name] = measure.floor;
  floor("theta2", builder.page.theta2_floor);
  floor("theta1", builder.page.theta1_floor);
}

void write_picture(const Page& page, const PictureOptions& options, const std::filesystem::path& file, Json& report,
                   Session& session) {
  write_png(file, draw_page(page, options, &session.context), &session.context);
  report["picture"] = {{"file", file.string()}, {"width", options.width}, {"height", options.height}};
  session.finished("picture");
}

}  // namespace quench::program
