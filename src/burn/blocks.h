// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burn/window_queue.h"
#include "quench/burn.h"

namespace quench::burning {

/// Parts space along a Z-order curve into blocks of about `states` states each (as few as 2^16 blocks allow), an edge's
/// with those of its first vertex. O(vertices + edges).
Blocks make_blocks(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
                   std::uint64_t states);

}  // namespace quench::burning
