// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "quench/axis.h"
#include "quench/context.h"
#include "quench/envelope.h"
#include "quench/geometry.h"
#include "quench/parts.h"
#include "quench/pipeline.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/simplify.h"
#include "quench/surface.h"
#include "quench/table.h"
#include "quench/thickness.h"

/// @file
/// Stages from a medial axis back to the solid: the local thickness of an input, the solid of an axis, axes of few
/// vertices, the sheets of a skeleton.
namespace quench::pipeline {

// ---------------------------------------------------------------------------------------------------------- thickness


/// The whole voxel core of a shape, or as much of it as local_thickness() needs: points, radii, edges and the grid.
/// Nothing is pruned or fitted. In bricks where memory asks for it. Throws Error(failed), with figures, when there is
/// not enough memory for it and for the slices of the thickness.
MedialAxis whole_core(const LoadedShape& shape, Context* context = nullptr);

/// What is not of a shape in the box of its grid: pores. Throws Error(input) when that is nothing.
LoadedShape complement_of(const LoadedShape& shape);

/// The surface of an input with the thickness at its vertices.
struct MeasuredSurface {
  TriangleMesh mesh;  ///< the mesh of the input with all its vertices, or the surface of the values of a volume
  SurfaceThickness thickness;
  MedialAxis axis;                       ///< whose balls they are, with its levels
  double tolerance = 0, correction = 0;  ///< world units, as of SurfaceThicknessOptions
  ThicknessDistribution distribution;    ///< of triangles by their area: the mean of their corners
  Coordinates coordinates;               ///< of the input
};

/// By the core of the shape, pruned by its automatic detail and fitted to the surface where there is one. `tolerance`:
/// none: auto_detail(), which is what the steps of voxels stick out. LoadedShape::mesh is used where it was kept, else
/// LoadedShape::surface, else the surface half way between voxels inside and outside.
MeasuredSurface measured_surface(const LoadedShape& shape, std::optional<double> tolerance = {},
                                 Context* context = nullptr);

/// The surface as a file: the point arrays `thickness` and `across_x`, `across_y`, `across_z` (where the ball touches
/// the other side), the cell array `thickness`; field arrays `units` and `SPACE` where they are known.
Record surface_file(const MeasuredSurface& surface);

/// A row of a distribution: what it is of, number (or area), mean, sd, min, p1, p5, p10, p25, median, p75, p90, p95,
/// p99, max. The columns are lengths of `coordinates`.
Table summary_of(const ThicknessDistribution& distribution, const Coordinates& coordinates);
/// A row per bin from the first to the last that is not empty: from, to, weight, share, and the share up to `to`.
Table histogram_of(const ThicknessDistribution& distribution, const Coordinates& coordinates);

// -------------------------------------------------------------------------------------------------------------- solid

/// The grid of the shape that an axis is of, where its file says so.
std::optional<Grid> grid_of(const Record& data);

/// How far a solid is from a shape, both ways.
struct SolidErrors {
  SurfaceKind surface = SurfaceKind::voxels;      ///< that distances refer to
  std::optional<OneSidedDistances> from_solid;    ///< of the surface from the solid; not in a plane
  std::optional<OneSidedDistances> from_surface;  ///< of the solid's boundary from the surface; not in a plane
  VolumeErrors volume;                            ///< of voxels
};

/// The solid of an axis.
struct SolidResult {
  Envelope envelope;
  VoxelShape voxels;           ///< of a grid with an empty layer around it
  VoxelShape on_grid;          ///< the same on the grid that was asked for
  std::int64_t cut_off = 0;    ///< voxels that are not on it
  Topology topology;           ///< of `voxels`
  Topology of_axis;            ///< of the axis
  std::optional<SolidErrors> errors;     ///< where a shape is at hand
  std::optional<Surface> surface = {};   ///< that these refer to; not in a plane
};

/// The envelope of an axis, its voxels and, with a shape, its errors: distances refer to the surface of the shape or,
/// where it has none, to the faces of its voxels. `grid`: of `shape`, where it is given. Throws what Envelope,
/// grown_around() and require_memory() throw.
SolidResult solid_of(const MedialAxis& axis, EnvelopeKind kind, const Grid& grid, const LoadedShape* shape = nullptr,
                     Context* context = nullptr);
/// mesh_of() it, with its plan of memory; where there is a surface, with the signed distance from it as point array
/// `distance`, negative inside.
Record mesh_of(const SolidResult& solid, Context* context = nullptr);

// ----------------------------------------------------------------------------------------------------- simplification

/// Points that the envelope of an axis should run through: of the surface of the shape, without one its boundary
/// vertices, without a shape of the envelope that the axis has itself. `what`: "mesh", "grey", "smooth", "voxels" or
/// "envelope".
BoundaryPoints boundary_of(const MedialAxis& axis, const LoadedShape* shape, std::string* what = nullptr,
                           Context* context = nullptr);
/// simplify() with its plan of memory. Throws Error(invariant) when the topology is not that of the axis.
Simplified simplified(const MedialAxis& axis, const BoundaryPoints& boundary, const SimplifyOptions& options = {},
                      Context* context = nullptr);
/// A simplified or smoothed axis as a file: cells and radii, and what the file `from` of its axis says of the shape.
/// `stage`: "simplified" or "smoothed".
Record reshaped_file(const MedialAxis& axis, const Record& from, const std::string& stage);

// -------------------------------------------------------------------------------------------------------------- parts

/// Parts with the mesh of their sheets.
struct PartsRun {
  Parts parts;
  SheetMesh mesh;        ///< of even size, where that was asked for
  PartsOptions options;  ///< they were measured with
};

/// Half a voxel more than the radius, as of measured_graph(), where the axis is that of the voxels; `voxel` as
/// GraphOptions::voxel.
PartsOptions parts_options(const Vec3& voxel);
/// Parts of a skeleton, best with draw_branches(), which makes rims and seams smooth. `remesh`: the length of the sides
/// of triangles. Throws Error(usage), field `remesh`, where it is 0 or infinite; Error(failed), with figures, when there
/// is not enough memory.
PartsRun run_parts(const Skeleton& skeleton, const Vec3& voxel, const std::optional<Length>& remesh, const Scale& scale,
                   Context* context = nullptr);
/// The same of a medial axis or a skeleton as its file has it. Erosion thickness is that of the file, where it has one.
PartsRun run_parts(const LoadedAxis& axis, const std::optional<Length>& remesh, Context* context = nullptr);
/// What a file of parts says beside its cells: stage "parts", what the file `from` says of shape, unit and thresholds.
void add_parts_fields(Record& data, const Record& from);

}  // namespace quench::pipeline
