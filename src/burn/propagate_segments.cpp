// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "burn/fire.h"
#include "burn/fronts.h"
#include "burn/places.h"

namespace quench::burning {
namespace {

// Positions along and into a polygon from one of its sides.
struct Frame {
  Vec3 origin, along, inward;

  explicit Frame(const Side& side) : origin(side.start) {
    const double length = (side.step * side.pieces).norm();
    along = side.step * (side.pieces / length);
    // The polygons' planes run counterclockwise around their corners.
    inward = {-along[1], along[0], 0};
  }
  double x(const Vec3& p) const { return (p - origin).dot(along); }
  double y(const Vec3& p) const { return (p - origin).dot(inward); }
};

// The range of integers k in [low, high] with a + k b <= 0, kept in low and high as real numbers.
void clip(double a, double b, double& low, double& high) {
  if (b > 0) {
    high = std::min(high, -a / b);
  } else if (b < 0) {
    low = std::max(low, -a / b);
  } else if (a > 0) {
    high = -1;
  }
}

class Segments {
 public:
  Segments(const Site& site, Labels& labels, double tolerance)
      : site_(site), labels_(labels), tolerance_(tolerance), views_(site) {}

  void burn(std::uint32_t state, bool again) {
    for_each_place(site_, state, views_,
                   [&](const PolygonView& view, const Place& place) { enter(view, state, place, again); });
  }

 private:
  void enter(const PolygonView& view, std::uint32_t state, const Place& place, bool again) {
    const double t = labels_.time(state);
    const Side& side = view.sides[place.side];
    const Vec3 here = side.at(place.k);
    for_each_edge_arc(view, place, [&](const Side& on, std::uint32_t k) {
      lower(view, on, k, t + on.spacing(), here, t, on.stride > 1 ? view.face : kNone);
    });
    if (!view.flat) {
      node_arcs(view, place, t, {}, {});
      return;
    }
    const bool came_through_here = !place.is_corner() && labels_.through(state) == view.face;
    // The segments on either side of the node, each with a neighbour that may have burned.
    const Side& before = place.is_corner() ? view.sides[view.side_before(place.side)] : side;
    const std::uint32_t k_before = place.is_corner() ? before.pieces - 1 : place.k - 1;
    SegmentFronts next, previous;
    const bool has_next = segment(view, side, place.k, place.k + 1, next);
    const bool has_previous = segment(view, before, k_before, k_before, previous);
    if (!came_through_here) {
      if (place.is_corner()) {
        node_arcs(view, place, t, {}, {});
      } else {
        node_arcs(view, place, t, has_previous ? previous.right : Ray{}, has_next ? next.left : Ray{});
      }
    }
    if (!again) return;
    // Burned once more: the neighbours' fans have changed.
    if (has_next && place.k + 1 < side.pieces) fan(view, side, place.k + 1);
    if (has_previous && k_before > 0) fan(view, before, k_before);
  }

  // The segment from node k on, if its other node `neighbour` has burned: sends its fronts.
  bool segment(const PolygonView& view, const Side& side, std::uint32_t k, std::uint32_t neighbour,
               SegmentFronts& fronts) {
    if (!labels_.is_burned(side.state(neighbour))) return false;
    fronts = segment_fronts(site_, labels_, view, side, k, tolerance_);
    const double start = std::min(labels_.time(side.state(k)), labels_.time(side.state(k + 1)));
    for (int i = 0; i < fronts.count; ++i) send(view, side, fronts.front[i], start);
    return true;
  }

  // Node arcs of an inserted node that has burned, between its two segments.
  void fan(const PolygonView& view, const Side& side, std::uint32_t k) {
    const std::uint32_t state = side.state(k);
    if (labels_.through(state) == view.face) return;
    Ray rays[2];
    if (labels_.is_burned(side.state(k - 1)))
      rays[0] = segment_fronts(site_, labels_, view, side, k - 1, tolerance_).right;
    if (labels_.is_burned(side.state(k + 1))) rays[1] = segment_fronts(site_, labels_, view, side, k, tolerance_).left;
    node_arcs(view, {static_cast<std::uint32_t>(&side - view.sides.data()), k}, labels_.time(state), rays[0], rays[1]);
  }

  // Fire along straight arcs to the far sides; only between the rays of the segments beside the node, and one node more
  // on either side.
  void node_arcs(const PolygonView& view, const Place& place, double t, const Ray& left, const Ray& right) {
    const Side& side = view.sides[place.side];
    const Vec3 here = side.at(place.k);
    const bool clipped = left.known || right.known;
    const Frame frame = clipped ? Frame(side) : Frame(view.sides[0]);
    for_each_far_side(view, place, [&](const Side& far, std::uint32_t first, std::uint32_t last) {
      double low = first, high = last;
      if (clipped) {
        const Vec3 from = far.start - here;
        const double x = from.dot(frame.along), y = from.dot(frame.inward), dx = far.step.dot(frame.along),
                     dy = far.step.dot(frame.inward);
        low = 0;
        high = far.pieces;
        if (left.known) clip(left.x * y - left.y * x, left.x * dy - left.y * dx, low, high);
        if (right.known) clip(right.y * x - right.x * y, right.y * dx - right.x * dy, low, high);
        low = std::max<double>(first, std::ceil(low) - 1);
        high = std::min<double>(last, std::floor(high) + 1);
      }
      if (!(low <= high)) return;
      for (auto k = static_cast<std::uint32_t>(low); k <= static_cast<std::uint32_t>(high); ++k)
        lower(view, far, k, t + (far.at(k) - here).norm(), here, t, view.face);
    });
  }

  // A front through a window of a side, to all nodes it reaches in a straight line.
  void send(const PolygonView& view, const Side& side, const Front& front, double start) {
    const Frame frame(side);
    const Vec3 source = frame.origin + frame.along * front.x - frame.inward * front.depth;
    const double from = front.from - front.x, to = front.to - front.x;
    for_each_far_side(view, {static_cast<std::uint32_t>(&side - view.sides.data()), 1},
                      [&](const Side& far, std::uint32_t first, std::uint32_t last) {
                        // A node (x, y) is lit when its line to the source crosses the window: linear in k.
                        const Vec3 d = far.start - source;
                        const double x = d.dot(frame.along), y = d.dot(frame.inward), dx = far.step.dot(frame.along),
                                     dy = far.step.dot(frame.inward);
                        double low = 0, high = far.pieces;
                        clip(from * y - front.depth * x, from * dy - front.depth * dx, low, high);
                        clip(front.depth * x - to * y, front.depth * dx - to * dy, low, high);
                        low = std::max<double>(first, std::ceil(low - 1e-9));
                        high = std::min<double>(last, std::floor(high + 1e-9));
                        if (!(low <= high)) return;
                        for (auto k = static_cast<std::uint32_t>(low); k <= static_cast<std::uint32_t>(high); ++k) {
                          const double t = front.time + (far.at(k) - source).norm();
                          if (t >= start) lower(view, far, k, t, source, front.time, view.face);
                        }
                      });
  }

  void lower(const PolygonView& view, const Side& side, std::uint32_t k, double t, const Vec3& source,
             double source_time, std::uint32_t through) {
    const std::uint32_t state = side.state(k);
    if (!(t < labels_.time(state))) return;
    if (k == 0 || k == side.pieces || !view.flat) {
      labels_.lower(state, t, through, kUnknownSource);
      return;
    }
    const Frame frame(side);
    const double x = frame.x(source);
    labels_.lower(state, t, through, {side.forward ? x : side.length - x, std::abs(frame.y(source)), source_time});
  }

  const Site& site_;
  Labels& labels_;
  double tolerance_;
  PolygonViews views_;
};

}  // namespace

void propagate_by_segments(const Site& site, Labels& labels, double tolerance, Context* context) {
  Segments segments(site, labels, tolerance);
  std::uint32_t state = 0;
  bool again = false;
  const double states = site.network.state_count();
  for (std::uint64_t burned = 0; labels.next(state, again);) {
    if (burned++ % 4096 == 0) checkpoint(context, "burn", std::min(0.8, 0.6 * static_cast<double>(burned) / states));
    segments.burn(state, again);
  }
}

}  // namespace quench::burning
