// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/context.h"
#include "quench/graph.h"
#include "quench/io.h"
#include "quench/lengths.h"
#include "quench/page.h"
#include "quench/parts.h"
#include "quench/polygons.h"
#include "quench/preparation.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/surface.h"
#include "quench/thickness.h"
#include "quench/tree.h"
#include "quench/voxelize.h"

namespace quench {
struct BoundaryPoints;  // quench/simplify.h
}

/// @file
/// The stages in a row: input -> shape -> core -> pruning -> burning -> curves -> skeleton -> graph -> page, with the
/// checks between them, lengths in the user's units, and a plan of memory before each stage. run() does all of it; its
/// parts are functions of their own. The program and the Python module are front ends of this header.
///
/// Every function that takes a context works on its threads, reports progress, and tells notes.
namespace quench::pipeline {

// ------------------------------------------------------------------------------------------------------------- memory

/// Whether so many bytes are within the limit of the context or, without one, the memory that is free.
bool fits(double bytes, const Context* context);
/// Whether all samples of a volume at once are within the limit of the context or, without one, the memory that is free.
bool samples_fit(const SliceStream& slices, const Context* context);

/// Throws Error(failed), field `memory_limit`, with figures when `bytes` exceed the limit of the context or, without
/// one, the memory that is free. `remedies`: what the user can do about it, behind "use ".
void require_memory(std::int64_t bytes, const std::string& what, const std::vector<std::string>& remedies,
                    const Context* context);

/// How the core of a shape fits into memory, in bytes.
struct CorePlan {
  std::int64_t sites = 0;    ///< boundary vertices
  std::int64_t held = 0;     ///< by the process now; 0, not measured, of small shapes without a limit
  std::int64_t at_once = 0;  ///< needed beside `held`
  std::int64_t bricks = 0;   ///< the same in bricks
  bool in_bricks = false;    ///< at once is too much, bricks need less
  std::int64_t bytes() const { return in_bricks ? bricks : at_once; }
};
CorePlan plan_core(const VoxelShape& shape, const Context* context);

/// Memory of the whole way from a shape to its skeletons, in bytes, by measured cases.
std::int64_t predicted_run_bytes(const VoxelShape& shape);
/// Memory that quench_curves() and skeletons() need for a burning, in bytes.
std::int64_t predicted_skeleton_bytes(const Burning& burning);

// -------------------------------------------------------------------------------------------------------------- shape

inline constexpr std::int64_t kAutomaticResolution = 0;
inline constexpr std::int64_t kLargestResolution = 16384;  ///< that voxelize() takes

/// A size of voxels "x,y,z" or of pixels "x,y" (the third number is 0 then), or one number for all; nothing unless all
/// are positive numbers.
std::optional<Vec3> spacing_in(std::string_view text);

/// How an input becomes a voxel shape. What is not given has the default of the stage or, in take_recorded(), the value
/// of an earlier run.
struct ShapeOptions {
  std::optional<std::int64_t> resolution = {};  ///< meshes; default 256; or kAutomaticResolution; polygons: 1024
  std::optional<FillRule> fill = {};            ///< meshes; default nonzero; polygons: that of their format
  std::optional<TopologyRule> topology = {};    ///< meshes; default mesh
  std::optional<double> pixel = {};             ///< polygons: side of a pixel, instead of a resolution
  std::optional<std::uint64_t> feature = {};    ///< polygons: the number of the feature that is wanted, from 0
  std::optional<Vec3> spacing = {};             ///< volumes; default: what the file says
  std::string spacing_text = {};                ///< as it was spelled, for the record; empty: spelled from `spacing`
  std::optional<int> dimension = {};            ///< volumes and images; 2 or 3: what one slice is
  std::string channel = {};                     ///< images with colours, as of io::VolumeReadOptions
  ForegroundOptions foreground = {};            ///< threshold, label, invert: volumes
  bool otsu = false;                            ///< volumes: the threshold is that of Otsu's method
  bool recommended = false;                     ///< volumes: the threshold is the first of proposed_thresholds()
  bool thin = false;                            ///< the recommended one is that of the rule `thin`, where there is one
  PreparationOptions preparation = {};          ///< volumes
  bool keep_values = false;                     ///< LoadedShape::values is wanted
  /// What the axis is fitted to; none: the mesh where its solid can be told, the grey values of a volume with a
  /// threshold, else the voxels.
  std::optional<SurfaceKind> surface = {};
  int subdivide = 1;         ///< splits every voxel; 1 to 64
  bool keep_mesh = false;    ///< LoadedShape::mesh is wanted
  bool core_follows = true;  ///< its memory counts too when the shape is subdivided
};

/// How a volume or image is read for a shape.
io::VolumeReadOptions read_options(const ShapeOptions& options);

/// A threshold that parts the dark values of an image from the bright ones.
struct ThresholdProposal {
  double low = 0, high = 0;  ///< the least and the largest value of the image
  bool two_values = false;   ///< there are no others
  Threshold threshold;
  bool bright_border = false;  ///< most pixels at its sides are bright: the shape may be what is dark
};

/// By Otsu's method (1979, IEEE Trans. SMC 9): the classes whose means lie farthest apart for their sizes. Nothing for
/// an image of one value, or of 0 and another one. O(samples).
std::optional<ThresholdProposal> propose_threshold(const Volume& image);

/// A shape ready for the main job, and what was found on the way.
struct LoadedShape {
  VoxelShape shape;
  Topology topology;
  double longest_side = 0;  ///< what plain-number lengths refer to, world units
  Grid image;               ///< voxels of the input, before they are subdivided
  Coordinates coordinates;  ///< where the file says so
  std::string parameters;   ///< JSON text: how the voxels follow from the input; empty: as it is

  bool from_mesh = false;
  std::size_t mesh_points = 0, mesh_triangles = 0;
  std::optional<Voxelization> voxelization;  ///< of a mesh, without its shape
  std::int64_t resolution = 0;               ///< of a mesh: that was used
  std::optional<TriangleMesh> mesh;          ///< where it was asked for
  std::optional<PolygonFeature> polygon;     ///< of a polygon: what was digitized
  std::string spacing_source;                ///< of a volume from a file: what its spacing was taken from
  std::optional<ForegroundReport> cleaned;   ///< where cleaning was asked for
  std::optional<PreparationReport> prepared;  ///< where preparing was asked for
  std::optional<ProposedThreshold> chosen;    ///< the threshold, where the program has chosen it
  std::optional<Volume> values;               ///< of a volume, prepared, where they were asked for
  std::optional<Surface> surface;            ///< what the axis is fitted to; none: the voxels

  Scale scale() const {
    return {longest_side, shape.grid().spacing.minCoeff(), auto_detail(shape.grid()), surface.has_value()};
  }
  /// Into how many along each side the voxels of the input were split.
  int subdivided() const;
  /// Whether voxelization changed the topology; nothing where it cannot be told (overlapping parts, defects).
  std::optional<bool> topology_changed() const;
};

/// Reads a mesh or a volume; volumes slice by slice where the format allows it. Throws Error(input), naming the file,
/// when it cannot be used.
LoadedShape load_shape(const std::filesystem::path& file, const ShapeOptions& options = {}, Context* context = nullptr);
/// The same of a mesh that was read from `file`.
LoadedShape shape_of(Record&& mesh, const std::filesystem::path& file, const ShapeOptions& options = {},
                     Context* context = nullptr);
/// The same of what is in memory.
LoadedShape shape_of(TriangleMesh&& mesh, const ShapeOptions& options, Context* context = nullptr);
LoadedShape shape_of(const ImageView& image, const Coordinates& coordinates, const ShapeOptions& options,
                     Context* context = nullptr);
/// A polygon, digitized. Throws what digitize() does, and Error(usage) for options that polygons do not take.
LoadedShape shape_of(PolygonFeature&& feature, const ShapeOptions& options, Context* context = nullptr);
/// Voxels that are given: subdivided as asked; `image` is the grid of the image they are from.
LoadedShape shape_of(VoxelShape&& voxels, const Grid& image, const ShapeOptions& options, Context* context = nullptr);

/// The feature of a file of polygons that is wanted, by its number, or the only one. Throws Error(usage), field
/// `feature`, when there are several and no number; Error(input) when it is not there or cannot be used.
PolygonFeature feature_of(const std::filesystem::path& file, const std::optional<std::uint64_t>& number,
                          Context* context = nullptr);
/// Whether a file of polygons has one feature, usable or not. Reads no further than the second.
bool holds_one_feature(const std::filesystem::path& file);
/// Throws Error(failed) when there is no memory to voxelize at a resolution.
void require_voxelization_memory(const TriangleMesh& mesh, std::int64_t resolution, const Context* context);
/// Throws Error(input) for a file whose name does not say what it holds.
[[noreturn]] void refuse_unknown_kind(const std::filesystem::path& file);

/// The JSON text `parameters` of a result; empty where there is none.
std::string parameters_of(const Record& result);
/// What is not given is taken from `parameters` of a result in `file`. Returns which of resolution, threshold, label,
/// invert and spacing were taken. Throws Error(input) naming the file and the parameter when its value is invalid.
std::vector<std::string> take_recorded(ShapeOptions& options, const Record& result, const std::string& file);

// --------------------------------------------------------------------------------------------------------------- core

/// Throws Error(invariant) with the Betti numbers of both unless the two agree: "the topology of the WHAT ... is not
/// that of the WHOSE".
void require_topology(const Topology& got, const Topology& wanted, const char* what, const char* whose);

struct CellCounts {
  std::size_t vertices = 0, edges = 0, faces = 0;
};
inline CellCounts counts_of(const CellComplex& c) { return {c.vertex_count, c.edges.size(), c.face_count()}; }

/// Which cells of a voxel core are kept.
struct Pruning {
  std::string_view measure = kDetail;    ///< one of kMeasures
  std::optional<Length> threshold = {};  ///< none: auto_detail() or auto_lambda(); others need one
};

/// A measure by its name and a threshold. Throws Error(usage), `field`, for other names and thresholds.
Pruning pruning_of(std::string_view measure, std::string_view threshold, std::string_view field);
/// The names of measures between commas, or all for "all". Throws Error(usage), field `measures`.
std::vector<std::string> parse_measures(std::string_view text);

/// Adds a measure of kMeasures to a voxel core of the shape, or to what a pruning has left of one: values are those of
/// what is there (docs/algorithms/pruning.md). Nothing happens when it is there. Throws Error(usage) for another name,
/// and for "detail" when the axis is pruned; Error(failed) when there is not enough memory.
void add_measure(MedialAxis& axis, const LoadedShape& of, std::string_view name, Context* context = nullptr);

struct AxisOptions {
  Pruning pruning = {};
  LambdaRule rule = LambdaRule::coface;
  bool full = false;  ///< also the cells below the threshold
  /// More measures of the result, as add_measure() has them; "detail" that of the whole core.
  std::vector<std::string> measures = {};
  /// Work in bricks (quench/bricks.h), whose files, without names, are in this folder; none: where memory asks for it,
  /// in the system's folder for temporary files.
  std::optional<std::filesystem::path> bricks_in = {};
};

/// A pruned (or, `full`, whole) voxel core with what was found on the way.
struct CoreResult {
  MedialAxis axis;
  AxisOptions options;
  CorePlan plan;
  double threshold = 0;         ///< of the measure, used or chosen, in its unit
  double longest_side = 0;      ///< what lengths refer to
  Topology topology;            ///< of shape, core and pruned core
  double reconstructed = 0;     ///< share of the shape in the balls of the pruned core
  double coverage = 0;          ///< largest distance of a boundary vertex to these balls, world units
  std::optional<double> whole;  ///< `reconstructed` of the unpruned core, where it was asked for or needed
  CellCounts all, kept;         ///< of the unpruned core, and of the pruned one
  Coordinates coordinates;      ///< of the shape
  std::string parameters;       ///< JSON text, those of the shape and of the core: what `quench verify` reads
  SurfaceFit fit;               ///< where the axis was fitted to a surface
};

/// Voxel core, levels, threshold, pruning, fit to the surface, reconstruction, in as many parts as memory asks for.
/// Notes a pruning by lambda whose balls hold less than 0.9 of the shape. Throws Error(failed), with figures, when
/// there is not enough memory, and Error(invariant) when the topology of core or pruning is not that of the shape.
CoreResult core_of(const LoadedShape& shape, const AxisOptions& options = {}, Context* context = nullptr);

/// The core of a shape for a larger threshold of its measure, without computing it anew. Throws Error(usage), field the
/// measure, for a smaller one than it was pruned with.
CoreResult pruned_further(const LoadedShape& shape, const CoreResult& core, const Length& threshold,
                          Context* context = nullptr);

/// The axis as a file: cells and arrays (docs/user/files.md), and as field data stage, the threshold by the
/// name of its measure, longest_side, reconstructed, coverage, topology, units, space, version and `parameters`.
Record core_file(const CoreResult& core);
/// The same where the axis is not needed any more: it is empty afterwards, the rest of `core` as it was.
Record core_file(CoreResult&& core);

// ---------------------------------------------------------------------------------------------------- axis from a file

/// The first value of a field array of a file, if it is there.
std::optional<double> field_number(const Record& data, const char* name);
std::optional<std::string> field_text(const Record& data, const char* name);

/// Boundary vertices of a pixel shape, from which radii of points between those of the axis are known.
struct PlaneSites {
  Grid grid;
  std::vector<LatticePoint> sites;  ///< in order of y, x
  /// The distance of a point of the plane to the nearest site; infinite where there are none. O(r log n) for r rows of
  /// sites within that distance.
  double distance(const Vec3& point) const;
};

/// A medial axis ready for burning. Vertex v of the axis is row v of the file.
struct LoadedAxis {
  MedialAxis axis;
  Record data;                  ///< the file, with all its arrays
  Scale scale;                  ///< what the file says, else the box of the axis and no voxels
  Vec3 spacing = Vec3::Zero();  ///< of the voxel shape, where the file says so
  bool voxel_core = false;      ///< of Quench, not fitted: the radius between vertices follows from theirs
  Coordinates coordinates;      ///< where the file says so
  std::optional<PlaneSites> sites;  ///< of a pixel shape: those that cells of the file have as nearest
};

/// Reads a surface or an axis, if there is memory for it.
Record read_surface(const std::filesystem::path& file, Context* context = nullptr);
/// "medial axis", "burned medial axis" or "skeleton": what a surface is that is no mesh of a shape. Empty: it is one.
std::string_view result_name(const Record& data);
/// Puts the radii of a .r file in place of those of `data`.
void take_radii(Record& data, const std::filesystem::path& radii, Context* context = nullptr);
/// The axis in the data of `file`. Notes what was mended. Throws Error(input), naming the file, when it is empty or has
/// no radii.
LoadedAxis axis_of(Record&& data, const std::string& file, Context* context = nullptr);

// ------------------------------------------------------------------------------------------------------------ burning

std::string_view name_of(LambdaRule rule);  ///< "coface", "ball"
std::string_view name_of(RadiusRule rule);  ///< "exact", "linear"
std::string_view name_of(Propagation propagation);  ///< "segments", "windows"
/// The value of that name; nothing when there is none.
std::optional<LambdaRule> lambda_rule_of(std::string_view name);
std::optional<RadiusRule> radius_rule_of(std::string_view name);
std::optional<Propagation> propagation_of(std::string_view name);

/// What is not given is automatic: default_omega(); radii exact for voxel cores of Quench, else linear; by segments.
struct BurningOptions {
  std::optional<Length> omega = {};
  std::optional<RadiusRule> radius = {};
  std::optional<Propagation> propagation = {};
};

/// omega "auto" or a length above 0. Throws Error(usage), field `omega`, otherwise.
std::optional<Length> parse_omega(std::string_view text);
/// What is not given is taken from the field data of a burned file.
void take_recorded(BurningOptions& options, const Record& burned);

/// What reports say of a burning, which is used up by what follows.
struct BurnFigures {
  BurnOptions options;  ///< with the omega that was used
  std::size_t nodes = 0;
  double max_burn_time = 0;
  std::uint32_t unburned = 0;
  bool from_file = false;  ///< nothing was burned: kept_burning_of() found it
};
BurnFigures figures_of(const Burning& burning);

/// burn(), rounded as files keep it, with its plan of memory. `parents`: for the curves.
Burning burning_of(const MedialAxis& axis, bool voxel_core, const BurningOptions& options, bool parents,
                   const Scale& scale, Context* context = nullptr);
/// The same burning, with parents, from the file of the axis where it keeps one of these options. Notes where what it
/// keeps does not fit.
std::optional<Burning> kept_burning_of(const MedialAxis& axis, const Record& file, bool voxel_core,
                                       const BurningOptions& options, const Scale& scale, Context* context = nullptr);

// ----------------------------------------------------------------------------------------------------------- skeleton

struct FamilyResult {
  SkeletonFamily family;
  Topology topology;  ///< of the medial axis and of the curves
  CellCounts curves;  ///< of the member with theta2 infinite and theta1 that of the floor
};

/// The least thetas a family is wanted for, as of with_floor(); 0: all.
struct FamilyFloor {
  double theta2 = 0, theta1 = 0;
};

/// quench_curves() with its plan of memory.
RefinedAxis curves_of(const MedialAxis& axis, Burning burning, Context* context = nullptr);
/// Throws Error(invariant) when the topology of the curves is not `wanted`, that of the medial axis.
FamilyResult family_of(RefinedAxis&& refined, const Topology& wanted, const FamilyFloor& floor = {},
                       Context* context = nullptr);

struct SkeletonOptions {
  /// None: 0.03 of the longest side, but no less than three times Scale::detail (2.6 voxels for cubes): what the steps
  /// of voxels leave near the axis of a limb is smaller.
  std::optional<Length> theta2 = {};
  /// None: half the radius of what a branch leaves, as ExtractOptions::theta1_radii. With that, or radii as the unit,
  /// branches are no thinner than 4.5 times Scale::detail (3.9 voxels for cubes) or, without voxels, 0.01 of the
  /// longest side either.
  std::optional<Length> theta1 = {};
  bool parts = false;      ///< as ExtractOptions::parts
  bool full_tips = true;   ///< branches end where the shape does, not where pruning took them
  bool main_axes = false;  ///< one course per component only: main_axes()
};

struct SkeletonResult {
  Skeleton skeleton;
  Topology topology;  ///< of the skeleton: that of the medial axis unless it is reduced to main axes
  std::optional<double> reconstructed = {};  ///< share of the shape in its balls, where the shape was at hand
};

/// World lengths of the thresholds, and ExtractOptions::theta1_radii.
double theta2_of(const SkeletonOptions& options, const Scale& scale);
double theta1_of(const SkeletonOptions& options, const Scale& scale);
double theta1_radii_of(const SkeletonOptions& options);

/// A floor below which a run looks at nothing: a voxel, or the distance of the nodes of the burning where there are no
/// voxels, and at most what `options` ask for. Rounded down to floats, as pages have them.
FamilyFloor floor_of(const SkeletonOptions& options, const Scale& scale, double omega);

/// One member of a family. Tips are as thin as a voxel, of fitted axes as a fifth of one or, without voxels, as the
/// nodes of the burning lie apart (`omega`). Throws Error(invariant) when its topology is not that of the medial axis.
SkeletonResult skeleton_of(const FamilyResult& family, const SkeletonOptions& options, const Scale& scale, double omega,
                           Context* context = nullptr);

/// The skeleton as a file: its cells and arrays, and what the file `from` of its axis says of shape and burning.
Record skeleton_file(const SkeletonResult& skeleton, const Record& from);

/// Share of the shape's (sampled) voxel centres in the balls of a skeleton's vertices.
double reconstructed_share(const VoxelShape& shape, const Skeleton& skeleton, Context* context = nullptr);

// -------------------------------------------------------------------------------------------------------------- graph

struct GraphOptions {
  int smooth = 10;                    ///< as SmoothOptions::iterations; 0 to 10000
  Length resample = {};               ///< as SmoothOptions::spacing
  const VoxelShape* shape = nullptr;  ///< where it is known: segments are tested against its voxels
  Vec3 voxel = Vec3::Zero();          ///< spacing of the voxels; 0 for axes that are fitted or of other programs
  const Surface* surface = nullptr;   ///< that a fitted axis is fitted to, where it is known: radii are distances to it
  const PlaneSites* sites = nullptr;  ///< of the plane, where they are known: radii are distances to them
  bool extend = false;                ///< draw_branches() returns a graph that is extended() in `shape`
};

/// A finite length. Throws Error(usage), field `resample`, otherwise.
Length parse_resample(std::string_view text);

/// The curves of a skeleton as a graph, smoothed as asked, with the radii of balls. Throws Error(usage).
CurveGraph smoothed_graph(const Skeleton& skeleton, const GraphOptions& options = {}, const Scale& scale = {});
/// The same to measure on: radii of a voxel core get half a voxel more: of the corners of a staircase the nearest lies
/// that far inside the surface it stands for. Those of images and polygons stay as they are.
CurveGraph measured_graph(const Skeleton& skeleton, const GraphOptions& options = {}, const Scale& scale = {});
/// Draws the skeleton with the branches of its smoothed_graph(), and returns its measured_graph(). Throws
/// Error(invariant) when that changed the topology.
CurveGraph draw_branches(SkeletonResult& skeleton, const GraphOptions& options, const Scale& scale,
                         Context* context = nullptr);

// --------------------------------------------------------------------------------------------------------------- page

/// Whether this library has the interactive page built in.
bool has_page_program();
/// Throws Error(failed) unless it has.
void require_page_program();

/// A page while it grows: layers share the triangles, in the order in which they are added.
class PageBuilder {
 public:
  explicit PageBuilder(std::size_t max_triangles = kPageTriangles);
  Page page;

  /// The box of what will be added, for shapes far from zero: before anything is added.
  void set_origin(const Vec3& low, const Vec3& high);
  /// All is of the plane, of pixels of this spacing; add_shape() calls it. Lengths are in pixels where nothing says
  /// otherwise and the spacing is 1.
  void set_plane(const Vec3& pixel, bool y_down);
  /// Side, voxel, unit and topology; surface (of the kept mesh where it was not cleaned) and samples; boundary
  /// vertices where the axis is that of the voxels. The mesh is used up.
  void add_shape(LoadedShape& shape);
  /// `skeleton_follows`: leaves most of the triangles to it. Cells without levels are there at every threshold.
  void add_core(const MedialAxis& axis, const std::vector<DataArray>& measures, bool skeleton_follows);
  /// Values of the surface that add_shape() added, by which it is coloured: its local thickness, from the balls of an
  /// axis of the shape. A ball may be a voxel away from a point of it.
  void add_thickness(const MedialAxis& axis, Context* context = nullptr);
  /// The table of the sheets of the skeleton that was added.
  void add_sheets(const Parts& parts);
  /// Medial meshes of any number of vertices, of the axis of a shape whose boundary is given by points.
  /// `measured`: the points are of the shape itself, so that distances from them are errors.
  void add_meshes(const MedialAxis& axis, const BoundaryPoints& boundary, bool measured, Context* context = nullptr);
  /// The skeleton that is asked for, whole.
  void add_skeleton(const Skeleton& skeleton, const CurveGraph& graph);
  /// What is left of the triangles, for the sliders.
  void add_family(SkeletonFamily family);
  void add_still(const Record& data);
  /// The tree of a shape, or one read from a file: then side and unit are its own. See quench::add_tree().
  void add_tree(const Tree& tree, const Traits& traits, const std::vector<TreeEdit>& edits, bool upright = true);

  std::size_t triangles() const { return used_; }
  void write(const std::filesystem::path& file) const;

 private:
  void take(std::size_t triangles);
  std::size_t left_, used_ = 0;
};

/// "armadillo" of armadillo.off or armadillo/core.vtp.
std::string title_of(const std::filesystem::path& file);

// ---------------------------------------------------------------------------------------------------------------- run

struct RunOptions {
  AxisOptions axis = {};
  BurningOptions burning = {};
  SkeletonOptions skeleton = {};
  GraphOptions graph = {};      ///< run() fills in shape, voxel and surface
  PageBuilder* page = nullptr;  ///< where a page is wanted: layers are added to it, writing it is left to the caller
  bool page_sliders = true;     ///< the page gets what its sliders need: the layers `core` and `family`
  bool measures = false;        ///< AxisRun::parts and RunResult::thickness are wanted; the page gets them, too
  bool keep_sequence = false;   ///< AxisRun::file holds the burn sequence, for kept_burning_of(); run() always does so
  std::optional<Length> narrower = {};  ///< branches only where the shape is narrower: RunResult::wide is the rest
  std::function<void(const CoreResult&)> on_core = {};     ///< called as soon as there is one
  std::function<void(const BurnFigures&)> on_burned = {};  ///< the same
};

/// What follows from a medial axis.
struct AxisRun {
  Record file;  ///< of the axis, burned
  BurnFigures burned;
  CellCounts curves;  ///< as FamilyResult::curves
  SkeletonResult skeleton;
  CurveGraph graph;
  std::vector<MedialPoint> medial_points;  ///< in the plane: medial_points()
  std::optional<Parts> parts = {};         ///< of a skeleton in space, where it was asked for
};

/// How thick the sheets of a skeleton are (2 r by area, of the plane curves by length), and the shape: its local
/// thickness at some of its voxels, evenly chosen, from the balls of its pruned axis.
struct RunThickness {
  ThicknessDistribution sheets, shape;
  double correction = 0;  ///< that was added to every radius
};

/// Burning, curves and skeleton, above the floor_of() the options, of an axis whose file is `file` and whose topology
/// is `wanted`. What the file keeps of a burning as asked is not burned again. The page gets the axis where it has
/// levels.
AxisRun run_axis(const MedialAxis& axis, Record&& file, bool voxel_core, const Topology& wanted, const Scale& scale,
                 const RunOptions& options = {}, Context* context = nullptr);

struct RunResult {
  CoreResult core;
  AxisRun axis;
  std::optional<RunThickness> thickness = {};
  std::optional<VoxelShape> wide = {};  ///< wide_part() for RunOptions::narrower; AxisRun::graph is outside_of() it
};

/// All stages from a shape on. The mesh of the shape is used up by the page.
RunResult run(LoadedShape& shape, const RunOptions& options = {}, Context* context = nullptr);

/// What became of a feature of a file of polygons.
struct FeatureRun {
  std::uint64_t number = 0;
  std::string id, properties;         ///< as in PolygonFeature
  std::string failure;                ///< a sentence, where there is no result; else empty
  std::vector<std::string> notes;     ///< what its run had to say
  std::optional<LoadedShape> shape;   ///< where there is a result
  std::optional<RunResult> result;  ///< without the cells and the file of the medial axis
};

/// run() of each polygon of a file, on all threads, several at a time; `take` is called on the calling thread in the
/// order of the file. Memory is bounded, whatever the file: that of features with some 260,000 boundary vertices
/// together (or of one with more), and of 256 features at most.
/// A feature that cannot be used is one with a `failure`. Throws Error(usage) for options that no feature takes, and
/// what io::for_each_feature() throws.
void run_features(const std::filesystem::path& file, const ShapeOptions& shape, const RunOptions& options,
                  const std::function<void(FeatureRun&&)>& take, Context* context = nullptr);

// --------------------------------------------------------------------------------------------------------------- tree

/// What a tree is the tree of: sets defaults.
enum class TreeKind : std::uint8_t { root, neuron, vessel, airway };
std::string_view name_of(TreeKind kind);
std::optional<TreeKind> tree_kind_of(std::string_view name);

struct TreeOptions {
  TreeKind kind = TreeKind::root;
  RepairOptions repair = {};
  HierarchyOptions hierarchy = {};
  TraitOptions traits = {};
  bool edited_shape = true;  ///< TreeRun::edited is wanted
  /// HierarchyOptions::down becomes what is likely: -z or +z, so that the centroid of the volume lies above the mean of
  /// that of the length and the middle of the height; of a tree from a file, so that it lies below its root nodes, along y where it is flat in z.
  bool find_down = false;
};

/// The options of a kind where nothing else is asked for.
TreeOptions defaults_of(TreeKind kind);

/// The curves that a tree is made of.
struct TreeCurves {
  CurveGraph graph;
  Scale scale;
  Vec3 voxel = Vec3::Zero();  ///< as GraphOptions::voxel
  Coordinates coordinates;
};

/// A skeleton of curves, as trees are made of, unless something else is asked for: theta2 infinite, and theta1 one
/// radius of what a branch leaves.
SkeletonOptions skeleton_for_trees(SkeletonOptions asked);
/// Where no distance of points is asked for, and voxels are known: a voxel.
GraphOptions graph_for_trees(GraphOptions asked, const Scale& scale);
/// The curves in a result that was read, a medial axis or a skeleton of curves; `options` as of run_axis(), for a
/// medial axis. `shape`: where it is known. Throws Error(usage), naming the file, for one of the plane and for a
/// skeleton with sheets.
TreeCurves curves_in(Record&& result, const std::string& file, RunOptions options, const LoadedShape* shape = nullptr,
                     Context* context = nullptr);

struct TreeRun {
  Tree tree;
  Traits traits;
  std::vector<TreeEdit> edits;
  std::uint32_t components_before = 0, loops_before = 0;
  double length_before = 0;  ///< of all curves
  std::optional<VoxelShape> edited;
  std::optional<Topology> edited_topology;
  std::size_t edits_of(TreeEdit::Kind kind) const;
  double length_of(TreeEdit::Kind kind) const;
};

/// Repair, hierarchy and traits of curves. `shape`: that they are of, where it is known; with its values bridges follow
/// them. Throws Error(usage) for curves with sheets, Error(input) where there are none, and Error(invariant) when the
/// edited shape is not one tree per plant.
TreeRun run_tree(const TreeCurves& curves, const TreeOptions& options, const LoadedShape* shape = nullptr,
                 Context* context = nullptr);
/// The same of a tree from a file, which is not repaired. `new_axes`: which axes there are is found anew.
TreeRun run_tree(Tree&& tree, bool new_axes, const TreeOptions& options);

/// A row per edit: number, kind, its two ends, radius, length, cost, grey.
Table table_of(const std::vector<TreeEdit>& edits, const Coordinates& coordinates);

}  // namespace quench::pipeline
