// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/network.h"
#include "burning/window_queue.h"

namespace quench::burning {

/// Divides space along a Z-order curve into blocks of about `states` states each, or of more where that would make more
/// than 2^15 blocks. The states of an edge belong to the block of its first vertex. O(vertices + edges).
Blocks make_blocks(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
                   std::uint64_t states);

}  // namespace quench::burning
