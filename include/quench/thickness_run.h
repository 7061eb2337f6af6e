// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/context.h"
#include "quench/pipeline.h"
#include "quench/thickness.h"

/// @file
/// Local thickness of an input: its whole core, its distribution as tables, the thickness of its surface.
namespace quench::pipeline {

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
};

/// By the core of the shape, pruned by its automatic detail and fitted to the surface where there is one. `tolerance`:
/// none: auto_detail(), which is what the steps of voxels stick out. LoadedShape::mesh is used where it was kept, else
/// LoadedShape::surface, else the surface half way between voxels inside and outside.
MeasuredSurface measured_surface(const LoadedShape& shape, std::optional<double> tolerance = {},
                                 Context* context = nullptr);

/// The surface as a file: the point arrays `thickness` and `across_x`, `across_y`, `across_z` (where the ball touches
/// the other side), the cell array `thickness`.
Record surface_file(const MeasuredSurface& surface);

/// A row of a distribution: what it is of, number (or area), mean, sd, min, p1, p5, p10, p25, median, p75, p90, p95,
/// p99, max. The columns are lengths of `coordinates`.
Table summary_of(const ThicknessDistribution& distribution, const Coordinates& coordinates);
/// A row per bin from the first to the last that is not empty: from, to, weight, share, and the share up to `to`.
Table histogram_of(const ThicknessDistribution& distribution, const Coordinates& coordinates);

}  // namespace quench::pipeline
