// SPDX-License-Identifier: Apache-2.0
#include "burning/labels.h"

#include <algorithm>
#include <cmath>

namespace quench::burning {
namespace {

// Parallel sectors: each burns when fire arrives in it, but the one of the latest arrival burns with that of the second
// latest, since it is the last sheet then. Ties: the higher rank counts as later.
struct Latest {
  std::uint32_t last, second;
};
Latest latest_of(const double* arrival, std::uint32_t count) {
  std::uint32_t last = 0, second = kNone;
  for (std::uint32_t s = 1; s < count; ++s) {
    if (arrival[s] >= arrival[last]) {
      second = last;
      last = s;
    } else if (second == kNone || arrival[s] >= arrival[second]) {
      second = s;
    }
  }
  return {last, second};
}

}  // namespace

Labels::Labels(const BurnDomain& domain, const BlockSchedule& schedule, double tolerance)
    : domain_(domain),
      tolerance_(tolerance),
      angles_(make_vertex_angles(domain)),
      queue_(make_label_queue(domain, schedule)) {
  const std::uint32_t states = domain.network.state_count();
  time_.assign(states, kNever);
  arrival_.assign(domain.links.arrivals, kNever);
  status_.assign(states, 0);
  through_.assign(states, kNone);
  source_.assign(states, kUnknownSource);
  start_vertices();
  start_edges();
  for (std::uint32_t s = 0; s < states; ++s)
    if (status_[s] & queued) queue_.push(s, time_[s]);
}

void Labels::start_vertices() {
  const BurnNetwork& network = domain_.network;
  std::vector<char> removed;
  std::vector<std::uint32_t> stripped;
  Link link;
  for (std::uint32_t v = 0; v < domain_.complex.vertex_count; ++v) {
    const std::uint32_t first = network.vertex_base[v], count = network.vertex_base[v + 1] - first;
    removed.resize(count);
    for (std::uint32_t s = 0; s < count; ++s) {
      removed[s] = domain_.in_pocket(first + s);
      status_[first + s] = static_cast<unsigned char>((removed[s] ? pocket : 0) | (count > 1 ? several : 0));
    }
    if (count == 0 || (count == 1 && domain_.links.ends[first].a == kNone)) continue;  // no free end
    stripped.clear();
    link.reset({domain_.links.ends.data() + first, count}, removed);
    link.strip(stripped);
    for (const std::uint32_t s : stripped) {
      status_[first + s] |= open | queued;
      time_[first + s] = domain_.radius[v];
      source_[first + s] = source_at_rim(first + s, v);
    }
  }
}

void Labels::start_edges() {
  const BurnNetwork& network = domain_.network;
  for (std::uint32_t e = 0; e < domain_.complex.edges.size(); ++e) {
    const auto corners = network.face_corners_at(e);
    const std::uint32_t first = network.state_base[e], sectors = network.sectors_of(e);
    for (std::uint32_t i = 1; i < network.pieces[e]; ++i)
      for (std::uint32_t r = 0; r < sectors; ++r) {
        const std::uint32_t s = first + (i - 1) * sectors + r;
        if (sectors > 1 && !domain_.links.edges[e].pocket) status_[s] = several;
        if (network.pocket[network.corner_face[corners[r]]]) {
          status_[s] = pocket;
        } else if (corners.size() == 1) {
          status_[s] = open | queued;
          time_[s] = domain_.radius_inside(e, i);
        }
      }
  }
}

inline void Labels::label(Worker& worker, std::uint32_t state, double t) {
  const double before = time_[state];
  time_[state] = t;
  status_[state] &= static_cast<unsigned char>(~at_radius);  // the new time may be below the radius
  if (status_[state] & queued) {
    worker.lower(state, before, t);
  } else if (!(status_[state] & burned) || t < before - tolerance_) {
    status_[state] |= queued;
    worker.push(state, t);
  }
}

inline void Labels::label(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  through_[state] = through;
  source_[state] = source;
  label(worker, state, t);
}

void Labels::lower_time(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  const bool vertex = domain_.is_vertex(state);
  if (!(status_[state] & several)) return label(worker, state, t, vertex ? kNone : through, source);
  if (vertex)
    lower_vertex(worker, state, t, source);
  else
    lower_seam(worker, state, t, through, source);
}

// On a free edge fire starts from the point whose distance the radius is, if there is one.
Source Labels::source_at_rim(std::uint32_t state, std::uint32_t v) const {
  const auto angle_beyond = [&](std::uint32_t edge) {
    if (edge == kNone || domain_.network.degree(edge) != 1) return kNever;
    const auto [a, b] = domain_.complex.edges[edge];
    const double r = domain_.radius[v], other = domain_.radius[v == a ? b : a], length = domain_.network.length[edge];
    if (!(r > 0) || !is_distance_to_point(r, other, length, domain_.rule)) return kNever;
    return std::acos(std::clamp((r * r - other * other + length * length) / (2 * length * r), -1.0, 1.0));
  };
  const auto& sector = angles_.sectors[state];
  return {angle_beyond(sector.first_edge), angle_beyond(sector.last_edge), kUnknownSource.time};
}

// Over a seam fire goes on in the last sheet as it came to the seam in another one, the sector `opener`.
Source Labels::source_beyond(std::uint32_t state, std::uint32_t opener) const {
  const auto& sector = angles_.sectors[state];
  const std::uint32_t v = domain_.links.vertex_of[state];
  return {angle_beyond(sector.first_edge, v, opener), angle_beyond(sector.last_edge, v, opener), kUnknownSource.time};
}

// The angle at vertex v between an edge and the source of `opener`; infinite if its sector does not touch the edge.
double Labels::angle_beyond(std::uint32_t edge, std::uint32_t v, std::uint32_t opener) const {
  double least = kNever;
  if (edge == kNone) return least;
  for (const std::uint32_t c : domain_.network.face_corners_at(edge)) {
    const bool starts = domain_.complex.face_vertices[c] == v;
    const std::uint32_t own = starts ? c : domain_.corner_after(c);
    if (domain_.network.corner_state[own] != opener) continue;
    const Seen seen = seen_along(opener, own, starts);
    if (!std::isnan(seen.time)) least = std::min(least, seen.inside);
  }
  return least;
}

Seen Labels::seen_along(std::uint32_t state, std::uint32_t corner, bool starts) const {
  const auto& [at_side, at_before] = angles_.corners[corner];
  const auto& sector = angles_.sectors[state];
  const double side = starts ? at_side : at_before, other = starts ? at_before : at_side;
  Source source = source_[state];
  double back = 0, ahead = 0;  // angles between the side and the source, both ways round
  if (std::isnan(source.time)) {
    back = side + source.x;
    ahead = sector.angle - side + source.y;
    const std::uint32_t opener = opened_by(state);
    if (std::isinf(std::min(back, ahead)))
      source = kUnknownSource;
    else if (opener == kNone || std::isnan(source_[opener].time))
      source = {0, time_[opener == kNone ? state : opener], 0};
    else
      source = source_[opener];
  } else {
    constexpr double kRounding = 1e-9;
    const auto positive = [&](double angle) {
      if (angle >= -kRounding) return std::max(angle, 0.0);
      return sector.is_closed() ? angle + sector.angle : kNever;
    };
    back = positive(side - source.x);
    ahead = positive(source.x - side);
  }
  return {other > side ? ahead : back, other > side ? back : ahead, source.y, source.time};
}

// Whether all sectors of a vertex have the same two ends, as along a seam, and none is in a pocket.
bool Labels::is_parallel(std::uint32_t first, std::uint32_t count) const {
  const Links::Ends* ends = domain_.links.ends.data() + first;
  const auto [a, b] = ends[0];
  if (a == kNone || a == 0 || b == 0 || a == b || count < 2) return false;
  for (std::uint32_t s = 0; s < count; ++s)
    if (status_[first + s] & pocket || !((ends[s].a == a && ends[s].b == b) || (ends[s].a == b && ends[s].b == a)))
      return false;
  return true;
}

void Labels::lower_vertex(Worker& worker, std::uint32_t state, double t, const Source& source) {
  if (!(t < arrival_[state])) return;
  arrival_[state] = t;
  const std::uint32_t v = domain_.links.vertex_of[state];
  const std::uint32_t first = domain_.network.vertex_base[v], count = domain_.network.vertex_base[v + 1] - first;
  if (is_parallel(first, count)) {  // a short cut for most vertices
    const auto [last, second] = latest_of(arrival_.data() + first, count);
    if (state != first + last) label(worker, state, t, kNone, source);
    if (const double opening = arrival_[first + second]; opening < time_[first + last])
      label(worker, first + last, opening, first + second, source_beyond(first + last, first + second));
    return;
  }
  worker.removed.resize(count);
  for (std::uint32_t s = 0; s < count; ++s) worker.removed[s] = (status_[first + s] & pocket) != 0;
  const auto times = worker.sector_times({domain_.links.ends.data() + first, count}, {arrival_.data() + first, count},
                                         worker.removed, domain_.radius[v]);
  // First those that burn by themselves: the others take their sources. Those of earlier arrivals are not kept.
  for (std::uint32_t s = 0; s < count; ++s)
    if (times[s].opened_by == s && times[s].time < time_[first + s])
      label(worker, first + s, times[s].time, kNone, first + s == state ? source : kUnknownSource);
  for (std::uint32_t s = 0; s < count; ++s) {
    const auto [time, by] = times[s];
    if (by == s || !(time < time_[first + s])) continue;
    label(worker, first + s, time, by == kNone ? kNone : first + by,
          by == kNone ? kUnknownSource : source_beyond(first + s, first + by));
  }
}

// The front of the second latest sector continues in the latest.
void Labels::lower_seam(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  const Links::Edge& edge = domain_.links.edges[domain_.edge_of(state)];
  const std::uint32_t place = state - edge.state_base, rank = place % edge.degree;
  double* arrival = arrival_.data() + edge.first_arrival + (place - rank);
  if (!(t < arrival[rank])) return;
  arrival[rank] = t;
  const auto [last, second] = latest_of(arrival, edge.degree);
  const std::uint32_t first = state - rank;
  if (rank != last) label(worker, state, t, through, source);
  if (arrival[second] < time_[first + last])
    label(worker, first + last, arrival[second], through_[first + second], Source(this->source(first + second)));
}

bool Labels::next(Worker& worker, std::uint32_t& state, bool& again) {
  while (worker.pop(state, [&](std::uint32_t s) { return queued_time(s); })) {
    // No burn time is below the radius, but fronts of segments can be early by a fraction of the spacing. A radius
    // interpolated by the linear rule is not such a bound.
    if (!(status_[state] & (open | at_radius)) && (domain_.is_vertex(state) || domain_.rule == RadiusRule::exact)) {
      const double least = domain_.radius_of(state);
      if (time_[state] < least) {
        time_[state] = least;
        status_[state] |= at_radius;
        worker.push(state, least);
        continue;
      }
    }
    again = status_[state] & burned;
    status_[state] = static_cast<unsigned char>((status_[state] & ~queued) | burned);
    return true;
  }
  return false;
}

BurnTimes Labels::release() {
  HugeVector<std::uint32_t>().swap(through_);
  HugeVector<Source>().swap(source_);
  angles_ = {};
  queue_ = LabelQueue();
  std::vector<char> opened(time_.size(), 0);
  const auto set = [&](std::uint32_t s, double arrival) {
    opened[s] = (status_[s] & several) && !(status_[s] & open) && time_[s] < arrival;
  };
  for (std::uint32_t s = 0; s < domain_.vertex_states(); ++s) set(s, arrival_[s]);
  for (std::uint32_t e = 0; e < domain_.links.edges.size(); ++e) {
    const Links::Edge& edge = domain_.links.edges[e];
    if (edge.degree <= 2) continue;
    const std::uint32_t first = edge.state_base, end = domain_.network.state_base[e + 1];
    for (std::uint32_t s = first; s < end; ++s) set(s, arrival_[edge.first_arrival + (s - first)]);
  }
  Times().swap(arrival_);
  HugeVector<unsigned char>().swap(status_);
  return {std::move(time_), std::move(opened)};
}

}  // namespace quench::burning
