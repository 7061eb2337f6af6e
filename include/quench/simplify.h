// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "quench/axis.h"
#include "quench/context.h"
#include "quench/envelope.h"
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

/// Points of the boundary that an envelope should run through, and how much of it each stands for. Those that stand for
/// an area of 0 are only looked at for the largest error.
struct BoundaryPoints {
  std::vector<Vec3> points;
  std::vector<double> areas;
};

/// `count` points of a surface, as many for the same area everywhere, and the corners of its triangles, for an area of
/// 0.
BoundaryPoints boundary_points(const Surface& surface, std::size_t count = 100000);
/// All boundary vertices of a voxel shape, of which about `count` stand for an area.
BoundaryPoints boundary_points(const VoxelShape& shape, std::size_t count = 100000);
/// About `count` points, less what some cells cover of others, of the envelope of an axis itself: where nothing else is
/// known of the shape. Throws what medial_mesh_of() throws.
BoundaryPoints boundary_points(const MedialAxis& axis, std::size_t count = 100000, Context* context = nullptr);

/// How far boundary points lie from the envelope of a medial mesh, as distances_from_envelope(); means and percentiles
/// are by area. O(points * log n), on all threads.
OneSidedDistances errors_of(const MedialAxis& mesh, const BoundaryPoints& boundary, Context* context = nullptr);

struct SimplifyOptions {
  std::size_t vertices = 200;  ///< to stop at, or where the topology does not allow another collapse
  /// Instead, the fewest vertices found at which no boundary point lies farther outside of the envelope or deeper in a
  /// ball, cone or slab of it, in world units: the largest `either` of errors_of().
  std::optional<double> error = {};
  int fits = 12;  ///< rounds of fitting the vertices that are left
};

struct Simplified {
  MedialAxis axis;            ///< a medial mesh, fitted
  OneSidedDistances errors;   ///< errors_of() it
  CollapseSequence sequence;  ///< from the axis to the fewest vertices its topology allows; not fitted at the end
};

/// An axis of few vertices whose envelope stays near a boundary. Edges are collapsed, cheapest first, as long as the
/// link condition holds, so that every mesh of the sequence has the homotopy type of the axis. The cost of a collapse
/// is the sum of squared distances of the new ball from planes that the old ones touch, a quadric of its centre and
/// radius (Thiery et al. 2013, Li et al. 2015): first those of the envelope of the axis, from 1024 vertices on those at
/// the boundary points. At each half of them, and at the end, all balls are moved to where the envelope runs through
/// the boundary points (docs/algorithms/simplification.md).
///
/// Deterministic; does not depend on threads. O(n log n); 2 s for 100,000 triangles. The sequence is the same for all
/// options. Throws Error(usage) for an axis without radii or of the plane, and, field `error`, where the axis itself
/// does not meet it.
Simplified simplify(const MedialAxis& axis, const BoundaryPoints& boundary, const SimplifyOptions& options = {},
                    Context* context = nullptr);

/// The mesh of the sequence with so many vertices, fitted as simplify() does at the end.
MedialAxis fitted_level(const CollapseSequence& sequence, std::size_t vertices, const BoundaryPoints& boundary,
                        int fits = SimplifyOptions{}.fits, Context* context = nullptr);

/// A fitted mesh of a sequence, and how far the boundary is from its envelope.
struct SimplifiedLevel {
  std::size_t vertices = 0, edges = 0, triangles = 0;
  OneSidedDistances errors;
};
/// Those of 1000, 500, 250, ... vertices that the sequence has, down to the fewest, each fitted_level().
std::vector<SimplifiedLevel> errors_of_levels(const CollapseSequence& sequence, const BoundaryPoints& boundary,
                                              int fits = SimplifyOptions{}.fits, Context* context = nullptr);

/// The memory that simplify() takes besides what it is given and returns, in bytes.
std::int64_t predicted_simplify_bytes(const CellComplex& complex);

/// Moves vertices so that sheets and curves run smoothly, and radii with them: each towards the mean of its
/// neighbours, of those on the same rim, seam or curve where it is on one; ends and junctions stay. No vertex moves,
/// and no radius changes, by more than `most`. The complex stays. Points and radii of the axis are replaced.
/// Throws Error(usage) unless there is a radius per vertex and `most` is a number of 0 or more.
void smooth(MedialAxis& axis, double most, int iterations = 10, Context* context = nullptr);

}  // namespace quench
