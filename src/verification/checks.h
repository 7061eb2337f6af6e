// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "verification/nearest_sites.h"
#include "verification/plane_boundary.h"
#include "verification/polytope.h"
#include "verification/result.h"
#include "verification/triangle_search.h"

namespace quench::verification {

/// Relative error of numbers that some files store in single precision.
inline constexpr double kSingle = 1e-6;

/// Of a length, and of omega: fire does not correct times that are late by less than 0.002 of omega, and rounds them to
/// a 4096th of it.
inline constexpr double kOffAlongEdges = 0.01, kOffByLabels = 0.003;

/// Why a check of the voxel core's geometry does not apply.
inline constexpr const char* kNotOfVoxels =
    "the points are fitted to a surface, the file does not hold the voxel core's";

/// Why it is not known which cells a pruning by detail of a fitted result must have.
inline constexpr const char* kBorneOutBySurface =
    "which cells of the voxel core the surface bears out is not decided again";

/// No two cells are the same, none is degenerate; polygons are plane and convex.
Check check_cells(const Result& result);

/// Euler characteristic and Betti numbers of the result are those of the shape. Says those of the solid of the surface,
/// too, where there is one. `boundary`: in the plane, that of the shape.
Check check_topology(const Result& result, const TriangleMesh* surface, const BoundaryCurves* boundary);

/// Every cell lies in the open shape.
Check check_enclosure(const Result& result, Context* context);

/// The arrays `lambda` against LambdaOfSites.
Check check_lambda(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                   Context* context);

/// No simple pair below lambda is left, and every core cell of at least lambda around the sampled vertices is there.
Check check_pruning(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                    Context* context);

/// The vertices where a cell that was dropped can have been: removing cells without changing the topology leaves an
/// edge in one face only, or the end of a lone edge. All vertices there, and a sample of the others.
std::vector<std::uint32_t> vertices_to_complete(const Result& result, std::size_t samples);

/// Of a core pruned by detail: every core cell around the vertices of vertices_to_complete() that is certain to have a
/// detail of at least the threshold is there.
Check check_detail_pruning(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                           Context* context);
/// The arrays `detail`: by the cap heights of the file where it has all the cells that a value depends on, elsewhere
/// bounds.
Check check_details(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context);
/// The distance of the boundary vertices, all of them, to the balls of the file, and of its prunings for some larger
/// details, against what is promised; the array `coverage`.
Check check_coverage(const Result& result, const Sites& sites, Context* context);

/// In the plane: the arrays `mgf`, by ways along the boundary.
Check check_mgf(const Result& result, const Sites& sites, VertexSites& vertex_sites, const BoundaryCurves& boundary,
                Context* context);
/// In the plane: burn times and erosion thickness, of a core by a fire that is burned here.
Check check_burning_of_plane(const Result& result);
/// In the plane: levels and thickness of the cells of a skeleton: bounds, and what holds in every skeleton.
Check check_skeleton_levels_of_plane(const Result& result);
/// Whether the file says that it is of the plane exactly when the shape is, and has no polygons and no point off the
/// plane then.
Check check_dimension(const Result& result);

/// Height of the cap that a chord of length 2 lambda cuts off a ball.
double cap_height(double lambda, double radius);
/// The arrays `cap_height`: of all polygons by their two sites, of a sample by sites that are found here.
Check check_cap_heights(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                        Context* context);

/// Why a line or point has a smaller value of a measure than a polygon or line at it, or nothing. Those that are gone
/// may have had more.
std::string below_cells_around(const Result& result, const std::string& measure, const std::vector<double>& of_points,
                               const std::vector<double>& of_cells, double rounding, Context* context);
/// A check for each of the measures circumradius, scale axis, chord residual and erosion thickness of the core that a
/// core has arrays of.
std::vector<Check> check_other_measures(const Result& result, const Sites& sites, const VerifyOptions& options,
                                        Context* context);

/// Of a fitted result: how far its points are from those of the voxel core.
Check check_moves(const Result& result);
/// Of a fitted result: every ball lies inside the surface and touches it.
Check check_balls(const Result& result, const TriangleSearch& surface, const VerifyOptions& options, Context* context);
/// That the surface is one of the shape: voxel centres at its boundary are on the side that the shape says.
Check check_sides(const Result& result, const TriangleSearch& surface, const VerifyOptions& options, Context* context);

/// That the surface of a grey-value image is where its samples, interpolated, are the threshold.
Check check_isosurface(const VoxelShape& shape, const VerifyOptions& options, Context* context);

/// The proximity bound: distance to the true medial axis (docs/user/guarantees.md).
Check check_proximity(const Result& result, std::size_t samples, Context* context);

/// The array `NAME_level` of each measure: that a thinning by simple pairs in the order of their keys can give these
/// levels. A check per measure that has levels; at least one.
std::vector<Check> check_levels(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context);
/// The field arrays `format_version` and `measures`: that the arrays of the measures are there.
Check check_measures(const Result& result);

/// Share of the sampled voxel centres in the balls of the vertices against the array `reconstructed`.
Check check_reconstruction(const Result& result, Context* context);

/// What is wrong with the form of arrays whose names the format defines: text for numbers or the reverse, their number,
/// two arrays of one name, an unknown word. Empty when nothing is.
std::string array_defect(const Record& data);

/// Per vertex the number of its component; components are numbered in the order of their first vertices.
std::vector<std::uint32_t> components(const CellComplex& complex);
/// The arrays `kind` and `component`.
Check check_kinds(const Result& result);
/// Field arrays about the shape: the grid and, where it is given, the longest side; `lambda_chosen`,
/// `detail_chosen`.
Check check_fields(const Result& result, const VerifyOptions& options);
/// The arrays `sites`, `site_a` and `site_b` of all polygons (in the plane lines), and their lambda as half the
/// distance of their two sites.
Check check_sites(const Result& result, const Sites& sites);
/// The arrays `object_angle`.
Check check_angles(const Result& result);
/// Per face: whether it lies in a closed pocket, one of those that are left when faces with a free edge are removed
/// until there is none.
std::vector<char> pocket_faces(const CellComplex& complex);
/// Burn times and erosion thickness of points: relations among them and with the complex.
Check check_burning(const Result& result);
/// The arrays of the burn sequence: with the polygons and links they are about, and with `burn_time`.
Check check_burn_sequence(const Result& result);
bool has_burn_sequence(const Record& data);
/// Per vertex, whether it may lie off the axis in a skeleton: on the way of a branch, or on a sheet that was smoothed.
std::vector<char> smoothed_vertices(const Result& result);
/// Why a free branch should have been pruned, or nothing. `curve_thickness`: per row of cell arrays.
std::string wrong_free_branch(const Result& result, double theta1, const std::vector<double>& curve_thickness);
Check check_branches(const Result& result);
/// Levels and thickness of the cells of a skeleton: bounds, and what holds in every skeleton.
Check check_skeleton_levels(const Result& result);

/// The arrays of the file that none of the checks is about, with the reason.
std::vector<UncheckedArray> unchecked_arrays(const Record& data, const std::vector<Check>& checks);
/// Arrays that a file of its stage should have and this one has not, as in Certificate::absent.
std::vector<std::string> absent_arrays(const Result& result);
/// Of the absent arrays, those without which the file cannot be checked as a result of its stage.
Check check_expected(const Result& result, const VerifyOptions& options);
/// The sentence about arrays that are not checked and arrays that are absent.
Check arrays_left(const std::vector<UncheckedArray>& arrays, const std::vector<std::string>& absent);

}  // namespace quench::verification
