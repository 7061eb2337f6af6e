// SPDX-License-Identifier: Apache-2.0
#include "burning/fronts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace quench::burning {
namespace {

// The label of a node in the frame of a side of the polygon.
struct End {
  double at, time;                // position on the side, burn time
  bool vertex = false;            // it is a vertex of the complex
  bool known = false;             // its source is known: the point (x, +-y), at source_time
  bool from_inside = false;       // its front came through this polygon
  std::uint32_t through = kNone;  // on a seam: the polygon through which its front came
  double x = 0, y = 0, source_time = 0;
  double field(double p) const { return source_time + std::sqrt((p - x) * (p - x) + y * y); }
};

// On a seam: the polygon in which fire came that goes on in a vertex state that was opened by another; else kNone.
std::uint32_t through_of(const BurnDomain& domain, std::uint32_t edge, std::uint32_t v, std::uint32_t opener) {
  if (opener == kNone) return kNone;
  for (const std::uint32_t c : domain.network.face_corners_at(edge))
    if (domain.network.corner_state[domain.complex.face_vertices[c] == v ? c : domain.corner_after(c)] == opener)
      return domain.network.corner_face[c];
  return kNone;
}

End vertex_end(const BurnDomain& domain, const Labels& labels, const PolygonView& view, std::uint32_t i, bool first) {
  const Polygons::Side& side = view.side(i);
  const std::uint32_t corner = first ? i : view.after(i), state = view.side(corner).corner_state;
  End end{.at = first ? 0 : side.length, .time = labels.time(state), .vertex = true};
  const Seen seen = labels.seen_along(state, view.corner(corner), first);
  if (std::isnan(seen.time)) return end;
  end.known = true;
  if (side.sectors > 1)
    end.through = through_of(domain, side.edge, domain.links.vertex_of[state], labels.opened_by(state));
  const double angle = std::min(seen.inside, seen.outside);
  if (angle < std::numbers::pi) {
    end.from_inside = seen.inside < seen.outside;
    end.x = end.at + (first ? 1 : -1) * seen.distance * std::cos(angle);
    end.y = seen.distance * std::sin(angle);
    end.source_time = seen.time;
  } else {  // in the shadow of the vertex
    end.x = end.at;
    end.source_time = end.time;
  }
  return end;
}

End end_of(const BurnDomain& domain, const Labels& labels, const PolygonView& view, std::uint32_t i, std::uint32_t k) {
  const Polygons::Side& side = view.side(i);
  if (k == 0 || k == side.pieces) return vertex_end(domain, labels, view, i, k == 0);
  const std::uint32_t state = view.state(i, k);
  const Source& source = labels.source(state);
  return {.at = side.spacing() * k,
          .time = labels.time(state),
          .known = !std::isnan(source.time),
          .from_inside = labels.through(state) == view.face,
          .through = labels.through(state),
          .x = side.forward ? source.x : side.length - source.x,
          .y = source.y,
          .source_time = source.time};
}

Ray ray(double source_x, double depth, double at) { return {true, at - source_x, depth}; }

class Builder {
 public:
  Builder(const End& left, const End& right, double tolerance) : left_(left), right_(right), tolerance_(tolerance) {
    result_.start = std::min(left.time, right.time);
  }

  // Both sources are known. False if their fields do not explain the times.
  bool known_sources(bool one_sheet) {
    // How much later the field of the left node is than that of the right one, at either node.
    const double at_left = left_.time - right_.field(left_.at), at_right = left_.field(right_.at) - right_.time;
    if (one_sheet && std::abs(at_left) <= tolerance_ && std::abs(at_right) <= tolerance_) {
      one_source();
    } else if (one_sheet && at_left <= tolerance_ && at_right >= -tolerance_) {
      two_fronts(equal_at(at_left, at_right));
    } else if (at_left >= -tolerance_ && at_right <= tolerance_) {
      const double cut = equal_at(at_left, at_right);
      two_fronts(cut);
      gap(cut);
    } else {
      const double cut = left_.x + (right_.x - left_.x) * left_.y / (left_.y - right_.y);  // on the line of the sources
      if (!one_sheet || !(cut > left_.at && cut < right_.at) ||
          !(std::abs(left_.field(cut) - right_.field(cut)) <= tolerance_))
        return false;
      two_fronts(cut);
    }
    return true;
  }

  // The source of `other` is known, that of the vertex is not. True if its front takes the whole segment.
  bool beside_unknown(const End& vertex, const End& other) {
    if (other.from_inside) return true;
    const double at_vertex = other.field(vertex.at);
    if (std::abs(at_vertex - vertex.time) <= tolerance_) {
      emit_all(other.x, other.y, other.source_time);
      return true;
    }
    if (at_vertex > vertex.time) beside_vertex(vertex, other);
    return false;
  }

  // The intersection of the circles of radius t1 and t2 about the two nodes, or a plane wave where they do not meet.
  void virtual_source(bool plane, double far) {
    if (left_.from_inside || right_.from_inside) return;
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
    double x = 0, depth = 0, time = 0;
    if (plane || t1 + t2 <= w) {
      const double g = (t2 - t1) / w, h = std::sqrt(1 - g * g);
      x = left_.at - g * far;
      depth = h * far;
      time = t1 - far;
    } else {
      const double u = (t1 * t1 - t2 * t2 + w * w) / (2 * w);
      x = left_.at + u;
      depth = std::sqrt(std::max(0.0, t1 * t1 - u * u));
    }
    const Ray left = result_.left, right = result_.right;
    emit_all(x, depth, time);
    if (rays) return;
    result_.left = left;
    result_.right = right;
  }

  const SegmentFronts& result() const { return result_; }

 private:
  void emit(const Front& front) { result_.front[result_.count++] = front; }
  void emit(const End& of, double from, double to) { emit({of.x, of.y, of.source_time, from - of.x, to - of.x, of.y}); }
  void emit_all(double x, double depth, double time) {
    emit({x, depth, time, left_.at - x, right_.at - x, depth});
    result_.left = ray(x, depth, left_.at);
    result_.right = ray(x, depth, right_.at);
  }

  // Both nodes have the same source: take that of the earlier one.
  void one_source() {
    const End& of = left_.time <= right_.time ? left_ : right_;
    const End& used = of.from_inside ? (&of == &left_ ? right_ : left_) : of;
    emit_all(used.x, used.y, used.source_time);
  }

  // The left front on one side of `cut`, the right one on the other. One that came through the polygon is not sent back
  // into it.
  void two_fronts(double cut) {
    if (!left_.from_inside) {
      emit(left_, left_.at, cut);
      result_.left = ray(left_.x, left_.y, left_.at);
    }
    if (!right_.from_inside) {
      emit(right_, cut, right_.at);
      result_.right = ray(right_.x, right_.y, right_.at);
    }
  }

  // Between the two fronts that part at `cut`.
  void gap(double cut) {
    if (left_.from_inside || right_.from_inside) return;
    emit({cut, 0, left_.field(cut), (cut - left_.x) * right_.y, (cut - right_.x) * left_.y, left_.y * right_.y});
  }

  // Where the two fields are equal, from their differences at the nodes: by the method of false position (Illinois).
  double equal_at(double at_left, double at_right) const {
    double a = left_.at, b = right_.at, ga = at_left, gb = at_right;
    if (!(ga * gb < 0)) return std::abs(ga) < std::abs(gb) ? a : b;
    double c = a;
    for (int step = 0; step < 4; ++step) {
      c = (a * gb - b * ga) / (gb - ga);
      const double gc = left_.field(c) - right_.field(c);
      if (std::abs(gc) <= 0.01 * tolerance_) break;
      if (gc * gb < 0) {
        a = b;
        ga = gb;
      } else {
        ga *= 0.5;
      }
      b = c;
      gb = gc;
    }
    return std::clamp(c, left_.at, right_.at);
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

  const End &left_, &right_;
  double tolerance_;
  SegmentFronts result_;
};

}  // namespace

SegmentFronts segment_fronts(const BurnDomain& domain, const Labels& labels, const PolygonView& view, std::uint32_t i,
                             std::uint32_t k, double far) {
  const Polygons::Side& side = view.side(i);
  const End left = end_of(domain, labels, view, i, k), right = end_of(domain, labels, view, i, k + 1);
  if (left.from_inside && right.from_inside) return {};  // a
  Builder build(left, right, 2 * labels.tolerance());
  if (left.known && right.known) {  // b
    // On a seam two fronts meet only if they came from the same sheet, or one of them from this one.
    const bool one_sheet = side.sectors <= 1 || left.through == right.through || left.from_inside || right.from_inside;
    if (build.known_sources(one_sheet)) return build.result();
  } else if ((left.vertex && right.known) || (right.vertex && left.known)) {  // c
    if (build.beside_unknown(left.known ? right : left, left.known ? left : right)) return build.result();
  }
  // d. A free edge whose radius is not the distance to one point sends plane waves.
  bool plane = false;
  if (domain.network.degree(side.edge) == 1) {
    const auto [a, b] = domain.complex.edges[side.edge];
    const double r0 = domain.radius[a], r1 = domain.radius[b];
    plane = !is_distance_to_point(r0, r1, side.length, domain.rule);
  }
  build.virtual_source(plane, far);
  return build.result();
}

}  // namespace quench::burning
