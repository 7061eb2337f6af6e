// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/geometry.h"
#include "quench/polygons.h"
#include "quench/shape.h"
#include "quench/skeleton.h"

namespace quench {

/// The curve part of a skeleton as a graph: what plant and neuro labs measure on. Sheets are not part of it; a node
/// where curves meet a sheet says which.
struct CurveGraph {
  enum class NodeKind : std::uint8_t { end, junction, sheet, loop, isolated, border };
  struct Node {
    Vec3 point;
    double radius = 0;
    NodeKind kind = NodeKind::end;  ///< `sheet`: where curves meet a sheet; `loop`: an arbitrary point of a closed
                                    ///< curve; `border`: where outside_of() has cut a branch
    std::uint32_t component = 0;    ///< of the whole skeleton, sheets included
    std::uint32_t degree = 0;       ///< branch ends at the node; a closed branch has two
    std::uint32_t sheet = kNone;    ///< the patch of sheets the node lies on, or kNone; 0 .. sheets-1
    std::uint32_t vertex = 0;       ///< of the skeleton
  };
  /// A polyline from node to node. All lengths in world units.
  struct Branch {
    std::uint32_t from = 0, to = 0;  ///< equal for a closed branch
    std::vector<Vec3> points;        ///< the first and last are those of the nodes
    std::vector<double> radius;
    double length = 0;
    double mean_radius = 0, min_radius = 0, max_radius = 0;  ///< mean along the length
    double thickness = 0;                                    ///< largest ET_MC on it; infinite on loops
    double tortuosity = 1;  ///< length over distance of the ends; infinite for a closed branch
    std::uint32_t component = 0;
    std::vector<std::uint32_t> vertices;  ///< of the skeleton, along the branch, ends included; smoothing keeps them
    std::vector<double> erosion_thickness, mgf;  ///< per point, after add_measures(); else empty
  };
  std::vector<Node> nodes;
  std::vector<Branch> branches;
  std::uint32_t components = 0;           ///< of the whole skeleton, numbered by their first vertices
  std::uint32_t sheets = 0;               ///< patches: faces that share a vertex are of one patch
  std::vector<std::uint32_t> sheet_only;  ///< components without any curve and with at least one face, ascending
};

/// `end`, `junction`, `sheet`, `loop`, `isolated` or `border`.
const char* name_of(CurveGraph::NodeKind kind);

/// Curves are the edges without face. Nodes are vertices with curves whose number is not two, or on a sheet; branches
/// run between them. A closed curve without node gets one: its thickest vertex (ties: least x, y, z). A vertex without
/// edges is an isolated node. Nodes are in the order of vertices (those of closed curves last), branches in that of
/// their `from` nodes, and from <= to. Deterministic, O(n log n) in the worst case, O(n) but for junctions.
CurveGraph curve_graph(const Skeleton& skeleton);

/// How smoothed() moves and resamples branches. All lengths in world units.
struct SmoothOptions {
  int iterations = 0;  ///< passes in which every point moves half way to the chord of its neighbours; 0: no smoothing
  double spacing = 0;  ///< distance between points along a branch after resampling; 0: no resampling
  /// Radii are distances to the corners of voxels, not to the faces between them: half the largest diagonal of a voxel
  /// face, boundary_gap(). 0 where radii are distances to the boundary itself.
  double gap = 0;
  /// Whether a segment lies inside the shape, where that is known: decides in place of the bound below, which is coarse
  /// for curves about a voxel thick. New radii are then those of the old polyline, interpolated.
  std::function<bool(const Vec3&, const Vec3&)> inside = nullptr;
  /// New radii are those of the old polyline, interpolated, also where the bound decides.
  bool interpolated_radii = false;
};

/// SmoothOptions::gap of a voxel shape: half the diagonal of the largest face of a voxel.
double boundary_gap(const Vec3& spacing);

/// The graph with smoother and evenly sampled branches. Nodes stay as they are. Promises, for radii that are exact (or
/// too small) and an input that keeps them itself:
/// - every new segment lies in the union of the balls of its branch, and in the shape: the square of the distance to
///   the boundary minus |x|^2 is concave, so a point averaged from others, x = sum w_j x_j, is at least
///   sqrt(sum w_j (r_j^2 - |x_j - x|^2)) away from the boundary. Wherever that is not above `gap` all along a new
///   segment, the old polyline is kept;
/// - that bound is the new radius, never more than the true one, unless radii are interpolated;
/// - no point of the input moves further than half its radius by smoothing;
/// - branches touch neither themselves nor each other but at common nodes: one that would is smoothed but not
///   resampled, or left as it was. (Only the final polylines are compared, and not with sheets.)
/// Closed branches get three segments at least, and no branch more than 64 points for each it had, plus 1024. Lengths,
/// radii and tortuosity are computed anew, ET_MC is kept. Deterministic. Throws Error(usage) for negative or infinite
/// options.
CurveGraph smoothed(const CurveGraph& graph, const SmoothOptions& options);

/// The skeleton with the courses of these branches, `graph` being its curve_graph(), or that smoothed(). Sheets, nodes
/// and isolated vertices stay, in their order; behind them come the inner points of the branches, branch by branch.
/// Radii on branches are those of the graph; burn times, thickness and levels those of the vertices and edges that were
/// there or, where the number of points is another, at the same fraction of the length. The topology stays: a branch
/// that would be a second edge between two vertices gets a point in its middle. Fills `edge_branch`. O(n log n). Throws
/// Error(usage) when the graph is not of the skeleton.
Skeleton with_branches(const Skeleton& skeleton, const CurveGraph& graph);

/// The main axis of each component of a skeleton of curves, and nothing else: of the shortest ways along curves between
/// two free ends the longest (where there are fewer than two ends, between nodes, or a closed curve that is longer),
/// with isolated vertices. Exact in trees and in components of up to 2000 ends; in larger ones with loops the longest
/// of 16 sweeps, each from where the one before ended. Near linear in trees. Throws Error(usage), field theta2, for a
/// skeleton with sheets.
Skeleton main_axes(const Skeleton& skeleton);

/// The graph whose free ends are drawn out in a straight line to the boundary of the shape: from the node on, in the
/// direction from the point one radius (at least two voxels) back along the branch, as far as the voxels are in the
/// shape. The nodes move there, with radius 0; where they were is a point of the branch. An end outside the shape
/// stays.
CurveGraph extended(const CurveGraph& graph, const VoxelShape& shape);

/// The branches as far as they are outside of a part of the shape, such as wide_part(), cut where they pass from voxel
/// to voxel; nodes inside of it go. Its branches have no `vertices`, nor have nodes of kind `border`.
CurveGraph outside_of(const CurveGraph& graph, const VoxelShape& part);

/// Gives the points of branches the erosion thickness on the curves (infinite where no fire comes) and, in the plane,
/// the MGF of the skeleton that was drawn with them by with_branches(). Throws Error(usage) when a point is not in it.
void add_measures(CurveGraph& graph, const Skeleton& drawn);

/// Puts a skeleton of curves, with its branches, behind another, e.g. to draw both: cells, components and branches of
/// `more` are numbered behind those of `to`. Throws Error(usage) for sheets.
void append(Skeleton& to, const Skeleton& more);
/// The same of graphs; `first_vertex`: the vertices of the skeleton that those of `more` were put behind.
void append(CurveGraph& to, const CurveGraph& more, std::uint32_t first_vertex);

namespace io {

constexpr int kSwcDendrite = 3;

/// The structure identifier of SWC for a number from 0 to 255 or a name: undefined, soma, axon, dendrite (or
/// basal-dendrite), apical-dendrite, custom, neurite, glia. Throws Error(usage), naming `what`.
int swc_type_of(std::string_view text, std::string_view what);

struct SwcOptions {
  /// The node nearest to this point is the root of its component. All others (and all without it): the thickest node.
  std::optional<Vec3> root;
  /// Structure identifier of every sample: a label, not a result. The default is one that every program accepts
  /// (MorphIO and NeuroM refuse 0, undefined, and some others all but 1 to 4).
  int type = kSwcDendrite;
  Coordinates coordinates;  ///< for the header
};

/// What an SWC file does not say in its rows.
struct SwcReport {
  /// A segment of a branch that is left out because it closes a loop.
  struct Cut {
    std::uint32_t branch = 0;
    Vec3 from, to;  ///< the ends of the segment; both are samples of the file
  };
  std::vector<Cut> cuts;             ///< as many as the graph has independent loops, by branch
  std::uint32_t trees = 0;           ///< components with a node
  std::uint64_t samples = 0;         ///< rows
  std::uint64_t sheet_links = 0;     ///< rows joined to their parent by a straight line across a sheet, not by a curve
  std::vector<std::uint32_t> roots;  ///< per tree: the node
};

/// Writes the graph as an SWC file, one tree per component: `id type x y z radius parent`, ids 1 .. n, parents before
/// children, the parent of a root is -1. Every loop is cut at its thinnest place: one segment is left out, all points
/// stay. Nodes on one patch of sheets are joined to the thickest of them by straight links, so that what is connected
/// stays connected. Cuts, links and components without a tree are listed in the header. See docs/user/files.md.
SwcReport write_swc(const std::filesystem::path& file, const CurveGraph& graph, const SwcOptions& options = {});

/// GraphML, undirected: nodes n0, n1 ... with x, y, z, radius, kind, component, degree, sheet (-1: none); edges b0, b1
/// ... with component, length, mean_radius, min_radius, max_radius, thickness, tortuosity. `Infinity` where infinite.
void write_graphml(const std::filesystem::path& file, const CurveGraph& graph, const Coordinates& coordinates = {});

/// CSV, one row per branch: branch, from, to, component, from_x .. from_z, to_x .. to_z, from_kind, to_kind, length,
/// mean_radius, min_radius, max_radius, thickness, tortuosity. `inf` where infinite.
void write_branches(const std::filesystem::path& file, const CurveGraph& graph);

/// The curves of one shape of the plane with what is known of them: a feature of a LineWriter.
struct PlaneLines {
  /// A value per point of every branch, e.g. `mgf`: values[b][k] of graph.branches[b].points[k].
  struct Array {
    std::string name;
    std::vector<std::vector<double>> values;
  };
  CurveGraph graph;  ///< in the plane z = 0
  std::vector<Array> arrays;
  Polygons outline;                       ///< SVG: drawn grey beneath the lines, by the rule of odd winding numbers
  Polygons wide;                          ///< wide_part(), as boundary_rings(): what no lines are drawn in
  std::optional<std::uint64_t> number{};  ///< of the polygon feature, where the shape is one of many
  std::string id;                         ///< of the polygon feature, JSON text; empty: none
  std::string properties;                 ///< of the polygon feature, the JSON text of an object; empty: none
};

struct LineOptions {
  bool y_down = false;                                              ///< y grows downwards (images, SVG)
  enum class Colour { radius, thickness } colour = Colour::radius;  ///< SVG: what branches are coloured by
};

/// Writes lines of the plane feature by feature, in the format of the extension: .geojson and .json (GeoJSON),
/// .geojsonl, .geojsons and .ndjson (an object per line), .wkt, .svg. Coordinates are those of the graph, y as it is.
///
/// GeoJSON: a LineString per branch with the properties of the polygon feature, `feature` (number), `feature_id`,
/// `branch`, `from`, `to`, `from_kind`, `to_kind`, `length`, `mean_radius`, `min_radius`, `max_radius`, `thickness`,
/// `tortuosity`, and per point the arrays `radius` and PlaneLines::arrays; null where infinite. A property of the
/// polygon of one of these names gets `polygon_` before it. An isolated node is a Point. WKT: a LINESTRING or POINT per
/// line. Both need memory for one feature. SVG: what is drawn stays in memory until finish(); colours and widths refer
/// to the feature.
///
/// The file appears with finish(), as by write_atomically(); without it nothing is left. Throws Error(usage) for
/// another extension, Error(failed) when writing fails, Error(input) for properties that are not an object of JSON.
class LineWriter {
 public:
  explicit LineWriter(const std::filesystem::path& file, const LineOptions& options = {});
  LineWriter(LineWriter&&) noexcept;
  LineWriter& operator=(LineWriter&&) noexcept;
  ~LineWriter();

  void append(const PlaneLines& lines);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A file of one feature.
void write_lines(const std::filesystem::path& file, const PlaneLines& lines, const LineOptions& options = {});

}  // namespace io

}  // namespace quench
