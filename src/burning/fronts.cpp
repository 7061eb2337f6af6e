// SPDX-License-Identifier: Apache-2.0
#include "burning/fronts.h"

#include <algorithm>
#include <cmath>

namespace quench::burning {
namespace {

// The label of a node in the frame of a side of the polygon.
struct End {
  double at, time;   // position on the side, burn time
  bool vertex;       // it is a vertex of the complex
  bool known;        // it is an inserted node whose source is known: the point (x, +-y), at source_time
  bool from_inside;  // its front came through this polygon
  std::uint32_t through;
  double x, y, source_time;
  double field(double p) const { return source_time + std::sqrt((p - x) * (p - x) + y * y); }
};

End end_of(const Labels& labels, const PolygonView& view, const Polygons::Side& side, std::uint32_t state, bool vertex,
           double at) {
  End end{};
  end.at = at;
  end.time = labels.time(state);
  end.vertex = vertex;
  end.through = labels.through(state);
  end.from_inside = end.through == view.face;
  if (end.vertex) return end;
  const Source& source = labels.source(state);
  end.known = !std::isnan(source.time);
  end.x = side.forward ? source.x : side.length - source.x;
  end.y = source.y;
  end.source_time = source.time;
  return end;
}

Ray ray(double source_x, double depth, double at) { return {true, at - source_x, depth}; }

class Builder {
 public:
  Builder(const End& left, const End& right) : left_(left), right_(right) {
    result_.start = std::min(left.time, right.time);
  }

  void emit(const End& of, double from, double to) {
    result_.front[result_.count++] = {of.x, of.y, of.source_time, from, to};
  }
  void emit_all(double x, double depth, double time) {
    result_.front[result_.count++] = {x, depth, time, left_.at, right_.at};
    result_.left = ray(x, depth, left_.at);
    result_.right = ray(x, depth, right_.at);
  }

  // Both nodes have the same source: take that of the earlier one.
  void one_source() {
    const End& of = left_.time <= right_.time ? left_ : right_;
    const End& used = of.from_inside ? (&of == &left_ ? right_ : left_) : of;
    emit_all(used.x, used.y, used.source_time);
  }

  // Two fronts meet where their fields are equal. One that came through the polygon is not sent back into it.
  void two_fronts() {
    double a = left_.at, b = right_.at;
    for (int step = 0; step < 10; ++step) {
      const double c = 0.5 * (a + b);
      (left_.field(c) <= right_.field(c) ? a : b) = c;
    }
    const double cut = 0.5 * (a + b);
    if (!left_.from_inside) {
      emit(left_, left_.at, cut);
      result_.left = ray(left_.x, left_.y, left_.at);
    }
    if (!right_.from_inside) {
      emit(right_, cut, right_.at);
      result_.right = ray(right_.x, right_.y, right_.at);
    }
  }

  // A vertex burned before the front of the other node reached it: that front gets the part that it reaches first.
  void beside_vertex(const End& vertex, const End& other) {
    double a = vertex.at, b = other.at;
    for (int step = 0; step < 10; ++step) {
      const double c = 0.5 * (a + b);
      (other.field(c) < vertex.time + std::abs(c - vertex.at) ? b : a) = c;
    }
    const double cut = 0.5 * (a + b);
    emit(other, std::min(cut, other.at), std::max(cut, other.at));
    (other.at > vertex.at ? result_.right : result_.left) = ray(other.x, other.y, other.at);
  }

  // The intersection of the circles of radius t1 and t2 about the two nodes, or a plane wave where they do not meet.
  void virtual_source(bool plane, double far) {
    if (left_.from_inside && !left_.vertex) return;
    if (right_.from_inside && !right_.vertex) return;
    const double w = right_.at - left_.at, t1 = left_.time, t2 = right_.time;
    if (!(w > 0)) return;
    const bool rays = result_.count == 0;
    if (std::abs(t1 - t2) >= w) {  // fire runs along the side
      if (!rays) return;
      if (t1 < t2) {
        result_.right = {true, 1, 0};
      } else {
        result_.left = {true, -1, 0};
      }
      return;
    }
    Front front{0, 0, 0, left_.at, right_.at};
    if (plane || t1 + t2 <= w) {
      const double g = (t2 - t1) / w, h = std::sqrt(1 - g * g);
      front.x = left_.at - g * far;
      front.depth = h * far;
      front.time = t1 - far;
    } else {
      const double u = (t1 * t1 - t2 * t2 + w * w) / (2 * w);
      front.x = left_.at + u;
      front.depth = std::sqrt(std::max(0.0, t1 * t1 - u * u));
    }
    result_.front[result_.count++] = front;
    if (!rays) return;
    result_.left = ray(front.x, front.depth, left_.at);
    result_.right = ray(front.x, front.depth, right_.at);
  }

  const SegmentFronts& result() const { return result_; }

 private:
  const End &left_, &right_;
  SegmentFronts result_;
};

}  // namespace

SegmentFronts segment_fronts(const BurnDomain& domain, const Labels& labels, const PolygonView& view, std::uint32_t i,
                             std::uint32_t k, double far) {
  const Polygons::Side& side = view.side(i);
  const std::uint32_t from = view.state(i, k), to = view.state(i, k + 1);
  if (labels.through(from) == view.face && labels.through(to) == view.face) return {};  // a
  const double w = side.spacing();
  const End left = end_of(labels, view, side, from, k == 0, w * k),
            right = end_of(labels, view, side, to, k + 1 == side.pieces, w * (k + 1));
  Builder build(left, right);

  const double eps = 2 * labels.tolerance();
  // On a seam two fronts can be compared only if they came from the same sheet, or one of them from this one.
  const bool one_sheet = side.sectors <= 1 || left.through == right.through || left.from_inside || right.from_inside;
  if (left.known && right.known && one_sheet) {  // b
    const double at_right = left.field(right.at), at_left = right.field(left.at);
    if (std::abs(at_right - right.time) <= eps && std::abs(at_left - left.time) <= eps) {
      build.one_source();
      return build.result();
    }
    if (at_right >= right.time - eps && at_left >= left.time - eps) {
      build.two_fronts();
      return build.result();
    }
  } else if ((left.vertex && right.known) || (right.vertex && left.known)) {  // c
    const End &vertex = left.vertex ? left : right, &other = left.vertex ? right : left;
    if (other.from_inside) return build.result();
    const double at_vertex = other.field(vertex.at);
    if (std::abs(at_vertex - vertex.time) <= eps) {
      build.emit_all(other.x, other.y, other.source_time);
      return build.result();
    }
    if (at_vertex > vertex.time) build.beside_vertex(vertex, other);
  }
  // d. A free edge whose radius is not the distance to one point sends plane waves.
  bool plane = false;
  if (domain.network.degree(side.edge) == 1) {
    const auto [a, b] = domain.complex.edges[side.edge];
    const double r0 = domain.radius[a], r1 = domain.radius[b];
    plane = domain.rule == RadiusRule::linear || std::abs(r0 - r1) > side.length || side.length > r0 + r1;
  }
  build.virtual_source(plane, far);
  return build.result();
}

}  // namespace quench::burning
