// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "quench/geometry.h"

namespace quench::delaunay {

/// The smallest and the largest coordinates, axis by axis.
using Bounds = std::array<LatticePoint, 2>;

/// Precondition: there is at least one site.
inline Bounds bounds_of(std::span<const LatticePoint> sites) {
  Bounds bounds{sites[0], sites[0]};
  for (const LatticePoint& s : sites)
    for (std::size_t a = 0; a < 3; ++a) {
      bounds[0][a] = std::min(bounds[0][a], s[a]);
      bounds[1][a] = std::max(bounds[1][a], s[a]);
    }
  return bounds;
}

}  // namespace quench::delaunay
