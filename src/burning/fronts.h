// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/labels.h"
#include "burning/polygon_view.h"

namespace quench::burning {

/// A front that enters a polygon through part of a segment of one of its sides. In the frame of the side (x along it
/// from its node 0, y into the polygon), the source lies at (x, -depth) and the part is [from, to] on y = 0.
struct Front {
  double x, depth, time;
  double from, to;
};

/// The direction, seen from one of the two nodes of a segment, in which the segment's front passes through the node:
/// the boundary of what the front reaches. Unknown while the neighbour has not burned.
struct Ray {
  bool known = false;
  double x = 0, y = 0;
};

/// What enters a polygon through the segment of a side between two burned neighbours: at most two fronts, and the rays
/// at its two nodes.
struct SegmentFronts {
  int count = 0;
  Front front[2];
  double start = 0;  ///< where there are fronts: the earlier time of the two nodes
  Ray left, right;   ///< at the node of smaller and of larger k
};

/// What the segment between nodes `k` and `k + 1` of a side sends into the polygon of the view. Both nodes must have
/// burned. The *field* of a node is that of its source: the source's time plus the distance to it. Four cases (figure
/// in docs/algorithms/burning.md):
///   a. both nodes were reached through this polygon: nothing;
///   b. both sources are known: one front where the field of each node gives the time of the other, too; else two, each
///      on the part where its field is smaller; a front that came through this polygon is not sent back;
///   c. one node is a vertex of the complex, and the source of the other is known: the front of the other, on the whole
///      segment where its field gives the time of the vertex, else on the part that it reaches before fire from the
///      vertex does, and then case d as well;
///   d. otherwise: a virtual source from which fire arrives at both nodes at their times; a plane wave where there is
///   no
///      such point, and on free edges whose radius is not the distance to one point; nothing where fire runs along the
///      side.
/// `far`: the distance at which a source counts as a plane wave.
SegmentFronts segment_fronts(const BurnDomain& domain, const Labels& labels, const PolygonView& view,
                             std::uint32_t side, std::uint32_t k, double far);

}  // namespace quench::burning
