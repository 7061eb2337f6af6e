// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench::burning {

/// The complex with each polygon for which cut[f] is set in triangles: ears are cut off, the one with the shortest
/// diagonal first. Its edges are those of the complex, then the diagonals; its polygons are in the same order. So
/// sectors, and nodes inside edges, keep their numbers. O(n^3) in the sides of a polygon.
CellComplex with_flat_faces(const CellComplex& complex, std::span<const Vec3> points, std::span<const char> cut);

/// The polygons with more than three sides that are not flat and convex; empty where there are none. There is no one
/// way across them: each surface that they bound has its own. Triangles have one, which comes nearer to that of a
/// curved sheet the smaller they are; projections on planes do not.
std::vector<char> faces_to_cut(const CellComplex& complex, std::span<const Vec3> points);

}  // namespace quench::burning
