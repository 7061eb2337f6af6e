// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/surface.h"

namespace quench {

/// A significance measure of the cells of a medial axis. Its pruning for a threshold t is { level >= t }.
struct Measure {
  std::string name;  ///< what its arrays in files are called
  CellValues value;  ///< 0 or more; empty where the axis was read from a file
  CellValues level;  ///< the largest threshold whose pruning keeps the cell, infinite where topology needs the cell at
                     ///< any threshold; empty before prune_levels()
};

/// A medial axis: a complex in the world with a radius per vertex. The voxel core fills every member; a foreign medial
/// axis has points, radius and complex only. Lengths are in world units. In the plane (`grid.is_plane()`) it is a
/// graph, without faces.
struct MedialAxis {
  CellComplex complex;
  std::vector<Vec3> points;       ///< per vertex
  std::vector<double> radius;     ///< per vertex: distance to its nearest sites
  std::vector<Measure> measures;  ///< of different names; more may be added

  /// The measure of that name, or null.
  const Measure* find_measure(std::string_view name) const;
  /// The same; throws Error(usage) when there is none.
  const Measure& measure(std::string_view name = kLambda) const;
  Measure& measure(std::string_view name = kLambda);
  /// Whether there are levels of any measure.
  bool has_levels() const {
    return std::ranges::any_of(measures, [](const Measure& m) { return !m.level.empty(); });
  }

  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< the two nearest sites of each face, smaller row first
  std::vector<std::array<std::uint32_t, 2>> edge_sites;  ///< of a plane, which has no faces: the same of each edge
  std::vector<LatticePoint> sites;  ///< boundary vertices of the voxel shape that faces and edges refer to
  Grid grid;                        ///< transform of lattice coordinates

  /// Of an axis that fit_to_surface() has moved: points and radii of the voxel core, which lambda, detail and what
  /// follows from them refer to. Empty otherwise.
  std::vector<Vec3> voxel_points;
  std::vector<double> voxel_radius;
  SurfaceKind surface = SurfaceKind::voxels;  ///< what points and radii refer to
  bool is_fitted() const { return surface != SurfaceKind::voxels; }
  const std::vector<Vec3>& points_of_voxels() const { return is_fitted() ? voxel_points : points; }
  const std::vector<double>& radius_of_voxels() const { return is_fitted() ? voxel_radius : radius; }
};

/// A measure that follows from others of the axis. Those that need lambda:
/// - "object_angle": the angle between the directions from the centre of a cell to the two nearest boundary points its
///   lambda stands for, in degrees: 2 asin(lambda / radius);
/// - "cap_height": what the ball of a cell reaches beyond the chord between those two points, r - sqrt(r^2 - lambda^2):
///   of a face the largest over its corners, of edges and vertices the largest of the faces around or, without faces,
///   by their own lambda and radius.
/// To be added to `measures` for a pruning by it. Throws Error(usage) for a name that is not
/// known or when what it follows from is not there.
Measure derived_measure(const MedialAxis& axis, std::string_view name);
/// The names for which derived_measure() succeeds.
std::vector<std::string> derived_measures(const MedialAxis& axis);

/// The axis as cells and arrays for a file: point array `radius`; for each measure, and for the derived ones that are
/// not among them, the point and cell array NAME (values) and the cell array `NAME_level`, where they are there; cell
/// arrays `kind` (0 part of a sheet, 1 curve, 2 point), `component`, and where there is lambda `site_a`, `site_b`;
/// field arrays `sites` and the grid, `format_version` and `measures` (their names). A line is written for an edge with
/// no face or with a level above that of its faces, a vertex cell likewise, so that the closure of the cells with
/// NAME_level >= t is the pruning for t, for every t. So it is for an edge whose value is not the largest of its faces,
/// but for lambda, which the sites give. Throws Error(usage) when values or levels are there for some cells only, or
/// when a measure has no name or that of another array.
Record to_record(const MedialAxis& axis);
/// The same of an axis that is not needed any more and is empty afterwards.
Record to_record(MedialAxis&& axis);

/// The closure of the cells of a file as a complex on the points of the file that some cell uses; `point_of[v]` is the
/// row of vertex v. Lines and vertex cells that are part of a larger cell are merged with it.
CellComplex complex_of(const Record& data, std::vector<std::uint32_t>* point_of = nullptr);

/// What medial_axis_of() had to mend, in cells of the file.
struct AxisRepair {
  std::size_t degenerate = 0;  ///< polygons or lines that repeat a corner: what is left of them is kept
  std::size_t duplicate = 0;   ///< polygons with the corners of an earlier one: dropped
};

/// A medial axis, ours or foreign, as read from a file: complex, points and radius (of the point array `radius`).
/// Points that no cell uses are isolated vertices. Vertex v is row v of the file. Throws Error(input) when there is no
/// radius.
MedialAxis medial_axis_of(const Record& data, AxisRepair* repair = nullptr);

/// Gives an axis the levels of its cells (not the values) by the measures of the file it was read from: all in the
/// field array `measures`, in a file without it lambda, that have a cell array `NAME_level`. False, and the axis
/// unchanged, when there is none, cells were mended in reading, or the axis is that of another file.
bool take_levels(MedialAxis& axis, const Record& data);

/// How lambda of edges and vertices follows from their sites (docs/algorithms/voxel_core.md).
enum class LambdaRule {
  coface,  ///< the largest lambda of the faces and edges around the cell: the rule behind the published results
  ball     ///< radius of the smallest ball enclosing the cell's own sites: the dissertation's definition
};

struct CoreOptions {
  LambdaRule rule = LambdaRule::coface;
};

/// The voxel core: the part of the Voronoi diagram of the boundary vertices of O whose dual Delaunay cells meet O
/// (Yan 2018, Def. 2.4.1). Exact: maximal cospherical sets of sites are one vertex; no zero-length edges, zero-area or
/// duplicate faces. It has the topology of O (Thm. 2.4.3) and lies strictly inside O (Thm. 2.4.5).
///
/// Cells are ordered by the lattice coordinates of their sites, so the result does not depend on threads, translation
/// or padding. About 265 bytes per site at the peak. Throws Error(input) for an empty shape or one whose
/// spacing has no integer proportion, Error(failed) when an index outgrows 32 bits.
MedialAxis voxel_core(const VoxelShape& shape, const CoreOptions& options = {}, Context* context = nullptr);

/// Predicted growth of memory, in bytes, from a voxel shape to its checked and pruned core (pipeline::core_of()) and
/// its file, beside what the process holds before, on the threads of the arena. Usually 0 to 15 % more than it takes
/// for shapes of more than 50,000 boundary vertices; what was measured stands in notes/robustness.md. Shapes with flat
/// walls and ones a voxel thick need less than others.
std::int64_t predicted_core_bytes(const VoxelShape& shape);
/// The most for so many boundary vertices.
std::int64_t predicted_core_bytes(std::int64_t sites);
/// The same for pipeline::AxisOptions::bricks_in.
std::int64_t predicted_core_bytes_in_bricks(const VoxelShape& shape);
/// The least for so many boundary vertices.
std::int64_t predicted_core_bytes_in_bricks(std::int64_t sites);

/// The automatic detail: half the voxel diagonal, the most that a staircase of voxels on a flat side sticks out.
double auto_detail(const Grid& grid);

/// Adds the measure "detail" to an unpruned voxel core: the largest length d at which a cell is kept, by these rules.
///
/// - A cell is significant at d when its cap height is above d, and that of some cell connected to it by such cells is
///   above sqrt(3) d (1.5 voxels for the automatic detail of cubes). What is smaller is a tooth under the surface.
/// - Where a boundary vertex is farther than a voxel diagonal from the balls significant at auto_detail(), the
///   component that touches it is kept up to there, too, or, where nothing is significant, the cells whose balls do.
/// - Above auto_detail(), vertices are kept until their balls lie within 2 (d - auto_detail()) of one that is kept.
///
/// So every boundary vertex lies within max(2 d, voxel diagonal) of the balls of the pruning for d, for every d
/// (docs/algorithms/pruning.md). Details are infinite for one vertex of every connected component. Cap heights that
/// equal a detail up to 2e-9 are not above it. O(n log n) in practice. Throws Error(usage) for an axis without lambda.
void add_detail(MedialAxis& axis, Context* context = nullptr);
/// The same, where cap heights above auto_detail() only count as far as the surface bears them out: the two sites of a
/// face stand for two places where its ball should touch the surface. Where the cap between these is below half of
/// auto_detail(), its height counts instead: blades that the steps of voxels leave near the axis of a limb go. The
/// promise is the same.
void add_detail(MedialAxis& axis, const Surface& surface, Context* context = nullptr);

/// The largest distance of a boundary vertex of the shape to the union of the balls of an axis (those of the voxel
/// core, where it was fitted), 0 when all touch it; infinite for an axis without vertices.
double coverage(const VoxelShape& shape, const MedialAxis& axis, Context* context = nullptr);

/// Adds the measure "mgf" to a voxel core, or to what a pruning has left of it: the medial geodesic function (Dey and Sun
/// 2006). Of a face it is the length of the shortest way on the boundary of the voxel shape between its two nearest
/// boundary vertices, infinite where they lie on different sides of it; of edges and vertices the largest of the faces
/// around or, where there are none, of the pairs of their own nearest boundary vertices. The boundary is that seen from
/// inside: where the shape touches itself, no way leads over (docs/algorithms/mgf.md). Exact but for the rounding of the
/// sum of a few roots. Nothing happens when the measure is there, as in the plane.
///
/// World units. Time: some ten microseconds per pair that is near and a millisecond per pair that is far apart on the
/// surface, on all threads. Throws Error(usage) when the axis is not a voxel core of `shape`.
void add_mgf(MedialAxis& axis, const VoxelShape& shape, Context* context = nullptr);
/// Bytes that add_mgf() takes on so many threads beside the axis.
std::int64_t predicted_mgf_bytes(const VoxelShape& shape, std::size_t faces, int threads);

/// Adds the measure "chord_residual": what the MGF exceeds the distance of the two nearest boundary vertices by (Ogniewicz
/// and Kuebler 1995, whose potential residual is the MGF), of edges and vertices as add_mgf() has it. 0 where it is below
/// 1e-9 of the MGF, that is, rounding; infinite where the MGF is. Takes the MGF of faces from the axis where it is there.
/// Time, memory and errors as add_mgf().
void add_chord_residual(MedialAxis& axis, const VoxelShape& shape, Context* context = nullptr);

/// Adds the measure "circumradius": of faces the smallest radius of their corners (of a fitted axis those of the voxel
/// core), of edges and vertices the largest of the faces around or, where there are none, the smallest of their own.
/// Nothing happens when it is there. O(n).
void add_circumradius(MedialAxis& axis, Context* context = nullptr);

/// Adds the measure "scale_axis" (Miklos, Giesen and Pauly 2010): the largest s at which a ball, grown to s times its
/// radius, is not yet inside another one that has grown, too: of a vertex the minimum of |v - w| / (r_w - r_v) over the
/// larger balls, infinite where there is none; of cells as circumradius. At least 1: no ball of a medial axis contains
/// another. Radii that differ by less than 1e-9 of their size count as equal. Nothing happens when the measure is there.
///
/// Deterministic: minima do not depend on the order. Usually near O(n log n), on all threads; about 80 bytes per vertex.
void add_scale_axis(MedialAxis& axis, Context* context = nullptr);

/// Computes the level of every cell by a measure: topology-preserving thinning by simple pairs (face, free edge) or
/// (edge, free vertex) in the order (larger value of the pair, dimension, index); the level of a cell is the running
/// maximum of the keys when it went, infinite when it never goes. The pruning for any threshold t is { level >= t }
/// (Yan 2018, sec. 2.6 step 3). O(n log n). Throws Error(usage) unless there is a value of 0 or more for every cell.
void prune_levels(MedialAxis& axis, std::string_view measure, Context* context = nullptr);
/// By lambda.
void prune_levels(MedialAxis& axis, Context* context = nullptr);

/// The pruning { level >= threshold } by a measure as a medial axis of its own: with the levels of that measure and the
/// values of all, without unused sites and the levels of other measures, which are those of the whole axis. Levels
/// within 1e-12 relative below the threshold count as equal, so that a length given as a multiple of the voxel size
/// does not depend on rounding. Throws Error(usage) for an axis without levels (see prune_levels()) and a threshold
/// that is not a number.
MedialAxis pruned(const MedialAxis& axis, double threshold, std::string_view measure = kLambda);
/// The same in the memory of an axis that is not needed any more.
MedialAxis pruned(MedialAxis&& axis, double threshold, std::string_view measure = kLambda);

/// For a sample of the voxel centres of the shape (all of them when few): up to which threshold a ball of the pruning
/// by a measure still contains the centre.
class Reconstruction {
 public:
  static constexpr std::size_t kSamples = 20000;  // a share of 98% is then known to 0.1%
  /// Deterministic; `samples` centres are taken evenly through the shape. Throws Error(usage) when a vertex of the axis
  /// has no radius or no level.
  Reconstruction(const VoxelShape& shape, const MedialAxis& axis, std::size_t samples = kSamples,
                 Context* context = nullptr, std::string_view measure = kLambda);
  /// Share of the sampled centres inside the union of the balls of { level >= threshold }; in [0, 1].
  double share(double threshold) const;

 private:
  std::vector<double> covered_until_;  // sorted: largest threshold at which each centre is still covered
};

/// The automatic lambda: the largest of 0.02*side / sqrt(2)^k not below half the smallest spacing, then 0, at which
/// share(lambda) >= 0.98. Throws Error(usage) unless the spacing is above 0 and both are finite.
double auto_lambda(const Reconstruction& reconstruction, double longest_side, double smallest_spacing);

/// The medial axis of a shape in one call: voxel_core(), add_detail(), prune_levels() and pruned() at `detail` (world
/// units; none: auto_detail()). Larger details can still be applied with pruned(..., kDetail). Throws what these throw.
MedialAxis medial_axis(const VoxelShape& shape, std::optional<double> detail = {}, Context* context = nullptr);
/// The same, fitted to the surface that the shape is a digitization of: add_detail() and fit_to_surface() with it.
MedialAxis medial_axis(const VoxelShape& shape, const Surface& surface, std::optional<double> detail = {},
                       Context* context = nullptr);

/// The sites around each vertex of a pruning: where its ball touches the staircase.
struct ContactSites {
  std::vector<std::uint32_t> offsets{0};  ///< vertices + 1, into `rows`
  std::vector<std::uint32_t> rows;        ///< of `sites`, for each vertex ascending
  std::vector<LatticePoint> sites;        ///< those that are referred to, in order of z, y, x
};

/// Those of the vertices that pruned(axis, threshold, measure) keeps, in their order: the sites of all faces of `axis`
/// around them. O(faces). Throws as pruned() does.
ContactSites contact_sites(const MedialAxis& axis, double threshold, std::string_view measure);

/// What fit_to_surface() did, in vertices.
struct SurfaceFit {
  std::size_t moved = 0;
  std::size_t outside = 0;                 ///< no place inside the surface within reach: radius 0
  double mean_move = 0, largest_move = 0;  ///< of all vertices, world units
};

/// Moves the vertices of a pruned voxel core to where a ball touches the surface at the places their sites stand for,
/// by at most kLargestMove voxels (of the longest spacing), and makes their radii the distances to the surface, so that
/// every ball lies in the solid and touches its boundary. The complex stays. Where moving would turn a face over, its
/// corners stay where they were. Points and radii as they were become voxel_points and voxel_radius.
///
/// Per vertex, the ball that touches the surface at all contacts y_i is found by Gauss and Newton's method: with n_i
/// from the centre to y_i, the distances |y_i - x| - n_i . dx are made equal by a damped least-squares move dx, and
/// contacts are looked for again from half way to them. Double precision; the result does not depend on threads.
/// O(vertices * log triangles) in practice. Throws Error(usage) unless there are sites for each vertex.
SurfaceFit fit_to_surface(MedialAxis& axis, const ContactSites& contacts, const Surface& surface,
                          Context* context = nullptr);
inline constexpr double kLargestMove = 1.5;

/// A mask that somebody else owns: byte (x, y, z) is `strides[0]*x + strides[1]*y + strides[2]*z` after `data`.
struct MaskView {
  std::array<std::int64_t, 3> dims{0, 0, 0};
  std::array<std::int64_t, 3> strides{0, 0, 0};
  std::uint8_t* data = nullptr;
};

/// Sets the voxels a complex runs through to 1: those of its isolated vertices, and of samples of its edges and
/// polygons no further than a third of a voxel apart, so that what is connected is 26-connected. Voxels of a complex
/// inside a voxel shape are voxels of the shape. What is outside the mask is left out. `grid` places voxels; its dims
/// are not looked at. Throws Error(usage) for a vertex more than 2^21 voxels away.
void mark_cells(const CellComplex& complex, std::span<const Vec3> points, const Grid& grid, const MaskView& mask,
                Context* context = nullptr);

/// Sets the voxels whose centres lie in a ball to 1. O(sum of squared radii in voxels), in parallel; deterministic.
/// Balls whose centre or radius is no number have no voxels.
void mark_balls(std::span<const Vec3> centres, std::span<const double> radius, const Grid& grid, const MaskView& mask,
                Context* context = nullptr);

/// The part of a shape that is at least so wide: its voxels whose centres lie in a ball of the axis of at least this
/// diameter (the opening of the shape by such balls, up to what was pruned). A byte per voxel of the box of the shape.
VoxelShape wide_part(const VoxelShape& shape, const MedialAxis& axis, double width, Context* context = nullptr);

/// Takes out of the data of a medial axis the field arrays that a number or a name would be taken from but that hold
/// something else (an omega that is infinite, a spacing of two numbers), each with a note that names `file` and the
/// field.
void drop_unusable_fields(Record& data, const std::string& file, Context* context = nullptr);

}  // namespace quench
