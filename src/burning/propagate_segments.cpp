// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "burning/burn_pass.h"
#include "burning/fronts.h"
#include "burning/polygon_view.h"

namespace quench::burning {
namespace {

// The frame of a side: x along it from its node 0, y into the polygon, whose cycle is counterclockwise.
struct Frame {
  Point origin, along;

  explicit Frame(const Polygons::Side& side) : origin{side.x, side.y} {
    const double length = std::sqrt(side.dx * side.dx + side.dy * side.dy);
    along = {side.dx / length, side.dy / length};
  }
  double x(const Point& p) const { return (p.x - origin.x) * along.x + (p.y - origin.y) * along.y; }
  double y(const Point& p) const { return (p.y - origin.y) * along.x - (p.x - origin.x) * along.y; }
  Point world(double along_side, double inward) const {
    return {origin.x + along_side * along.x - inward * along.y, origin.y + along_side * along.y + inward * along.x};
  }
};

// A linear function of the index of a node on its side, as its coordinates in the frame of another side are.
struct Linear {
  double at0, step;
};

// Whether f(k) > 0 for all k in [0, beyond]: a test without division that is enough for most sides.
bool is_positive(const Linear& f, double beyond) { return f.at0 > 0 && f.at0 > -f.step * beyond; }

// The range of integers k in [low, high] with f(k) <= 0, kept in low and high as real numbers.
void clip(const Linear& f, double& low, double& high) {
  if (f.step > 0) {
    high = std::min(high, -f.at0 / f.step);
  } else if (f.step < 0) {
    low = std::max(low, -f.at0 / f.step);
  } else if (f.at0 > 0) {
    high = -1;
  }
}

// Integers k in [first, last], first >= 1.
struct Range {
  std::uint32_t first, last;
  bool is_empty() const { return first > last; }
};
constexpr Range kEmpty{1, 0};

// max(range.first, ceil(low)) and min(range.last, floor(high)) for low >= 0. Plain conversions: without SSE 4.1 ceil
// and floor are long.
Range within(const Range& range, double low, double high) {
  Range result = range;
  if (!(low <= range.last) || !(high >= range.first)) return kEmpty;
  if (low > range.first) {
    result.first = static_cast<std::uint32_t>(low);
    result.first += result.first < low;
  }
  if (high < range.last) result.last = static_cast<std::uint32_t>(high);
  return result;
}
// max(range.first, ceil(low) - 1) and min(range.last, floor(high) + 1) for low >= 0.
Range around(const Range& range, double low, double high) {
  Range result = range;
  if (!(low <= range.last + 1.0) || !(high >= range.first - 1.0)) return kEmpty;
  if (low > range.first + 1.0) {
    result.first = static_cast<std::uint32_t>(low);
    result.first -= !(result.first < low);
  }
  if (high < range.last - 1.0) result.last = static_cast<std::uint32_t>(high) + 1;
  return result;
}

class Segments {
 public:
  Segments(const BurnDomain& domain, Labels& labels, Labels::Worker& worker, double far)
      : domain_(domain), labels_(labels), worker_(worker), far_(far) {}

  void burn(std::uint32_t state, bool again) {
    for_each_place(domain_, state,
                   [&](const PolygonView& view, const Place& place) { enter(view, state, place, again); });
  }

 private:
  void enter(const PolygonView& view, std::uint32_t state, const Place& place, bool again) {
    const double t = labels_.time(state);
    const Point here = view.at(place.side, place.k);
    for_each_edge_arc(view, place, [&](std::uint32_t i, std::uint32_t k) {
      const Polygons::Side& on = view.side(i);
      lower(view, i, k, view.state(i, k), t + on.spacing(), here, t, on.sectors > 1 ? view.face : kNone);
    });
    if (!view.flat) {
      node_arcs(view, place, t, {}, {});
      return;
    }
    const bool came_through_here = !place.is_corner() && labels_.through(state) == view.face;
    // The segments on both sides of the node; they send fronts if the neighbour has burned.
    const std::uint32_t before = place.is_corner() ? view.before(place.side) : place.side;
    const std::uint32_t k_before = (place.is_corner() ? view.side(before).pieces : place.k) - 1;
    SegmentFronts next, previous;
    const bool has_next = segment(view, place.side, place.k, place.k + 1, next);
    const bool has_previous = segment(view, before, k_before, k_before, previous);
    if (!came_through_here) {
      if (place.is_corner()) {
        node_arcs(view, place, t, {}, {});
      } else {
        node_arcs(view, place, t, has_previous ? previous.right : Ray{}, has_next ? next.left : Ray{});
      }
    }
    if (!again) return;
    // The node has burned before: the rays of its neighbours have changed.
    if (has_next && place.k + 1 < view.side(place.side).pieces) fan(view, place.side, place.k + 1);
    if (has_previous && k_before > 0) fan(view, before, k_before);
  }

  // Sends the fronts of the segment from node k to k + 1 if `neighbour`, one of the two, has burned; else returns
  // false.
  bool segment(const PolygonView& view, std::uint32_t i, std::uint32_t k, std::uint32_t neighbour,
               SegmentFronts& fronts) {
    if (!labels_.is_burned(view.state(i, neighbour))) return false;
    fronts = segment_fronts(domain_, labels_, view, i, k, far_);
    if (fronts.count == 0) return true;
    const double start = fronts.start;
    for (int front = 0; front < fronts.count; ++front) send(view, i, fronts.front[front], start);
    return true;
  }

  // Sends the node arcs of an inserted node that has burned: those between the rays of its two segments.
  void fan(const PolygonView& view, std::uint32_t i, std::uint32_t k) {
    const std::uint32_t state = view.state(i, k);
    if (labels_.through(state) == view.face) return;
    Ray rays[2];
    if (labels_.is_burned(view.state(i, k - 1))) rays[0] = segment_fronts(domain_, labels_, view, i, k - 1, far_).right;
    if (labels_.is_burned(view.state(i, k + 1))) rays[1] = segment_fronts(domain_, labels_, view, i, k, far_).left;
    node_arcs(view, {i, k}, labels_.time(state), rays[0], rays[1]);
  }

  // Sends fire along straight arcs from a node to the far sides; where rays of its segments are known, only to the
  // nodes between them and one more on either side.
  void node_arcs(const PolygonView& view, const Place& place, double t, const Ray& left, const Ray& right) {
    const Point here = view.at(place.side, place.k);
    const auto send_to = [&](std::uint32_t i, const Range& range) {
      view.nodes(i, range.first, range.last, [&](std::uint32_t k, std::uint32_t target) {
        if (labels_.time(target) > t) lower(view, i, k, target, t + distance(view.at(i, k), here), here, t, view.face);
      });
    };
    if (!left.known && !right.known) {
      for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
        send_to(i, {first, last});
      });
      return;
    }
    const Frame frame(view.side(place.side));
    for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
      const Polygons::Side& far = view.side(i);
      const double x = (far.x - here.x) * frame.along.x + (far.y - here.y) * frame.along.y,
                   y = (far.y - here.y) * frame.along.x - (far.x - here.x) * frame.along.y,
                   dx = far.dx * frame.along.x + far.dy * frame.along.y,
                   dy = far.dy * frame.along.x - far.dx * frame.along.y;
      const Linear beside_left{left.x * y - left.y * x, left.x * dy - left.y * dx},
          beside_right{right.y * x - right.x * y, right.y * dx - right.x * dy};
      const double beyond = last + 2.0;
      if ((left.known && is_positive(beside_left, beyond)) || (right.known && is_positive(beside_right, beyond)))
        return;
      double low = 0, high = far.pieces;
      if (left.known) clip(beside_left, low, high);
      if (right.known) clip(beside_right, low, high);
      const Range range = around({first, last}, low, high);
      if (!range.is_empty()) send_to(i, range);
    });
  }

  // Sends a front from a side to all nodes that it reaches in a straight line.
  void send(const PolygonView& view, std::uint32_t from_side, const Front& front, double start) {
    const Frame frame(view.side(from_side));
    const Point source = frame.world(front.x, -front.depth);
    for_each_far_side(view, {from_side, 1}, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
      // A node (x, y) is reached if it lies between the rays of the front: two conditions linear in k.
      const Polygons::Side& far = view.side(i);
      const double x = (far.x - source.x) * frame.along.x + (far.y - source.y) * frame.along.y,
                   y = (far.y - source.y) * frame.along.x - (far.x - source.x) * frame.along.y,
                   dx = far.dx * frame.along.x + far.dy * frame.along.y,
                   dy = far.dy * frame.along.x - far.dx * frame.along.y;
      const Linear before{front.from * y - front.rise * x, front.from * dy - front.rise * dx},
          after{front.rise * x - front.to * y, front.rise * dx - front.to * dy};
      const double beyond = last + 1.0;
      if (is_positive(before, beyond) || is_positive(after, beyond)) return;
      double low = 0, high = far.pieces;
      clip(before, low, high);
      clip(after, low, high);
      const Range range = within({first, last}, low - 1e-9, high + 1e-9);
      if (range.is_empty()) return;
      view.nodes(i, range.first, range.last, [&](std::uint32_t k, std::uint32_t target) {
        if (!(labels_.time(target) > start)) return;
        // Fire that crosses the segment between its nodes can be earlier than at both, but one of them is the parent.
        const double t = std::max(front.time + distance(view.at(i, k), source), start);
        lower(view, i, k, target, t, source, front.time, view.face);
      });
    });
  }

  void lower(const PolygonView& view, std::uint32_t i, std::uint32_t k, std::uint32_t state, double t,
             const Point& source, double source_time, std::uint32_t through) {
    if (!(t < labels_.time(state))) return;
    const Polygons::Side& side = view.side(i);
    if (!view.flat) {
      labels_.lower(worker_, state, t, through, kUnknownSource);
    } else if (k == 0 || k == side.pieces) {
      labels_.lower(worker_, state, t, through, at_vertex(view, k == 0 ? i : view.after(i), source, source_time));
    } else {
      const Frame frame(side);
      const double x = frame.x(source);
      labels_.lower(worker_, state, t, through,
                    {side.forward ? x : side.length - x, std::abs(frame.y(source)), source_time});
    }
  }

  // A source as seen from the vertex at which a side starts. It is seen through the polygon.
  Source at_vertex(const PolygonView& view, std::uint32_t i, const Point& source, double source_time) const {
    const Polygons::Side& side = view.side(i);
    const double x = source.x - side.x, y = source.y - side.y;
    const auto& corner = labels_.angles().corners[view.corner(i)];
    const double angle = std::abs(corner.before - corner.side);
    double turned = std::atan2(side.dx * y - side.dy * x, side.dx * x + side.dy * y);
    if (turned < 0.5 * angle - std::numbers::pi) turned += 2 * std::numbers::pi;
    turned = std::clamp(turned, 0.0, angle);
    return {corner.before > corner.side ? corner.side + turned : corner.side - turned, std::sqrt(x * x + y * y),
            source_time};
  }

  const BurnDomain& domain_;
  Labels& labels_;
  Labels::Worker& worker_;
  double far_;
};

}  // namespace

void propagate_by_segments(const BurnDomain& domain, Labels& labels, Context* context) {
  double farthest = 0;  // at least half the diameter of the points
  for (const Vec3& p : domain.points) farthest = std::max(farthest, (p - domain.points[0]).norm());
  const double states = domain.network.state_count();
  labels.burn(
      [&](Labels::Worker& worker) {
        Segments segments(domain, labels, worker, 1e7 * farthest);
        std::uint32_t state = 0;
        for (bool again = false; labels.next(worker, state, again);) segments.burn(state, again);
      },
      [&](std::uint64_t burned) {
        checkpoint(context, "burn", std::min(0.8, 0.6 * static_cast<double>(burned) / states));
      });
}

}  // namespace quench::burning
