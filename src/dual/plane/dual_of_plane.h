// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dual/dual_complex.h"
#include "quench/context.h"
#include "quench/shape.h"

namespace quench::dual::plane {

/// The dual complex of the sites of a pixel shape. Vertices are sorted by their site lists, edges by their ends: the
/// numbering depends on the complex alone. `sites`: boundary_vertices() of the shape, in order of y, x; `spacing`:
/// integer_spacing() of its grid. O(n log n) in the worst case, about linear for most shapes; 120 bytes per site.
/// Throws Error(failed) when indices outgrow 32 bits.
DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, Context* context);

}  // namespace quench::dual::plane
