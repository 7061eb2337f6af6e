// SPDX-License-Identifier: Apache-2.0
#include "quench/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/parallel.h"
#include "base/text.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

constexpr std::array<std::pair<TreeKind, std::string_view>, 4> kKinds{{
    {TreeKind::root, "root"},
    {TreeKind::neuron, "neuron"},
    {TreeKind::vessel, "vessel"},
    {TreeKind::airway, "airway"},
}};

/// What the values of a shape are compared with. A shape says how it follows from them.
std::optional<GreyValues> grey_values_of(const LoadedShape* shape) {
  if (!shape || !shape->values || shape->parameters.empty()) return {};
  const auto parameters = nlohmann::json::parse(shape->parameters);
  if (!parameters.contains("threshold")) return {};
  return GreyValues{&*shape->values, parameters["threshold"].get<double>(), parameters.value("invert", false)};
}

/// A centroid of curves along an axis of space.
struct Centroid {
  double sum = 0, weight = 0;
  void add(double at, double more) {
    sum += at * more;
    weight += more;
  }
  double value() const { return weight > 0 ? sum / weight : 0; }
};

/// Calls `take(middle, length, radius)` for each piece of a branch.
template <class Branch, class Take>
void for_pieces(const Branch& branch, const Take& take) {
  for (std::size_t i = 1; i < branch.points.size(); ++i)
    take(Vec3(0.5 * (branch.points[i] + branch.points[i - 1])), (branch.points[i] - branch.points[i - 1]).norm(),
         0.5 * (branch.radius[i] + branch.radius[i - 1]));
}

/// Scans mostly have their slices in the order of height, from either end. Root systems are thick and many at the top,
/// and few go deep: most of the volume lies above what is longest, and above the middle between the highest and the
/// lowest point. Where the two do not agree, as of a crown of fine roots on one that goes deep, the farther one counts.
Vec3 likely_down(const CurveGraph& graph) {
  Centroid volume, length;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const CurveGraph::Branch& branch : graph.branches) {
    for_pieces(branch, [&](const Vec3& middle, double piece, double radius) {
      volume.add(middle[2], piece * radius * radius);
      length.add(middle[2], piece);
    });
    for (const Vec3& p : branch.points) {
      low = std::min(low, p[2]);
      high = std::max(high, p[2]);
    }
  }
  return {0, 0, length.value() + (low + high) / 2 > 2 * volume.value() ? 1.0 : -1.0};
}

Vec3 likely_down(const Tree& tree) {
  double low = tree.plants.front().root[2], high = low;
  for (const Tree::Branch& branch : tree.branches)
    for (const Vec3& p : branch.points) {
      low = std::min(low, p[2]);
      high = std::max(high, p[2]);
    }
  const int along = high > low ? 2 : 1;
  Centroid below;
  for (const Tree::Branch& branch : tree.branches)
    for_pieces(branch, [&](const Vec3& middle, double piece, double) {
      below.add(middle[along] - tree.plants[branch.plant].root[along], piece);
    });
  return (below.value() > 0 ? 1 : -1) * Vec3::Unit(along);
}

std::string components_text(const Topology& topology) {
  return fmt::format("{}, {} and {}", base::counted(topology.betti[0], "component"),
                     base::counted(topology.betti[1], "tunnel"),
                     base::counted(topology.betti[2], "cavity", "cavities"));
}

void check_curves(const CurveGraph& graph) {
  if (graph.sheets > 0)
    throw Error(ErrorCode::usage,
                "the skeleton has sheets, and a tree is made of curves; take theta2 'inf', and fill cavities",
                "theta2");
  if (graph.branches.empty())
    throw Error(ErrorCode::input,
                "there are no branches to make a tree of: the shape is empty, or all of it is smaller than theta1",
                "theta1");
}

/// A root node is asked for near the tree: nobody means a point that is farther away than the tree is large.
template <class Branches>
void check_roots(const std::vector<Vec3>& roots, const Branches& branches) {
  for (const Vec3& root : roots) {
    Vec3 low = branches.front().points.front(), high = low;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& branch : branches)
      for (const Vec3& p : branch.points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
        nearest = std::min(nearest, (p - root).norm());
      }
    if (nearest > (high - low).norm())
      throw Error(ErrorCode::usage,
                  fmt::format("root '{:.6g},{:.6g},{:.6g}' is {:.4g} away from the tree, which reaches from "
                              "{:.4g},{:.4g},{:.4g} to {:.4g},{:.4g},{:.4g}",
                              root[0], root[1], root[2], nearest, low[0], low[1], low[2], high[0], high[1], high[2]),
                  "root");
  }
}

// The edited shape has a byte for each voxel of the box around the shape, and their numbers 32 bits. A note where it has
// to be left out.
bool edited_shape_fits(const VoxelShape& shape, Context* context) {
  const VoxelShape::Box box = shape.foreground_box();
  double bytes = 1;
  for (std::size_t a = 0; a < 3; ++a) bytes *= static_cast<double>(box.end[a] - box.begin[a] + 2);
  if (bytes <= std::numeric_limits<std::uint32_t>::max() && fits(bytes, context)) return true;
  note(context, fmt::format("the volume after repair is left out: the box around the shape has {:.2g} voxels", bytes));
  return false;
}

}  // namespace

std::string_view name_of(TreeKind kind) {
  return std::ranges::find(kKinds, kind, [](auto k) { return k.first; })->second;
}

std::optional<TreeKind> tree_kind_of(std::string_view name) {
  const auto found = std::ranges::find(kKinds, name, [](auto k) { return k.second; });
  if (found == kKinds.end()) return {};
  return found->first;
}

TreeOptions defaults_of(TreeKind kind) {
  TreeOptions options;
  options.kind = kind;
  switch (kind) {
    case TreeKind::root:
      options.hierarchy.rule = AxisRule::continuation;
      options.hierarchy.stem = true;
      options.hierarchy.root = RootRule::top;
      options.find_down = true;
      break;
    case TreeKind::neuron:
      options.hierarchy.rule = AxisRule::length;
      options.hierarchy.soma = SomaRule::automatic;
      break;
    case TreeKind::vessel:
    case TreeKind::airway:
      options.hierarchy.rule = AxisRule::radius;
      options.hierarchy.root = RootRule::end;
      break;
  }
  return options;
}

SkeletonOptions skeleton_for_trees(SkeletonOptions asked) {
  if (!asked.theta2) asked.theta2 = world_length(std::numeric_limits<double>::infinity());
  if (!asked.theta1) asked.theta1 = Length{1, Length::Unit::radii};
  return asked;
}

GraphOptions graph_for_trees(GraphOptions asked, const Scale& scale) {
  if (asked.resample.value == 0 && scale.voxel > 0) asked.resample = Length{1, Length::Unit::voxels};
  return asked;
}

TreeCurves curves_in(Record&& result, const std::string& file, RunOptions options, const LoadedShape* shape,
                     Context* context) {
  const bool drawn = field_text(result, "stage") == "skeleton";
  LoadedAxis loaded = axis_of(std::move(result), file, context);
  if (loaded.axis.grid.is_plane())
    throw Error(ErrorCode::usage, fmt::format("'{}' is of the plane, and trees are made in space; its file "
                                              "skeleton.swc, or another one of its curves, is measured as it is",
                                              file));
  if (drawn && loaded.axis.complex.face_count() > 0)
    throw Error(ErrorCode::usage, fmt::format("'{}' is a skeleton with sheets, and a tree is made of curves; give the "
                                              "medial axis it is of (core.vtp), or make it with theta2 'inf'",
                                              file));
  TreeCurves curves{.graph = {}, .scale = loaded.scale, .voxel = Vec3::Zero(), .coordinates = loaded.coordinates};
  if (drawn) {
    if (!loaded.scale.fitted) curves.voxel = loaded.spacing;
    Skeleton skeleton;
    skeleton.edge_thickness.assign(loaded.axis.complex.edges.size(), 0);
    skeleton.complex = std::move(loaded.axis.complex);
    skeleton.points = std::move(loaded.axis.points);
    skeleton.radius = std::move(loaded.axis.radius);
    curves.graph = measured_graph(skeleton, {.smooth = 0, .voxel = curves.voxel}, curves.scale);
    return curves;
  }
  if (loaded.voxel_core) curves.voxel = options.graph.voxel = loaded.spacing;
  if (shape && loaded.voxel_core) options.graph.shape = &shape->shape;
  options.skeleton = skeleton_for_trees(options.skeleton);
  options.graph = graph_for_trees(options.graph, loaded.scale);
  take_recorded(options.burning, loaded.data);
  curves.graph = run_axis(loaded.axis, std::move(loaded.data), loaded.voxel_core, topology(loaded.axis.complex),
                          loaded.scale, options, context)
                     .graph;
  return curves;
}

std::size_t TreeRun::edits_of(TreeEdit::Kind kind) const {
  return static_cast<std::size_t>(std::ranges::count(edits, kind, &TreeEdit::kind));
}

double TreeRun::length_of(TreeEdit::Kind kind) const {
  double sum = 0;
  for (const TreeEdit& edit : edits)
    if (edit.kind == kind) sum += edit.length;
  return sum;
}

TreeRun run_tree(const TreeCurves& curves, const TreeOptions& options, const LoadedShape* shape, Context* context) {
  check_curves(curves.graph);
  check_roots(options.repair.roots, curves.graph.branches);
  TreeRun result;
  for (const CurveGraph::Branch& branch : curves.graph.branches) result.length_before += branch.length;
  const std::optional<GreyValues> grey = grey_values_of(shape);
  RepairOptions repairs = options.repair;
  if (!(repairs.voxel > 0)) repairs.voxel = curves.scale.voxel;
  Repaired repair = repaired(curves.graph, repairs, grey ? &*grey : nullptr, context);
  checkpoint(context, "repair", 1);
  if (const RepairRule rule = options.repair.rule;
      repair.loops_before > 0 && (rule == RepairRule::off || rule == RepairRule::gaps))
    throw Error(ErrorCode::usage,
                fmt::format("the curves have {}, and a tree has none; the repair 'loops' or 'all' cuts them",
                            base::counted(repair.loops_before, "loop")),
                "repair");
  if (shape && options.edited_shape && edited_shape_fits(shape->shape, context)) {
    result.edited = edited_shape(shape->shape, curves.graph, repair, context);
    result.edited_topology = topology(*result.edited);
    checkpoint(context, "topology", 1);
  }
  HierarchyOptions hierarchy = options.hierarchy;
  hierarchy.voxel = curves.scale.voxel;
  if (options.find_down) hierarchy.down = likely_down(repair.graph);
  if (hierarchy.roots.empty()) hierarchy.roots = options.repair.roots;
  result.tree = tree_of(repair, hierarchy, context);
  result.tree.coordinates = curves.coordinates;
  result.edits = std::move(repair.edits);
  result.components_before = repair.components_before;
  result.loops_before = repair.loops_before;
  result.traits = traits_of(result.tree, options.traits);
  checkpoint(context, "tree", 1);
  const auto trees = static_cast<std::int64_t>(result.tree.plants.size());
  if (const auto& t = result.edited_topology; t && t->betti != std::array<std::int64_t, 3>{trees, 0, 0})
    throw Error(ErrorCode::invariant,
                fmt::format("the edited shape has {}, and there {}; please report this", components_text(*t),
                            trees == 1 ? "is 1 tree" : fmt::format("are {} trees", trees)));
  return result;
}

TreeRun run_tree(Tree&& tree, bool new_axes, const TreeOptions& options) {
  TreeRun result;
  if (tree.branches.empty()) throw Error(ErrorCode::input, "the tree has no branches");
  check_roots(options.hierarchy.roots, tree.branches);
  HierarchyOptions hierarchy = options.hierarchy;
  if (options.find_down) hierarchy.down = likely_down(tree);
  tree.down = hierarchy.down;
  result.tree = new_axes ? with_hierarchy(std::move(tree), hierarchy) : std::move(tree);
  result.components_before = static_cast<std::uint32_t>(result.tree.plants.size());
  result.traits = traits_of(result.tree, options.traits);
  return result;
}

Table table_of(const std::vector<TreeEdit>& edits, const Coordinates& coordinates) {
  Table table;
  table.rows = edits.size();
  const auto add = [&](const char* name, const std::string& unit, const char* meaning, const auto& get) {
    std::vector<std::decay_t<decltype(get(edits[0]))>> values;
    for (const TreeEdit& edit : edits) values.push_back(get(edit));
    table.columns.push_back({name, unit, meaning, std::move(values)});
  };
  const std::string& unit = coordinates.units;
  std::int64_t number = 0;
  add("edit", "", "number, from 0", [&](const TreeEdit&) { return number++; });
  add("kind", "", "cut_loop, cut_touching, cut_crossing, bridge or left_out",
      [](const TreeEdit& e) { return std::string(name_of(e.kind)); });
  constexpr std::array kFrom{"from_x", "from_y", "from_z"}, kTo{"to_x", "to_y", "to_z"};
  for (int a = 0; a < 3; ++a)
    add(kFrom[static_cast<std::size_t>(a)], unit, "where it begins", [a](const TreeEdit& e) { return e.from[a]; });
  for (int a = 0; a < 3; ++a)
    add(kTo[static_cast<std::size_t>(a)], unit, "where it ends", [a](const TreeEdit& e) { return e.to[a]; });
  add("radius", unit, "of the branch there", [](const TreeEdit& e) { return e.radius; });
  add("length", unit, "of the gap, of the branch that is cut, of the part that is left out",
      [](const TreeEdit& e) { return e.length; });
  add("cost", "", "by which the choice was made", [](const TreeEdit& e) { return e.cost; });
  add("grey", "", "mean of the values along a bridge, relative to the threshold",
      [](const TreeEdit& e) { return e.grey; });
  return table;
}

}  // namespace quench::pipeline
