// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::delaunay {

/// Order in which sites enter an incremental Delaunay triangulation: random rounds of doubling size, each along a
/// Hilbert curve (Amenta, Choi, Rote 2003). The rounds keep expected cost linear, the curve keeps the walks short. The
/// choice of rounds is a hash of the index: the same for every run.
std::vector<std::uint32_t> insertion_order(std::span<const LatticePoint> sites);

}  // namespace quench::delaunay
