// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "quench/polygons.h"

namespace quench::polygons {

/// Parts and holes of a region.
struct RegionTopology {
  std::int64_t components = 0, holes = 0;
};

/// The topology of a region whose rings neither cross nor touch themselves or each other, by a sweep over the plane
/// (Shamos and Hoey 1976) with exact predicates. Nothing for other rings: what is inside then depends on crossings that
/// no ring has as a point. Coordinates are finite and below 2^150. O(n log n).
std::optional<RegionTopology> region_topology(const Polygons& polygons, PolygonFill fill);

/// Tells the caller when the pixel shape of a region has another topology, and that is cheap to know.
void note_other_topology(const Polygons& polygons, const VoxelShape& shape, PolygonFill fill, Context* context);

}  // namespace quench::polygons
