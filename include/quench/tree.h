// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/graph.h"
#include "quench/shape.h"
#include "quench/table.h"

/// @file
/// Trees: curve graphs of roots, neurons, vessels and airways repaired to one tree per plant (Yan 2018, sec. 4.1.3),
/// their hierarchy of axes, and what is measured of them.
namespace quench {

// ------------------------------------------------------------------------------------------------------------- repair

enum class RepairRule : std::uint8_t { off, loops, gaps, all };

struct RepairOptions {
  RepairRule rule = RepairRule::all;
  /// One root node per plant: the graph becomes one tree around the node nearest to each. Empty: `plants` trees, those
  /// that are worth most.
  std::vector<Vec3> roots;
  std::uint32_t plants = 1;  ///< 0: every component stays a tree of its own
  double reach = 0;          ///< longest bridge, world units; 0: automatic
  double voxel = 0;          ///< smallest step of the voxels the graph is from; 0: radii tell what is noise
};

/// A place where the graph was changed.
struct TreeEdit {
  enum class Kind : std::uint8_t {
    cut_loop,      ///< a branch that closed a loop
    cut_touching,  ///< a place where two tubes touch
    cut_crossing,  ///< two tubes that pass each other, taken apart
    bridge,        ///< a gap that is closed
    left_out,      ///< a component that does not pay for its cheapest bridge
  };
  Kind kind = Kind::cut_loop;
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< the ends of the cut or of the bridge
  double radius = 0;                            ///< of the branch there
  double length = 0;                            ///< of the gap, of the branch that is cut, of the component left out
  double cost = 0;                              ///< by which the choice was made
  double grey = std::numeric_limits<double>::quiet_NaN();  ///< of a bridge: mean of the values along it relative to the
                                                           ///< threshold, where there are any
};
/// "cut_loop", "cut_touching", "cut_crossing", "bridge", "left_out".
const char* name_of(TreeEdit::Kind kind);

/// The grey values that a shape was cut out of.
struct GreyValues {
  const Volume* volume = nullptr;
  double threshold = 0;
  bool invert = false;
};

struct Repaired {
  CurveGraph graph;  ///< without loops; bridges are (parts of) branches without `vertices`
  /// Per branch and segment 1 where it is a bridge; empty for a branch without one.
  std::vector<std::vector<std::uint8_t>> bridged;
  std::vector<TreeEdit> edits;
  std::uint32_t components_before = 0, loops_before = 0;
};

/// The graph as the minimum spanning forest over its branches and possible bridges (docs/algorithms/tree_repair.md).
Repaired repaired(const CurveGraph& graph, const RepairOptions& options, const GreyValues* grey = nullptr,
                  Context* context = nullptr);

/// The shape with bridges filled as tubes and cuts taken out of it, whose components and tunnels are those of the
/// repaired graph. A byte for each voxel of the box around the shape; Error(failed) for more than 2^32.
VoxelShape edited_shape(const VoxelShape& shape, const CurveGraph& graph, const Repaired& repaired,
                        Context* context = nullptr);

// ---------------------------------------------------------------------------------------------------------- hierarchy

/// Which child continues its parent at a fork.
enum class AxisRule : std::uint8_t {
  depth,         ///< so that the largest level of what follows is smallest; ties by length, then by angle
  length,        ///< the one with the longest way to a tip
  radius,        ///< the thickest
  strahler,      ///< the one of the largest Strahler number; ties by length
  continuation,  ///< the one that keeps direction and radius best, both measured outside of the ball of the fork
};

/// A rooted forest: per plant one tree, directed from its root node.
struct Tree {
  /// A piece between two forks or ends.
  struct Branch {
    std::uint32_t parent = kNone;  ///< the branch at whose far end it begins; kNone: it begins at a root node
    std::uint32_t axis = 0, plant = 0;
    std::vector<Vec3> points;  ///< from base to far end; the first is the last of `parent`, or the root node
    std::vector<double> radius;
    std::vector<std::uint8_t> bridged;  ///< per segment: 1 where the shape has a gap; empty: nowhere
    std::uint32_t strahler = 1;         ///< Horton-Strahler number
    std::uint32_t order = 0;            ///< centrifugal: forks between the root node and its base
    int type = 0;                       ///< structure identifier of SWC, where one is known
    std::uint32_t source = kNone;       ///< the branch of the graph it is from
  };
  /// A root, neurite or vessel from where it leaves its parent to its tip.
  struct Axis {
    std::uint32_t parent = kNone;  ///< axis; kNone: of level 0
    std::uint32_t level = 0;       ///< that of its parent and one more
    std::uint32_t plant = 0;
    std::vector<std::uint32_t> branches;  ///< from base to tip
    std::vector<std::uint32_t> children;  ///< axes, by position along it
    std::vector<Vec3> points;             ///< the whole course; begins on the course of the parent
    std::vector<double> radius;
    double position = 0;  ///< length along the parent from its base to where this leaves it
    bool stem = false;    ///< ends with the thick part, as only thin children go on
    std::string label;    ///< of a file it was read from
    std::string foreign;  ///< as Tree::foreign
  };
  struct Plant {
    Vec3 root = Vec3::Zero();
    std::uint32_t main_axis = 0;
    std::optional<double> soma;  ///< radius of the thick ball at the root node, where there is one
    std::string label;
    std::string foreign;  ///< as Tree::foreign
  };
  std::vector<Branch> branches;  ///< parents before children
  std::vector<Axis> axes;        ///< parents before children
  std::vector<Plant> plants;
  Vec3 down = -Vec3::UnitZ();  ///< unit vector
  AxisRule rule = AxisRule::length;
  Coordinates coordinates;
  /// What an RSML file says beyond this structure, as XML text: write_rsml() writes it again. Courses must stay as they
  /// are, for functions along them.
  std::string foreign;
};

enum class SomaRule : std::uint8_t { none, automatic, thickest };

/// Which node is the root node of a tree where no point is given.
enum class RootRule : std::uint8_t {
  thickest,  ///< the thickest node
  end,       ///< the thickest free end: what vessels and airways come out of
  top,       ///< the thickest free end in the upper fifth, against `down`: where a root system was cut off its shoot
};

struct HierarchyOptions {
  AxisRule rule = AxisRule::length;
  RootRule root = RootRule::thickest;
  std::vector<Vec3> roots;  ///< the node nearest to one of these is the root node of its tree; else `root` decides
  Vec3 down = -Vec3::UnitZ();
  bool stem = false;  ///< of roots: the main axis ends where only thin children go on (a crown)
  SomaRule soma = SomaRule::none;
  /// Smallest step of the voxels the curves are from: branches that end within the tube they leave are dropped. 0: none
  /// is.
  double voxel = 0;
};

/// The hierarchy of a graph without loops. Throws Error(usage) for a graph with loops or sheets.
Tree tree_of(const Repaired& repaired, const HierarchyOptions& options, Context* context = nullptr);
/// A tree read from a file, its axes found anew by the rule. Its root nodes stay but for those that `roots` names.
Tree with_hierarchy(Tree tree, const HierarchyOptions& options);

/// A unit vector in words: "-z", or three numbers "0.6,0,-0.8".
std::string direction_text(const Vec3& direction);
std::string_view name_of(AxisRule rule);
std::optional<AxisRule> axis_rule_of(std::string_view name);
std::string_view name_of(RepairRule rule);
std::optional<RepairRule> repair_rule_of(std::string_view name);
std::string_view name_of(RootRule rule);
std::optional<RootRule> root_rule_of(std::string_view name);
std::string_view name_of(SomaRule rule);
std::optional<SomaRule> soma_rule_of(std::string_view name);

// ------------------------------------------------------------------------------------------------------------- traits

struct TraitOptions {
  double sholl_step = 0;  ///< distance of the spheres of Sholl; 0: a fiftieth of the largest distance
  int depth_bins = 20;    ///< of the profile of length by depth
};

/// What is measured of a tree: docs/user/trees.md has the formulas.
struct Traits {
  Table axes, branches;
  Table sample;         ///< one row
  Table sholl, depths;  ///< profiles: a row per sphere, per layer
};
Traits traits_of(const Tree& tree, const TraitOptions& options = {});
/// The columns of TopoRoot (Zeng et al. 2021) in its order, a row per axis.
Table toporoot_table(const Tree& tree, const Traits& traits);
/// Words for tables: `kinds`... of a unit such as "mm": that of areas and volumes.
std::string unit_to_the(const std::string& unit, int power);

namespace io {

/// CSV: a header with names and units, `length [mm]`, and a row per row; what is not defined (NaN) is empty.
void write_table(const std::filesystem::path& file, const Table& table);

/// SWC: soma 1 at its root where the tree has one, else `type` where branches have none of their own. Every sample has
/// a type above 0, parents come first, a branch begins at the last sample of its parent. Throws Error(usage) for a type
/// that is not from 1 to 255.
void write_swc(const std::filesystem::path& file, const Tree& tree, int type = kSwcDendrite);
/// RSML (Lobet et al. 2015): nested roots with polylines, diameters, parent nodes (counted from 1), and the traits of
/// axes as properties: a row of `axes` per axis. `last-modified` is the time of SOURCE_DATE_EPOCH where that is set,
/// else left out, so that the bytes follow from the tree. Throws Error(usage) for a tree without axes.
void write_rsml(const std::filesystem::path& file, const Tree& tree, const Table* axes = nullptr);
/// MTG (Godin and Caraglio 1998), as OpenAlea reads it: plants P, axes A, and a vertex S per point, which is the piece
/// that ends there. Throws Error(usage) for a tree without axes.
void write_mtg(const std::filesystem::path& file, const Tree& tree);
/// VTP: a polyline per branch with its radius (also as MaximumInscribedSphereRadius), branch, axis, level, order,
/// strahler, plant and type. A branch begins at the last point of its parent: that point is there once.
void write_centerlines(const std::filesystem::path& file, const Tree& tree);
/// GraphML: directed, from root nodes to tips; an edge per branch with its course and radii as text.
void write_graphml(const std::filesystem::path& file, const Tree& tree);

/// Whether the extension is that of a tree: .swc .rsml.
bool is_tree_file(const std::filesystem::path& file);
/// A tree of an .swc or .rsml file. `axes_known` becomes whether the file says which axes there are; a tree without
/// them has branches and plants only, and with_hierarchy() finds its axes. Radii that the file does not say are 0. What
/// the file leaves open, such as laterals that do not begin on their parent, is joined by segments that are `bridged`
/// (docs/user/files.md). Throws Error(input), naming the file and, of SWC, the line.
Tree read_tree(const std::filesystem::path& file, bool* axes_known = nullptr, Context* context = nullptr);

}  // namespace io

}  // namespace quench
