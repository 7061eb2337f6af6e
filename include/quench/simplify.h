// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "quench/axis.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/surface.h"

namespace quench {

/// A medial mesh: an axis of triangles, edges, points and radii only. Its volume is that of its envelope: balls, cones
/// between the ends of edges, slabs between the corners of triangles.
///
/// The axis as a medial mesh. Polygons become fans of triangles, or triangles around a new vertex where a diagonal is
/// an edge already: a simplicial complex of the same homotopy type. Vertices keep their numbers, new ones follow; what
/// else the axis has is left out. O(n). Throws Error(usage) unless there is a radius per vertex, none of them negative.
MedialAxis medial_mesh_of(const MedialAxis& axis);

/// A step of a simplification.
struct Collapse {
  std::uint32_t kept = kNone;
  std::uint32_t removed = kNone;  ///< becomes one with `kept`; none: `kept` moves, and nothing is removed
  Vec3 point = Vec3::Zero();      ///< of `kept`, from now on
  double radius = 0;
};

/// Medial meshes of every number of vertices, each made of the one before by a step.
struct CollapseSequence {
  MedialAxis start;  ///< a medial mesh
  std::vector<Collapse> steps;

  std::size_t most() const { return start.complex.vertex_count; }
  /// Vertices after the last step.
  std::size_t least() const;
  /// The mesh of so many vertices, or the nearest number there is: after all steps before the one that would take away
  /// one more. Vertices are those left of `start`, in their order. O(size of `start`).
  MedialAxis at(std::size_t vertices) const;
  /// The same sequence from at(vertices) on.
  CollapseSequence from(std::size_t vertices) const;
};

/// Points of the boundary that an envelope should run through, and how much of it each stands for.
struct BoundaryPoints {
  std::vector<Vec3> points;
  std::vector<double> areas;
};

/// Corners of the triangles and, where these are large, points inside them: about `count` or all corners.
BoundaryPoints boundary_points(const Surface& surface, std::size_t count);
/// About `count` boundary vertices of a voxel shape, evenly chosen.
BoundaryPoints boundary_points(const VoxelShape& shape, std::size_t count);
/// Where balls of a medial mesh touch its own envelope: for axes of which nothing else is known.
BoundaryPoints boundary_points(const MedialAxis& mesh, std::size_t count);

struct SimplifyOptions {
  std::size_t vertices = 200;        ///< to stop at, or where the topology does not allow another collapse
  std::optional<double> error = {};  ///< instead: the fewest vertices whose largest error is no larger, world units
  int fits = 12;  ///< rounds of fitting the vertices that are left; 0: they stay where collapses put them
};

/// How far an envelope is from a boundary, in world units: distances of boundary points to the surface of the envelope.
struct SimplifyErrors {
  double mean = 0, percentile99 = 0, largest = 0;
};

struct Simplified {
  MedialAxis axis;            ///< a medial mesh, fitted
  SimplifyErrors errors;      ///< of all boundary points
  CollapseSequence sequence;  ///< from the axis to the fewest vertices its topology allows
};

/// An axis of few vertices whose envelope stays near the boundary. Edges are collapsed in the order of a quadric error
/// (the slabs and cones of the axis as planes in the space of centres and radii), as long as the link condition holds,
/// so that every mesh of the sequence has the homotopy type of the axis (docs/algorithms/simplification.md). Then
/// centres and radii are moved, by Gauss and Newton's method, to where the envelope runs through the boundary points.
///
/// Deterministic; does not depend on threads. O(n log n). Throws Error(usage) for an axis without radii or of the
/// plane, and when no number of vertices has `error`.
Simplified simplify(const MedialAxis& axis, const BoundaryPoints& boundary, const SimplifyOptions& options = {},
                    Context* context = nullptr);

/// Moves vertices so that sheets and curves run smoothly, and radii with them: each towards the mean of its
/// neighbours, of those on the same rim, seam or curve where it is on one; ends and junctions stay. No vertex moves,
/// and no radius changes, by more than `most`. The complex stays. Points and radii of the axis are replaced.
/// Throws Error(usage) unless there is a radius per vertex and `most` is a number of 0 or more.
void smooth(MedialAxis& axis, double most, int iterations = 10, Context* context = nullptr);

}  // namespace quench
