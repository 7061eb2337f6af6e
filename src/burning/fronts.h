// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/fire.h"
#include "burning/polygon_view.h"

namespace quench::burning {

/// A front that enters a polygon through part of a segment of one of its sides. In the frame of the side (x along it
/// from its node 0, y into the polygon): the source lies at (x, -depth), the window on y = 0.
struct Front {
  double x, depth, time;
  double from, to;
};

/// The edge of what a segment's front lights, seen from one of its two nodes: the direction in which the front passes
/// through the node. Nothing is known of it while the neighbour has not burned.
struct Ray {
  bool known = false;
  double x = 0, y = 0;
};

/// What enters polygon f through the segment of a side between two burned neighbours: at most two fronts, and the rays
/// at its two nodes.
struct SegmentFronts {
  int count = 0;
  Front front[2];
  double start = 0;  ///< where there are fronts: the earlier time of the two nodes
  Ray left, right;   ///< at the node of smaller and of larger k
};

/// What the segment between nodes `k` and `k + 1` of a side sends into the polygon; both must have burned. With the
/// field of a node's source (its time plus the distance to it): a. both nodes were reached through this polygon:
/// nothing; b. both sources are known: one of them where its field gives the time of the other node, too, else both,
/// each on the
///    part where its field is smaller; what came through the polygon is not sent back;
/// c. one node is a vertex of the mesh, which has no source: that of the other, on the whole segment where its field
///    gives the vertex' time, else on the part that it reaches before the vertex does;
/// d. otherwise, or on what c leaves: the source that both times agree with; none where fire runs along the side.
SegmentFronts segment_fronts(const Site& site, const Labels& labels, const PolygonView& view, std::uint32_t side,
                             std::uint32_t k, double tolerance);

}  // namespace quench::burning
