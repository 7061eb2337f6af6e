// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/window_queue.h"
#include "quench/burn.h"

namespace quench::burning {

/// Parts space along a Z-order curve into blocks of about `states` states each, or more where 2^15 blocks would not do.
/// The states of an edge are of the block of its first vertex. O(vertices + edges).
Blocks make_blocks(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
                   std::uint64_t states);

}  // namespace quench::burning
