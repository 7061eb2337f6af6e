// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "quench/axis.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/shape.h"
#include "quench/surface.h"

namespace quench {

/// What of an axis makes a solid.
enum class EnvelopeKind {
  balls,  ///< the balls of its vertices
  full    ///< and all that lie linearly between them: cones along edges, slabs over triangles (the enveloping volume of
          ///< Li et al. 2015); polygons are fans of triangles from their corner of the smallest index
};

/// The solid of a medial axis: the union of its balls and, where it is full, of the cones and slabs between them.
/// Copies share it. Balls of radius 0 are points.
class Envelope {
 public:
  /// A ball of the solid.
  struct Ball {
    double distance = std::numeric_limits<double>::infinity();  ///< of a point from its surface, negative inside
    Vec3 centre = Vec3::Zero();
    double radius = 0;
    std::uint32_t element = kNone;          ///< that it lies in; none: nothing is near enough
    std::array<double, 3> weight{0, 0, 0};  ///< of the corners of the element
  };
  /// Rows of the vertices that a ball, cone or slab lies between; kNone behind the last one.
  using Corners = std::array<std::uint32_t, 3>;

  /// A voxel core is taken as it was fitted. O(n log n), on all threads; about 280 bytes per element. Throws
  /// Error(input) for an axis without vertices or with a place or radius that is no number, negative or too large.
  explicit Envelope(const MedialAxis& axis, EnvelopeKind kind = EnvelopeKind::full, Context* context = nullptr);

  EnvelopeKind kind() const;
  /// The elements: triangles, then edges without faces, then vertices without edges; of `balls` the vertices.
  std::size_t size() const;
  Corners corners(std::size_t element) const;
  /// The balls of the vertices.
  const std::vector<Vec3>& centres() const;
  const std::vector<double>& radii() const;
  /// The box around all of it.
  const Vec3& low() const;
  const Vec3& high() const;
  double largest_radius() const;

  /// The ball that a point is least outside of, if by less than `within`: its `distance` is that of the point from the
  /// solid where it lies outside of it. Inside it is less than 0, and the point lies at least that deep below the
  /// boundary: just so deep where a ball, cone or slab alone is near; deeper where the nearest place of the boundary is
  /// a crease between several. Closed formulas in double precision (docs/algorithms/envelope.md); O(log n) in practice.
  /// The distance does not depend on the order of the cells. With `enough`, it may be any ball that the point is not
  /// more than that outside of.
  Ball nearest(const Vec3& p, double within = std::numeric_limits<double>::infinity(),
               double enough = -std::numeric_limits<double>::infinity()) const;
  double distance(const Vec3& p) const { return nearest(p).distance; }
  /// Whether a point lies in a ball of the solid, radii taken 1e-9 longer, so that places on a boundary are in. Faster
  /// than distance().
  bool contains(const Vec3& p) const;

 private:
  struct Parts;
  std::shared_ptr<const Parts> parts_;
};

/// A grid of cubes with an empty layer around the envelope, its first voxel in the corner of the least coordinates.
/// Throws Error(usage) unless the spacing is a number above 0 that gives at most 16384 voxels along an axis.
Grid grid_around(const Envelope& envelope, double spacing);
/// A grid with layers of the same voxels added where the envelope does not lie in it with an empty layer around, so
/// that place and size of its voxels stay. In a plane in x and y only.
Grid grown_around(const Envelope& envelope, const Grid& grid);

/// The voxels (pixels) whose centres the envelope contains(), each decided on its own; those of an envelope in another
/// place are cut off at the grid. Boxes of voxels that one ball holds, or none meets, are decided at once: distances
/// change no faster than places do. O(voxels at the boundary * log n), on all threads; does not depend on their number.
VoxelShape voxels_of(const Envelope& envelope, const Grid& grid, Context* context = nullptr);

/// The boundary of the envelope as a closed manifold of triangles, faces outward, that has the topology of its voxels
/// and each of their centres on its side: marching cubes (Lorensen and Cline 1987) with the loops of the voxels, on the
/// distances of the centres; 0 to 1/100 voxel from the boundary where that is smooth. `voxels`: voxels_of() it, in a
/// grid of three dimensions. In world coordinates. About 30 bytes per voxel near the boundary besides the mesh.
TriangleMesh mesh_of(const Envelope& envelope, const VoxelShape& voxels, Context* context = nullptr);

/// Distances of many places, in world units.
struct DistanceFigures {
  double mean = 0, p99 = 0, largest = 0;
};

/// How far places of one boundary lie from the other solid.
struct OneSidedDistances {
  DistanceFigures outside;  ///< of the solid: 0 in it
  DistanceFigures either;   ///< of its boundary, on both sides
  std::size_t places = 0;
};

/// Of the surface from an envelope: `outside` what the envelope misses; `either` takes the depth as Envelope::nearest()
/// knows it. `places` points, as many for the same area everywhere; `largest` is that of the corners of the triangles,
/// too. Deterministic. O(places * log n), on all threads.
OneSidedDistances distances_from_envelope(const Surface& surface, const Envelope& envelope, std::size_t places = 100000,
                                          Context* context = nullptr);

/// Of an envelope from a surface: `outside` what sticks out of the solid. Places of its boundary are found where lines
/// between the centres of neighbouring voxels cross it, to 1e-6 of a voxel, each weighted by the area it stands for
/// (Crofton); `outside.largest` is also that of the far ends of the balls of all vertices. `voxels`: voxels_of() it,
/// in a grid around it that is fine enough to show what is of interest; at most about `places` of their crossings are
/// taken. Deterministic, on all threads.
OneSidedDistances distances_from_surface(const Envelope& envelope, const VoxelShape& voxels, const Surface& surface,
                                         std::size_t places = 100000, Context* context = nullptr);

/// The boundary of a voxel shape as a surface: the faces of its voxels that have no neighbour, in two triangles each.
/// Not for planes.
Surface surface_of_voxels(const VoxelShape& shape, Context* context = nullptr);

/// Volumes (in a plane areas), in world units.
struct VolumeErrors {
  double shape = 0, envelope = 0;
  double missing = 0;  ///< of the shape, not in the envelope
  double added = 0;    ///< of the envelope, not in the shape
};
/// Of voxels; both grids are parts of one lattice, as grown_around() makes them. Throws Error(usage) otherwise.
VolumeErrors volume_errors(const VoxelShape& envelope, const VoxelShape& shape);

}  // namespace quench
