// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench::verification {

/// Of the solid that a closed surface bounds, its triangles facing outward: parts that enclose a positive volume bound
/// components, the others cavities, and chi is half that of the surface. Sheets that touch in vertices count as
/// separate. Nothing where an edge has not two triangles of opposite directions. O(n log n).
std::optional<Topology> solid_topology(const TriangleMesh& surface);

}  // namespace quench::verification
