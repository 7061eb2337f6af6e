// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "quench/envelope.h"

namespace quench::envelope {

/// Points of a mesh, as many for the same area everywhere: in the order of the triangles at equal steps of area, within
/// each along the sequence R2 (Roberts 2018).
std::vector<Vec3> places_on(const TriangleMesh& mesh, std::size_t count);

/// A distance, and how much area stands behind it.
struct Weighted {
  double value, weight;
  friend auto operator<=>(const Weighted&, const Weighted&) = default;
};
/// Mean, the value that 99 % of the weight does not exceed, and largest value. Sorts them.
DistanceFigures figures_of(std::vector<Weighted>& values);

}  // namespace quench::envelope
