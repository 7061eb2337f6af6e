// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench::burning {

/// The complex with each polygon for which cut[f] is set in triangles: ears are cut off, the one with the shortest
/// diagonal first. Its edges are those of the complex, then the diagonals; its polygons are in the same order. So
/// sectors, and nodes inside edges, keep their numbers. O(n^3) in the sides of a polygon.
CellComplex with_flat_faces(const CellComplex& complex, std::span<const Vec3> points, std::span<const char> cut);

}  // namespace quench::burning
