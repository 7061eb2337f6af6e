// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelization/surface_edges.h"

namespace quench::voxelization {

/// Faces whose winding number is meaningful, and what was done to get them.
struct RepairedSurface {
  std::vector<Triangle> faces;          ///< welded
  std::int64_t duplicate_faces = 0;     ///< left out: of the same three corners, in either orientation
  std::int64_t flipped_faces = 0;       ///< reoriented, to agree with the faces around them
  std::int64_t filled_holes = 0;        ///< small ones, closed by a fan
  std::int64_t flipped_components = 0;  ///< nearly closed parts turned around as a whole (their faces are counted too)
};

/// Duplicates are left out, patches (faces connected by edges of exactly two faces) oriented consistently:
///   - of faces that are there in both orientations, one or none, whichever leaves fewer edges with an odd number of
///   faces;
///   - a patch keeps the orientation of most of its area. Where less than 70 % agree, it is ignored: the patch is
///     turned outward, or inward where it lies inside an odd number of others (a cavity);
///   - a nearly closed patch that faces the other way than the whole is turned, unless it may be a cavity: inside the
///   box of another one.
/// Holes of at most a 32nd of the longest side (from 1 to 16 voxels), with few edges and in a patch of many faces, are
/// closed by a fan: there may be very many of them, each would cost time all along its scanlines, and where one face is
/// missing the fan is that face. Other holes stay: the winding number closes them. O(n log n), about 100 bytes per
/// face.
RepairedSurface repair_orientation(std::span<const FixedPoint> points, std::span<const Triangle> welded);

}  // namespace quench::voxelization
