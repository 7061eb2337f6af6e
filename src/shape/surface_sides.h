// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "quench/geometry.h"

namespace quench::shape {

/// Shortens the ways of vertices from a surface of SurfaceLayers, in lattice coordinates, to `moved` such that no
/// triangle passes a voxel centre on its way: every one stays on its side. Ways are shorter than half a voxel along
/// each axis. O(n), on the threads of the arena.
void keep_sides(const TriangleMesh& surface, std::vector<Vec3>& moved);

/// The same such that no triangle turns over.
void keep_faces_up(const TriangleMesh& surface, std::vector<Vec3>& moved);

/// The distance of three points' triangle to the nearest voxel centre around it.
double distance_to_centres(const std::array<Vec3, 3>& triangle);

}  // namespace quench::shape
