// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::surface {

/// A convex polygon by its corners, counterclockwise seen from outside.
using Face = std::vector<std::uint32_t>;

/// Triangles of faces of which some were cut without regard to their neighbours: in the result, sides that are at one
/// place are the same. `loose`: points that may be at one place, or on sides of faces. Those at one place become the
/// first of them; where one is on a side it becomes a corner of the face. A face of three corners that none of them
/// is on stays as it is. `near`: what is not farther is at one place. O(n log n).
TriangleMesh conforming(std::vector<Vec3> points, std::span<const Face> faces, std::vector<std::uint32_t> loose,
                        double near);

}  // namespace quench::surface
