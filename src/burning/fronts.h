// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/labels.h"
#include "burning/polygon_view.h"

namespace quench::burning {

/// A front that enters a polygon through one of its sides. In the frame of the side (x along it from its node 0, y into
/// the polygon), the source lies at (x, -depth), and what it reaches lies between two rays from it, in the directions
/// (from, rise) and (to, rise).
struct Front {
  double x, depth, time;
  double from, to, rise;
};

/// The direction, seen from one of the two nodes of a segment, in which the segment's front passes through the node:
/// the boundary of what the front reaches. Unknown while the neighbour has not burned.
struct Ray {
  bool known = false;
  double x = 0, y = 0;
};

/// What enters a polygon through the segment of a side between two burned neighbours: at most three fronts, and the
/// rays at its two nodes.
struct SegmentFronts {
  int count = 0;
  Front front[3];
  double start = 0;  ///< where there are fronts: the earlier time of the two nodes
  Ray left, right;   ///< at the node of smaller and of larger k
};

/// What the segment between nodes `k` and `k + 1` of a side sends into the polygon of the view. Both nodes must have
/// burned. The *field* of a node is that of its source: the source's time plus the distance to it. Four cases (figure
/// in docs/algorithms/burning.md):
///   a. fire came to both nodes through this polygon: nothing;
///   b. both sources are known: one front where the field of each node gives the time of the other, too; else two. They
///      meet where their fields are equal if each node has the earlier field. If each has the later one, the segment
///      crosses the shadow between two fronts that pass a vertex on both sides: they part there, and the gap gets a
///      front from that point. If one field is the earlier at both nodes, the segment crosses the border of its
///      shadow, where the fields touch. A front that came through this polygon is not sent back;
///   c. one node is a vertex whose source is unknown, and that of the other is known: the front of the other, on the
///      whole segment where its field gives the time of the vertex, else on the part that it reaches before fire from
///      the vertex does, and then case d as well;
///   d. otherwise: a virtual source from which fire arrives at both nodes at their times; a plane wave where there is
///   no
///      such point, and on free edges whose radius is not the distance to one point; nothing where fire runs along the
///      side.
/// `far`: the distance at which a source counts as a plane wave.
SegmentFronts segment_fronts(const BurnDomain& domain, const Labels& labels, const PolygonView& view,
                             std::uint32_t side, std::uint32_t k, double far);

}  // namespace quench::burning
