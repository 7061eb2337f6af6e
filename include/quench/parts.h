// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "quench/axis.h"
#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"
#include "quench/skeleton.h"
#include "quench/structure.h"
#include "quench/table.h"

/// @file
/// The parts of a medial axis or a skeleton by name: sheets, the seams along which they meet, and the junctions of
/// these; what is measured of each; and every sheet as a mesh (docs/algorithms/parts.md).
namespace quench {

/// What parts are measured on. The radius along a triangle is linear.
struct PartsOptions {
  /// Added to every radius: half a voxel where the radii are distances to the corners of voxels, else 0.
  double more_radius = 0;
};

/// A sheet: faces joined over edges that no other face has.
struct Sheet {
  std::size_t faces = 0;
  std::int32_t component = 0;  ///< connected component of the complex, numbered by their first vertices
  double area = 0;             ///< of its triangles, as in sheet_mesh()
  /// 2 r, weighted by area, over its corners the least and the largest.
  double mean_thickness = 0, min_thickness = 0, max_thickness = 0;
  /// Erosion thickness of its faces, mean by area; NaN where nothing was burned. Infinite where some of it never burns.
  double mean_erosion = std::numeric_limits<double>::quiet_NaN(),
         max_erosion = std::numeric_limits<double>::quiet_NaN();
  double rim_length = 0;      ///< of its edges with no other face
  double seam_length = 0;     ///< of its sides at seams: of a seam that it meets twice, twice
  std::uint32_t borders = 0;  ///< closed curves around it, when it is cut off along its seams; 0: it is closed
  std::int64_t euler = 0;     ///< of the sheet cut off along its seams: 1 of a disk, 0 of a ring, 2 of a sphere
  bool orientable = true;
  /// The plane for which the sum of squared distances of the sheet, by area, is least: through its centre, and across.
  Vec3 centre = Vec3::Zero(), normal = Vec3::UnitZ();
  double flatness = 0;                    ///< root of the mean squared distance to that plane
  double largest_off = 0;                 ///< largest distance of a corner to it
  std::vector<std::uint32_t> seams;       ///< ascending
  std::vector<std::uint32_t> neighbours;  ///< sheets at these seams, ascending; itself where it meets a seam twice
  double boundary_length() const { return rim_length + seam_length; }
};

/// A seam: a line without fork along which three sheets or more meet, or sides of sheets.
struct Seam {
  std::size_t edges = 0;
  double length = 0;
  double mean_thickness = 0, min_thickness = 0, max_thickness = 0;  ///< 2 r, mean by length
  std::vector<std::uint32_t> sheets;  ///< a sheet as often as it meets the seam, at the edge with most; ascending
  std::array<std::uint32_t, 2> ends{kNone, kNone};  ///< junctions (rows of Parts::junctions); none of a closed one
  bool closed = false;
};

/// A vertex where seams meet or end.
struct Junction {
  std::uint32_t vertex = 0;
  Vec3 point = Vec3::Zero();
  double thickness = 0;
  std::vector<std::uint32_t> seams, sheets;  ///< ascending
};

struct Parts {
  Structure structure;  ///< which face, edge and vertex is part of what
  std::vector<Sheet> sheets;
  std::vector<Seam> seams;
  std::vector<Junction> junctions;  ///< in the order of their vertices
  /// Sheets by area, the largest first.
  std::vector<std::uint32_t> by_area() const;
};

/// Parts of a complex; sheets and seams are numbered as by structure_of(). `erosion`: erosion thickness per face, or
/// empty. Deterministic. O(n log n). Throws Error(usage) unless there are a point and a radius per vertex.
Parts parts_of(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
               std::span<const double> erosion = {}, const PartsOptions& options = {}, Context* context = nullptr);
/// The same; the erosion thickness of a face is Skeleton::face_thickness.
Parts parts_of(const Skeleton& skeleton, const PartsOptions& options = {}, Context* context = nullptr);

/// A row per sheet, the largest first. Column `sheet` is its number. `unit` of lengths, may be empty.
Table sheet_table(const Parts& parts, const std::string& unit = {});
/// A row per seam, a row per junction, by their numbers.
Table seam_table(const Parts& parts, const std::string& unit = {});
Table junction_table(const Parts& parts, const std::string& unit = {});

/// All sheets as triangles. Triangles of one sheet share an edge only where no other triangle has it; those of
/// different sheets, or of a sheet that meets itself, share the vertices and edges of seams.
struct SheetMesh {
  std::vector<Vec3> points;
  std::vector<double> radius;                           ///< per point
  std::vector<double> erosion;                          ///< per point, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< of a sheet that is orientable all one way round
  std::vector<std::int32_t> sheet;                      ///< per triangle: row of Parts::sheets
  std::vector<std::array<std::uint32_t, 2>> seam_edges;
  std::vector<std::int32_t> seam;    ///< per seam edge: row of Parts::seams
  std::vector<std::uint32_t> fixed;  ///< points that remeshing leaves where they are: junctions, where curves begin
};

/// The faces of a complex, triangulated: by diagonals that are no edges, and around a new point in the middle where
/// there are none that fold nothing. Points that no face has are left out; new points have values in between. Sheets
/// look along their Sheet::normal. `erosion`: per vertex, or empty. O(n log n).
SheetMesh sheet_mesh(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                     std::span<const double> erosion, const Parts& parts, Context* context = nullptr);
SheetMesh sheet_mesh(const Skeleton& skeleton, const Parts& parts, Context* context = nullptr);

struct RemeshOptions {
  double length = 0;  ///< of edges, above 0
  int rounds = 6;     ///< of splitting, collapsing, flipping and evening out
};
/// The same sheets with triangles whose sides are about `length` long, where a sheet has room for them. Sheets, seams,
/// junctions and how they meet stay: the complex is homeomorphic to what it was, part by part. Seams are common to their
/// sheets. Points lie on the sheet or the seam that they are of; rims become smooth over `length`, by no more than half
/// of it and half the radius there. Values are those at the nearest place.
/// Botsch and Kobbelt (2004, A remeshing approach to multiresolution modeling) on complexes, with the conditions of Dey,
/// Edelsbrunner, Guha and Nekhayev (1999, Topology preserving edge contraction); docs/algorithms/parts.md.
/// Deterministic. O(n log n) in practice. Throws Error(usage) for a length that is not above 0.
SheetMesh remeshed(const SheetMesh& mesh, const RemeshOptions& options, Context* context = nullptr);

/// Every sheet by itself, cut off along its seams: a manifold with boundary. Point arrays `radius`, `thickness` (2 (r +
/// more_radius)), where known `erosion_thickness`, and `point`: the row of to_record() that it is, by which sheets are
/// sewn together. One record per row of Parts::sheets. O(n log n).
std::vector<Record> sheet_records(const SheetMesh& mesh, const PartsOptions& options = {});
/// All of them with common seams: the same point arrays; cell arrays `sheet` (-1 of seams) and `seam` (-1 of sheets);
/// seams are lines. A group per sheet in OBJ files.
Record to_record(const SheetMesh& mesh, const PartsOptions& options = {});

}  // namespace quench
