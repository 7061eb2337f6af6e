// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "quench/complex.h"
#include "quench/voxel_shape.h"

namespace quench {

/// Euler characteristic and Betti numbers (components, independent loops, cavities), over Z/2.
struct Topology {
  std::int64_t euler = 0;
  std::array<std::int64_t, 3> betti{0, 0, 0};
  friend bool operator==(const Topology&, const Topology&) = default;
};

/// Topology of the open voxel shape: euler = voxels - face-adjacent pairs + full 2x2 squares - full 2x2x2 cubes;
/// b0 = 6-connected components; b2 = 26-connected components of the complement - 1. O(runs log runs), exact.
Topology topology(const VoxelShape& shape);

/// Topology of a closed complex: euler = V - E + F; b2 = dimension of the Z/2 2-cycles, computed on what is left after
/// collapsing free faces. Near-linear unless closed pockets share many non-manifold edges.
Topology topology(const CellComplex& complex);

}  // namespace quench
