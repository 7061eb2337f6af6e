// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench::parts {

/// The faces of a complex in triangles.
struct Triangulation {
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< face by face, each the way round its face goes
  std::vector<std::uint32_t> face;                      ///< of each triangle
  std::vector<std::uint32_t> middle_of;  ///< vertex complex.vertex_count + i is the mean of the corners of this face
};

/// Triangles whose sides are those of the faces, and diagonals that no edge of the complex and no other face has: so
/// together they are a simplicial complex with the underlying space of the faces. Ears are cut off, the one with the
/// largest of the least angles first; where there is none that folds nothing, all corners are joined with a new vertex.
/// O(n k^3) for faces of k corners, in practice O(n k^2).
Triangulation triangulated(const CellComplex& complex, std::span<const Vec3> points);

}  // namespace quench::parts
