// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "burning/burn_pass.h"
#include "burning/link.h"
#include "burning/source_windows.h"

namespace quench::burning {
namespace {

// Fire that goes from a seam into a polygon, or from the rim; else `through` is the place, among the polygons of its
// edge, of the one that fire came through.
constexpr std::uint32_t kEntering = kNone;

struct PlanePoint {
  double x, y;
};

// A side of a polygon in the polygon's plane: x along the edge from its first vertex, y into the polygon.
struct SideFrame {
  PlanePoint origin, along;
  double length, inward;  // inward: 1 where the edge runs counterclockwise, else -1

  explicit SideFrame(const Polygons::Side& side) {
    const PlanePoint to{side.x + side.dx * side.pieces, side.y + side.dy * side.pieces};
    length = std::hypot(to.x - side.x, to.y - side.y);
    origin = side.forward ? PlanePoint{side.x, side.y} : to;
    inward = side.forward ? 1 : -1;
    const double scale = length > 0 ? inward / length : 0;
    along = {(to.x - side.x) * scale, (to.y - side.y) * scale};
  }
  double x(const PlanePoint& p) const { return (p.x - origin.x) * along.x + (p.y - origin.y) * along.y; }
  double y(const PlanePoint& p) const { return inward * ((p.y - origin.y) * along.x - (p.x - origin.x) * along.y); }
  PlanePoint point(double x, double y) const {
    return {origin.x + x * along.x - y * inward * along.y, origin.y + x * along.y + y * inward * along.x};
  }
};

class WindowFire {
 public:
  WindowFire(const BurnDomain& domain, Context* context) : domain_(domain), context_(context) {
    const auto& edges = domain.links.edges;
    first_list_.resize(edges.size() + 1);
    for (std::size_t e = 0; e < edges.size(); ++e)
      first_list_[e + 1] = first_list_[e] + (edges[e].degree > 2 ? edges[e].degree : edges[e].degree > 0);
    lists_.resize(first_list_.back());
    edge_of_list_.resize(lists_.size());
    double sum = 0;
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
      std::fill(edge_of_list_.begin() + first_list_[e], edge_of_list_.begin() + first_list_[e + 1], e);
      sum += domain.network.length[e];
    }
    margin_ = 1e-9 * sum / static_cast<double>(std::max<std::size_t>(1, edges.size()));
    arrival_.assign(domain.vertex_states(), kNever);
    sent_.assign(domain.vertex_states(), kNever);
    queued_.assign(domain.vertex_states(), kNever);
    pocket_.resize(domain.vertex_states());
    for (std::uint32_t s = 0; s < domain.vertex_states(); ++s) pocket_[s] = domain.in_pocket(s);
  }

  void burn() {
    start();
    std::uint64_t done = 0;
    const double vertices = domain_.complex.vertex_count;  // of 15 to 30 events each
    while (!queue_.empty()) {
      const Event event = queue_.top();
      queue_.pop();
      if ((++done & 0xFFFF) == 0)
        checkpoint(context_, "burn", std::min(0.8, 0.8 * static_cast<double>(done) / (25 * vertices + 1)));
      switch (event.kind) {
        case Kind::window:
          take_window(event);
          break;
        case Kind::vertex:
          take_vertex(event.at, event.time);
          break;
        case Kind::kink:
          take_kink(event.at, event.x, event.time);
          break;
      }
    }
  }

  BurnTimes times() {
    BurnTimes result{Times(domain_.network.state_count(), kNever), std::vector<char>(domain_.network.state_count(), 0)};
    auto& [times, opened] = result;
    for (std::uint32_t v = 0; v < domain_.complex.vertex_count; ++v) {
      const std::uint32_t first = domain_.network.vertex_base[v];
      const auto sectors = times_of(v);
      for (std::uint32_t i = 0; i < sectors.size(); ++i) {
        times[first + i] = not_early(sectors[i].time, domain_.radius[v]);
        opened[first + i] =
            sectors[i].opened_by != kNone && sectors[i].opened_by != i && sectors[i].time < arrival_[first + i];
      }
    }
    for (std::uint32_t e = 0; e < domain_.links.edges.size(); ++e) {
      const Links::Edge& edge = domain_.links.edges[e];
      const double length = domain_.network.length[e];
      for (std::uint32_t k = 1; k < edge.pieces; ++k)
        for (std::uint32_t r = 0; r < edge.sectors(); ++r) {
          if (edge.degree == 1) {  // the rim
            times[edge.state_base + k - 1] = domain_.radius_inside(e, k);
            continue;
          }
          const double x = length * k / edge.pieces;
          const auto* entry = lists_[first_list_[e] + r].at(x, 1e-6 * length);
          if (!entry) continue;
          const std::uint32_t state = edge.state_base + (k - 1) * edge.sectors() + r;
          times[state] = not_early(entry->window.at(x), domain_.radius_inside(e, k));
          opened[state] = edge.degree > 2 && entry->through == kEntering;
        }
    }
    return result;
  }

 private:
  enum class Kind : std::uint8_t { vertex, window, kink };
  struct Event {
    double time;
    Kind kind;
    std::uint32_t at, id;  // a vertex, or a list and the window's id in it
    double x;              // of a kink
    bool operator<(const Event& other) const {
      if (time != other.time) return time > other.time;
      if (kind != other.kind) return kind > other.kind;
      return at != other.at ? at > other.at : id > other.id;
    }
  };

  // No burn time is below the radius, but for rounding, and for radii that are no distances.
  double not_early(double time, double radius) const {
    return domain_.rule == RadiusRule::exact ? std::max(time, radius) : time;
  }
  double narrowest(std::uint32_t e) const { return 1e-9 * domain_.network.length[e]; }
  std::uint32_t list_of(std::uint32_t corner) const {
    const std::uint32_t e = domain_.complex.face_edges[corner];
    return first_list_[e] + (domain_.links.edges[e].degree > 2 ? domain_.network.corner_rank[corner] : 0);
  }
  std::span<const SectorTimes::Time> times_of(std::uint32_t v) {
    const std::uint32_t first = domain_.network.vertex_base[v], count = domain_.network.vertex_base[v + 1] - first;
    return sector_times_(std::span(domain_.links.ends).subspan(first, count), std::span(arrival_).subspan(first, count),
                         std::span<const char>(pocket_).subspan(first, count), domain_.radius[v]);
  }

  // Fire starts on the rim at the time of the radius: it comes from the nearest site, which the ends of an edge share.
  void start() {
    for (std::uint32_t e = 0; e < domain_.links.edges.size(); ++e) {
      if (domain_.network.degree(e) != 1) continue;
      const auto [a, b] = domain_.complex.edges[e];
      const double r0 = domain_.radius[a], r1 = domain_.radius[b], length = domain_.network.length[e];
      if (!(length > 0)) continue;
      SourceWindow window{0, length, 0, 0, 0};
      if (is_distance_to_point(r0, r1, length, domain_.rule)) {
        window.along = (r0 * r0 - r1 * r1 + length * length) / (2 * length);
        window.depth = std::sqrt(std::max(0.0, r0 * r0 - window.along * window.along));
      } else {  // linear: a plane wave, as from far away
        const double far = 1e6 * length, slope = std::clamp((r1 - r0) / length, -1.0, 1.0);
        window.along = 0.5 * length - far * slope;
        window.depth = far * std::sqrt(1 - slope * slope);
        window.time = 0.5 * (r0 + r1) - far;
      }
      add(first_list_[e], window, kEntering, domain_.network.face_corners_at(e)[0]);
    }
    for (std::uint32_t v = 0; v < domain_.complex.vertex_count; ++v) {
      if ((v & 0xFFFF) == 0) checkpoint(context_, "burn", 0);
      take_vertex(v, domain_.radius[v]);
    }
  }

  // Adds a window to a list; `corner`: the side of the polygon that it came through or enters.
  void add(std::uint32_t list, SourceWindow window, std::uint32_t through, std::uint32_t corner) {
    const std::uint32_t e = edge_of_list_[list];
    const double length = domain_.network.length[e], end = narrowest(e);
    if (window.from < end) window.from = 0;
    if (window.to > length - end) window.to = length;
    if (!(window.to - window.from > end)) return;
    made_.clear();
    lists_[list].insert(window, through, margin_, end, made_);
    for (const std::uint32_t id : made_) {
      const WindowEnvelope::Entry& entry = *lists_[list].find(id);
      queue_.push({entry.window.earliest(), Kind::window, list, id, 0});
      if (entry.through != through) continue;  // a part of an older one
      const SourceWindow& w = entry.window;
      const bool forward = domain_.polygons.sides[corner].forward;
      if (w.from <= end) reach(forward ? corner : domain_.corner_after(corner), w.at(0));
      if (w.to >= length - end) reach(forward ? domain_.corner_after(corner) : corner, w.at(length));
      if (through == kEntering && domain_.network.degree(e) > 2)
        for (const double x : {w.from, w.to})
          if (x > end && x < length - end) queue_.push({w.at(x), Kind::kink, list, 0, x});
    }
  }

  // Fire in the polygon of a corner comes to its vertex.
  void reach(std::uint32_t corner, double time) {
    const std::uint32_t state = domain_.network.corner_state[corner];
    if (!(time < arrival_[state] - margin_)) return;
    arrival_[state] = time;
    queue_.push({time, Kind::vertex, domain_.complex.face_vertices[corner], 0, 0});
  }

  void take_vertex(std::uint32_t v, double now) {
    const std::uint32_t first = domain_.network.vertex_base[v];
    const auto sectors = times_of(v);
    std::vector<std::pair<std::uint32_t, double>> burning;
    for (std::uint32_t i = 0; i < sectors.size(); ++i) {
      const double time = sectors[i].time;
      const std::uint32_t s = first + i;
      if (!(time < sent_[s] - margin_)) continue;
      if (time > now) {
        if (time < queued_[s]) {
          queued_[s] = time;
          queue_.push({time, Kind::vertex, v, 0, 0});
        }
        continue;
      }
      sent_[s] = time;
      burning.emplace_back(s, time);
    }
    for (const auto& [s, time] : burning)
      for (const std::uint32_t c : std::as_const(domain_.links.corners)[s]) send_from_vertex(c, time);
  }

  // Fire from the vertex of a corner into its polygon.
  void send_from_vertex(std::uint32_t corner, double time) {
    const std::uint32_t f = domain_.network.corner_face[corner], before = domain_.corner_before(corner);
    if (domain_.network.pocket[f]) return;
    const Polygons::Side& side = domain_.polygons.sides[corner];
    const PlanePoint source{side.x, side.y};
    for (const std::uint32_t c : {corner, before}) {
      const std::uint32_t e = domain_.complex.face_edges[c];
      const double length = domain_.network.length[e];
      const bool at_start = domain_.polygons.sides[c].forward == (c == corner);
      arrive(c, {0, length, at_start ? 0 : length, 0, time});
      reach(c == corner ? domain_.corner_after(c) : c, time + length);
    }
    send_from_point(f, source, time, corner, before);
  }

  // Fire from a point of a polygon to all its sides but two.
  void send_from_point(std::uint32_t f, const PlanePoint& source, double time, std::uint32_t but, std::uint32_t nor) {
    for (std::uint32_t c = domain_.complex.face_offsets[f]; c < domain_.complex.face_offsets[f + 1]; ++c) {
      if (c == but || c == nor) continue;
      const SideFrame frame(domain_.polygons.sides[c]);
      arrive_in(frame, c, {0, frame.length, frame.x(source), std::abs(frame.y(source)), time});
    }
  }

  // Fire comes to a side, in lengths of the polygon's plane: they differ a little from those of edges where a polygon
  // is not quite flat.
  void arrive_in(const SideFrame& frame, std::uint32_t corner, SourceWindow window) {
    const double scale =
        frame.length > 0 ? domain_.network.length[domain_.complex.face_edges[corner]] / frame.length : 1;
    window.from *= scale;
    window.to *= scale;
    window.along *= scale;
    arrive(corner, window);
  }

  // Fire in a polygon comes to one of its sides.
  void arrive(std::uint32_t corner, const SourceWindow& window) {
    add(list_of(corner), window, domain_.network.corner_rank[corner], corner);
  }

  void take_window(const Event& event) {
    WindowEnvelope::Entry* entry = lists_[event.at].find(event.id);
    if (!entry || entry->sent) return;
    const double earliest = entry->window.earliest();
    if (earliest > event.time + margin_) {
      queue_.push({earliest, Kind::window, event.at, event.id, 0});
      return;
    }
    entry->sent = true;
    const SourceWindow window = entry->window;
    const std::uint32_t through = entry->through, e = edge_of_list_[event.at];
    const Links::Edge& edge = domain_.links.edges[e];
    const auto corners = domain_.network.face_corners_at(e);
    if (through == kEntering) {
      cross(corners[event.at - first_list_[e]], window);
    } else if (edge.degree == 2) {
      cross(corners[1 - through], window);
    } else if (edge.degree > 2 && !edge.pocket) {
      for (std::uint32_t r = 0; r < edge.degree; ++r)
        if (r != through) open(e, r, through, window);
    }
  }

  // Fire enters a polygon through a side and goes on to the others, in straight lines from its source.
  void cross(std::uint32_t corner, const SourceWindow& window) {
    const std::uint32_t f = domain_.network.corner_face[corner];
    if (domain_.network.pocket[f]) return;
    const SideFrame frame(domain_.polygons.sides[corner]);
    const bool flat = domain_.polygons.flat[f];
    const PlanePoint source = frame.point(window.along, -window.depth);
    for (std::uint32_t c = domain_.complex.face_offsets[f]; c < domain_.complex.face_offsets[f + 1]; ++c) {
      if (c == corner) continue;
      const SideFrame far(domain_.polygons.sides[c]);
      if (!(far.length > 0)) continue;
      const PlanePoint a = far.origin, b = far.point(far.length, 0);
      SourceWindow reached{0, far.length, far.x(source), std::abs(far.y(source)), window.time};
      double low = 0, high = 1;
      const auto clip = [&](double at0, double at1) {  // where a linear function is not negative
        if (at0 >= 0 && at1 >= 0) return;
        if (at0 < 0 && at1 < 0)
          high = -1;
        else if (at0 < 0)
          low = std::max(low, at0 / (at0 - at1));
        else
          high = std::min(high, at0 / (at0 - at1));
      };
      const double ax = frame.x(a), bx = frame.x(b);
      if (flat) {
        const double depth = window.depth, ay = std::max(0.0, frame.y(a)), by = std::max(0.0, frame.y(b));
        const double left = window.from - window.along, right = window.to - window.along;
        clip((ax - window.along) * depth - left * (ay + depth), (bx - window.along) * depth - left * (by + depth));
        clip(right * (ay + depth) - (ax - window.along) * depth, right * (by + depth) - (bx - window.along) * depth);
      } else {  // a polygon without width: what lies opposite
        clip(ax - window.from, bx - window.from);
        clip(window.to - ax, window.to - bx);
        reached.depth = window.depth;
      }
      if (!(low < high)) continue;
      reached.from = low * far.length;
      reached.to = high * far.length;
      arrive_in(far, c, reached);
    }
  }

  // Fire has come to a seam through one polygon: where it has come through all others of the edge but polygon r, it
  // enters this one, at the time of the last of them.
  void open(std::uint32_t e, std::uint32_t r, std::uint32_t came, const SourceWindow& window) {
    std::vector<SourceWindow> latest{window}, next;
    const std::uint32_t degree = domain_.links.edges[e].degree;
    for (std::uint32_t other = 0; other < degree && !latest.empty(); ++other) {
      if (other == r || other == came) continue;
      next.clear();
      for (const SourceWindow& w : latest)
        for (const WindowEnvelope::Entry& entry : lists_[first_list_[e] + other].entries()) {
          if (!entry.sent || entry.through == kEntering) continue;
          const double low = std::max(w.from, entry.window.from), high = std::min(w.to, entry.window.to);
          if (!(low < high)) continue;
          const Crossings at = crossings(w, entry.window, low, high);
          double from = low;
          for (int i = 0; i <= at.count; ++i) {
            const double to = i < at.count ? at.at[i] : high, middle = 0.5 * (from + to);
            SourceWindow later = w.at(middle) >= entry.window.at(middle) ? w : entry.window;
            later.from = from;
            later.to = to;
            next.push_back(later);
            from = to;
          }
        }
      std::swap(latest, next);
    }
    const std::uint32_t corner = domain_.network.face_corners_at(e)[r];
    for (const SourceWindow& w : latest) add(first_list_[e] + r, w, kEntering, corner);
  }

  // A place of a seam where windows that enter meet: where the fire of one turns away from that of the other, the place
  // is a source.
  void take_kink(std::uint32_t list, double x, double now) {
    const std::uint32_t e = edge_of_list_[list];
    const double reach = 1e-7 * domain_.network.length[e];
    const WindowEnvelope::Entry *left = nullptr, *right = nullptr;
    for (const auto& entry : lists_[list].entries()) {
      const SourceWindow& w = entry.window;
      if (w.from < x - reach && w.to > x + reach) return;
      if (w.from < x - reach && w.to >= x - reach) left = &entry;
      if (w.to > x + reach && w.from <= x + reach) right = &entry;
    }
    if (!left && !right) return;
    double time = std::min(left ? left->window.at(x) : kNever, right ? right->window.at(x) : kNever);
    if (left && left->window.at(x) > time + 1e3 * margin_) left = nullptr;
    if (right && right->window.at(x) > time + 1e3 * margin_) right = nullptr;
    if (!(left && left->through == kEntering) && !(right && right->through == kEntering)) return;
    if (time < now - 1e3 * margin_) return;  // earlier fire has come meanwhile, with kinks of its own
    if ((left ? left->window.slope(x) : -1) >= (right ? right->window.slope(x) : 1) - 1e-7) return;
    const std::uint32_t corner = domain_.network.face_corners_at(e)[list - first_list_[e]],
                        f = domain_.network.corner_face[corner];
    const SideFrame frame(domain_.polygons.sides[corner]);
    arrive(corner, {0, frame.length, x, 0, time});
    send_from_point(f, frame.point(x, 0), time, corner, corner);
  }

  const BurnDomain& domain_;
  Context* context_;
  std::vector<std::uint32_t> first_list_;  // per edge: one list, or one per polygon of a seam
  std::vector<std::uint32_t> edge_of_list_;
  std::vector<WindowEnvelope> lists_;
  std::vector<double> arrival_, sent_, queued_;  // per vertex state
  std::vector<char> pocket_;
  std::priority_queue<Event> queue_;
  std::vector<std::uint32_t> made_;
  SectorTimes sector_times_;
  double margin_ = 0;
};

}  // namespace

BurnTimes propagate_by_windows(const BurnDomain& domain, Context* context) {
  WindowFire fire(domain, context);
  fire.burn();
  return fire.times();
}

}  // namespace quench::burning
