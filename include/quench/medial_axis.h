// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/complex.h"
#include "quench/geometry.h"
#include "quench/poly_data.h"

namespace quench {

/// A medial axis: a complex in the world with a radius per vertex. The voxel core fills every member; a foreign medial
/// axis has points, radius and complex only.
///
/// Lengths (radius, lambda, level) are in world units. The level of a cell is the largest pruning threshold it
/// survives: the pruning for lambda is { level >= lambda }; infinite where topology needs the cell at any lambda.
struct MedialAxis {
  CellComplex complex;
  std::vector<Vec3> points;    ///< per vertex
  std::vector<double> radius;  ///< per vertex: distance to its nearest sites

  std::vector<double> vertex_lambda, edge_lambda, face_lambda;  ///< of a face: half the distance of its sites
  std::vector<double> vertex_level, edge_level, face_level;     ///< empty before prune_levels()

  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< the two nearest sites of each face, smaller row first
  std::vector<LatticePoint> sites;                       ///< boundary vertices of the voxel shape that faces refer to
  Grid grid;                                             ///< transform of lattice coordinates
};

/// How an infinite level is written to files: colour ranges of viewers break on inf.
inline constexpr double kInfiniteLevelInFiles = 3.4e38;

/// The axis as cells and arrays for a file: point arrays `radius`, `lambda`, `object_angle`; cell arrays `kind` (0 part
/// of a sheet, 1 curve, 2 point), `component`, `lambda`, `lambda_level`, `object_angle`, `site_a`, `site_b`; field
/// arrays `sites` and the grid. The object angle is that between the directions from the cell's centre to the two
/// nearest boundary points its lambda stands for, in degrees: 2 asin(lambda / radius). A line is written for an edge
/// with no face or with a level above that of its faces, a vertex cell likewise, so that the closure of the cells with
/// lambda_level >= t is the pruning for t, for every t. Throws Error(usage) when lambdas or levels are there for some
/// cells only.
PolyData to_poly_data(const MedialAxis& axis);
/// The same of an axis that is not needed any more and is empty afterwards.
PolyData to_poly_data(MedialAxis&& axis);

/// The closure of the cells of a file as a complex on the points of the file that some cell uses; `point_of[v]` is the
/// row of vertex v. Lines and vertex cells that are part of a larger cell are merged with it.
CellComplex complex_of(const PolyData& data, std::vector<std::uint32_t>* point_of = nullptr);

/// What medial_axis_of() had to mend, in cells of the file.
struct AxisRepair {
  std::size_t degenerate = 0;  ///< polygons or lines that repeat a corner: what is left of them is kept
  std::size_t duplicate = 0;   ///< polygons with the corners of an earlier one: dropped
};

/// A medial axis, ours or foreign, as read from a file: complex, points and radius (of the point array `radius`).
/// Points that no cell uses are isolated vertices. Vertex v is row v of the file. Throws Error(input) when there is no
/// radius.
MedialAxis medial_axis_of(const PolyData& data, AxisRepair* repair = nullptr);

}  // namespace quench
