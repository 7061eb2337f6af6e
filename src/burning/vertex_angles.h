// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/domain.h"

namespace quench::burning {

/// Directions at the vertices. The polygons of a sector lie around its vertex like the pages of a fan; a direction in
/// it is an angle, counted along the sector from its first side. So a source beyond a vertex is known in all polygons
/// of the sector, not only in the one through which its fire came.
struct VertexAngles {
  struct Corner {
    double side, before;  ///< directions of the side that starts at the corner, and of the side that ends there
  };
  struct Sector {
    double angle;                         ///< the whole angle
    std::uint32_t first_edge, last_edge;  ///< the first and last side of an open one; kNone if closed around the vertex
    bool is_closed() const { return first_edge == kNone; }
  };
  HugeVector<Corner> corners;   ///< per corner
  std::vector<Sector> sectors;  ///< per vertex state
};

VertexAngles make_vertex_angles(const BurnDomain& domain);

/// How far a direction is turned away from a side of a corner: through the corner's polygon, and the other way round.
/// Infinite where the sector ends in between.
struct Turned {
  double inside, outside;
};

}  // namespace quench::burning
