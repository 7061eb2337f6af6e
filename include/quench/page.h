// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/geometry.h"
#include "quench/graph.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/table.h"
#include "quench/tree.h"

/// @file
/// The interactive page of a result: one HTML file with the data inside (viewer/FORMAT.md is its format).
namespace quench {

struct CollapseSequence;  // quench/simplify.h

/// A named array of a page: `values.size()` is rows * components.
struct PageArray {
  using Values = std::variant<std::vector<float>, std::vector<std::uint32_t>, std::vector<std::uint16_t>,
                              std::vector<std::uint8_t>>;
  std::string name;
  int components = 1;
  Values values;
};

/// The pruning of a medial axis.
struct PagePruning {
  std::string measure;
  double threshold = 0;
};

/// A measure by whose levels the layer `core` of a page can be pruned.
struct PageMeasure {
  std::string name;
  double floor = 0;  ///< what its pruning keeps is complete from this threshold on
};

/// The surfaces of a page, which are drawn as one: how many, and their triangles.
struct PageSurfaces {
  std::size_t count = 0, given = 0, drawn = 0;
  std::optional<std::size_t> note;  ///< the one of Page::notes that says so, where some are simplified
};

/// A column of a table: of the layer `tree`, whose values are the array `tree/TABLE/NAME`, or of sheets, `TABLE/NAME`.
struct PageColumn {
  std::string table;  ///< "axes", "branches", "sample" (one row), "edits"; "sheets"
  std::string name, unit, meaning;
  bool whole = false;              ///< integers
  std::vector<std::string> words;  ///< of a column of words: its values are their numbers
};

/// What a page says of the layer `tree` beside its arrays. Directions are unit vectors.
struct PageTree {
  Vec3 down = -Vec3::UnitZ();
  Vec3 to_eye = -Vec3::UnitY(), up = Vec3::UnitZ();  ///< from where it is seen first
  std::vector<PageColumn> columns;
};

/// What a page holds. Lengths are in world units. Everything may be missing: an empty string, a zero, no value.
struct Page {
  std::string title, program, command, unit;
  std::string state;                     ///< what the page starts with, in the form of the part of its address after #
  double side = 0;                       ///< longest side of the shape: what plain-number lengths refer to
  double voxel = 0;                      ///< smallest spacing of the voxel shape
  std::optional<PagePruning> pruning;    ///< what the burn belongs to
  std::optional<double> theta2, theta1;  ///< of the layer `skeleton`, where the sliders start; may be infinite
  double theta1_radii = 0;               ///< of the layer `skeleton`, as ExtractOptions::theta1_radii
  std::optional<BurnOptions> burning;
  std::optional<Topology> topology;
  std::vector<std::pair<std::string, std::string>> files;  ///< what they are, their names: for the command line

  std::string limit_name;  ///< what the front end calls the largest number of triangles, for the notes

  /// Taken off all coordinates before they are rounded to floats: to be set before anything is added, for shapes far
  /// from the zero of their coordinates.
  Vec3 origin = Vec3::Zero();

  bool voxel_surface = false;  ///< the surface is that of voxels: without sharp edges
  bool plane = false;          ///< of a shape of the plane: flat, seen from the front, curves without sheets
  bool y_down = false;         ///< of a plane: y grows downwards, as in pictures

  /// Filled by the functions below. Cells below a floor are left out, what is above is complete.
  std::vector<PageMeasure> measures;
  std::optional<double> theta2_floor, theta1_floor;
  std::optional<std::array<double, 12>> sites_to_world;  ///< rows of a 3 x 4 matrix
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();          ///< box around everything that was added
  std::string note;                                      ///< what is to be known before the first look; mostly nothing
  std::vector<std::string> notes;                        ///< what was simplified, a sentence each
  PageSurfaces surfaces;
  std::optional<PageTree> tree;
  std::vector<PageColumn> columns;  ///< of tables but those of the tree
  std::vector<PageArray> arrays;

  const PageArray* find(std::string_view name) const;
};

/// The most triangles a page holds unless told otherwise: fluid on an ordinary laptop.
inline constexpr std::size_t kPageTriangles = 1'000'000;

/// The layer `core`: a medial axis with its levels by each measure that has some, and `point_data` of its vertices
/// (arrays of one component; where `unburned` is 1, burn_time and erosion_thickness are infinite). More than
/// `max_triangles`: the smallest threshold of each measure is found at which the rest fits into its share of them, and
/// what is below all of these is left out. Returns the number of triangles. Throws Error(usage) for an axis without
/// levels.
std::size_t add_core(Page& page, const MedialAxis& axis, const std::vector<DataArray>& point_data,
                     std::size_t max_triangles);

/// The layer `skeleton`: a skeleton as it is written to a file, whole: its polygons, the branches of its curves with
/// their measures, and its isolated vertices. Points of branches that are no vertices of the skeleton get values
/// between those of vertices beside them. Returns the number of triangles.
std::size_t add_skeleton(Page& page, const Skeleton& skeleton, const CurveGraph& graph);

/// The table of the sheets of the layer `skeleton`, a row for each in any order; its column `sheet` has their numbers,
/// those of Skeleton::face_sheet. Throws Error(usage) unless each sheet of the layer has its row.
void add_sheets(Page& page, const Table& sheets);

/// What is known of the error of a medial mesh: distances of the boundary of the shape to its envelope, world units.
struct PageMeshError {
  std::size_t vertices = 0;
  double mean = 0, percentile99 = 0, largest = 0;
};

/// The layer `simple`: medial meshes of every number of vertices from the first of the sequence on.
void add_meshes(Page& page, const CollapseSequence& sequence, const std::vector<PageMeshError>& errors = {});

/// The layer `family`, for the sliders of a skeleton: the refined axis with the levels of its family. What does not fit
/// (a curve off the sheets counts as a triangle) is left out by floors of theta2 and theta1. Region duals lie on their
/// exit doors, as in skeletons that are written. Returns the number of triangles.
std::size_t add_family(Page& page, SkeletonFamily family, std::size_t max_triangles);

/// The layer `still`: cells without levels; degenerate ones are mended. What does not fit is simplified by clustering
/// vertices.
std::size_t add_still(Page& page, const Record& data, std::size_t max_triangles);

/// The surface of the shape: a mesh, or the boundary of a voxel shape, whose corners are smoothed by up to half a voxel
/// for display; of a pixel shape the area itself, as it is, in few triangles. What does not fit is simplified by
/// clustering vertices. Several surfaces are drawn as one.
std::size_t add_surface(Page& page, const TriangleMesh& mesh, std::size_t max_triangles);
std::size_t add_surface(Page& page, const VoxelShape& shape, std::size_t max_triangles);

/// The points of the surface as it is drawn, in world units.
std::vector<Vec3> surface_points(const Page& page);

/// Values by which the surface can be coloured, one per point of surface_points(); NaN: there is none. `name` is that
/// of the measure: "thickness". Throws Error(usage) for another number of values.
void add_surface_measure(Page& page, const std::string& name, const std::vector<double>& values);

/// The boundary of the voxel shape as quads of two triangles, outward; smoothed for display (see above). Throws
/// Error(usage) for a pixel shape.
TriangleMesh smoothed_boundary(const VoxelShape& shape, int iterations);

/// The area of a pixel shape as triangles that meet along whole sides: a side of one triangle only is on the outline.
/// Corners are boundary vertices. O(runs log runs).
TriangleMesh flat_pixels(const VoxelShape& shape);

/// The boundary vertices, for the touching points of balls. Left out, with a note, when they are too many for a page
/// or their coordinates outgrow 16 bits. Once per page: all have one grid.
void add_sites(Page& page, const VoxelShape& shape);

/// `count` points uniformly distributed in the shape (every voxel has the same share of them): the share of them inside
/// balls is the share of the volume, of the plane that of the area. Deterministic.
void add_samples(Page& page, const VoxelShape& shape, std::size_t count = 20000);

/// The layer `tree`: the branches of a tree as courses with radii, the tables of its axes, branches and of the sample
/// as they are in the files, and the places where it was repaired. The page starts with it: `upright` from the side on
/// which it is broadest with `down` downwards, else from where it is broadest of all. Branches that leave their axis
/// get inside of it at most the radius that they have outside, so that tubes of different axes do not lie in one
/// another. The page has one tree. O(points).
void add_tree(Page& page, const Tree& tree, const Traits& traits, const std::vector<TreeEdit>& edits,
              bool upright = true);

/// The page with the program `page_program` around it: an HTML file. Written atomically. Throws Error(failed) when
/// writing fails or the page outgrows what a browser can hold, Error(invariant) when the program has no place for it.
void write_page(const std::filesystem::path& file, const Page& page, std::string_view page_program);

}  // namespace quench
