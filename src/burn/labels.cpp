// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "burn/fire.h"

namespace quench::burning {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

Labels::Labels(const Site& site, double tolerance, bool clamp, bool sources)
    : site_(site),
      tolerance_(tolerance),
      clamp_(clamp),
      queue_(site.radius.empty() ? 0 : *std::min_element(site.radius.begin(), site.radius.end()),
             site.network.omega / 4) {
  const BurnNetwork& network = site.network;
  const std::uint32_t states = network.state_count();
  time_.assign(states, kNever);
  arrival_.assign(states, kNever);
  through_.assign(states, kNone);
  status_.assign(states, 0);
  if (sources) source_.assign(states, kUnknownSource);

  std::vector<std::uint32_t> stripped;
  for (std::uint32_t v = 0; v < site.complex.vertex_count; ++v) {
    const std::uint32_t first = network.vertex_base[v], count = network.vertex_base[v + 1] - first;
    removed_.assign(count, 0);
    for (std::uint32_t s = 0; s < count; ++s) {
      const std::uint32_t c = site.links.corner_list[site.links.corner_offsets[first + s]];
      if (network.pocket[network.corner_face[c]]) {
        removed_[s] = 1;
        status_[first + s] = pocket;
      }
    }
    stripped.clear();
    Link({site.links.ends.data() + first, count}, removed_).strip(stripped);
    for (const std::uint32_t s : stripped) {
      status_[first + s] = open | queued;
      time_[first + s] = site.radius[v];
    }
  }
  for (std::uint32_t e = 0; e < site.complex.edges.size(); ++e) {
    const auto sides = network.sides_of(e);
    const std::uint32_t first = network.state_base[e], sectors = network.sectors_of(e);
    for (std::uint32_t i = 1; i < network.pieces[e]; ++i)
      for (std::uint32_t r = 0; r < sectors; ++r) {
        const std::uint32_t s = first + (i - 1) * sectors + r;
        if (network.pocket[network.corner_face[sides[r]]]) {
          status_[s] = pocket;
        } else if (sides.size() == 1) {
          status_[s] = open | queued;
          time_[s] = site.radius_inside(e, i);
        }
      }
  }
  for (std::uint32_t s = 0; s < states; ++s)
    if (status_[s] & queued) queue_.push(time_[s], s);
}

void Labels::label(std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  const bool push = !(status_[state] & burned) || status_[state] & queued || t < time_[state] - tolerance_;
  time_[state] = t;
  through_[state] = through;
  if (!source_.empty()) source_[state] = source;
  if (!push) return;
  status_[state] |= queued;
  queue_.push(t, state);
}

void Labels::lower(std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  if (!(t < time_[state]) || status_[state] & (open | pocket)) return;
  if (site_.is_vertex(state)) {
    if (clamp_) t = std::max(t, site_.radius[site_.links.vertex_of[state]]);
    if (t < std::min(time_[state], arrival_[state])) lower_vertex(state, t, through);
    return;
  }
  const std::uint32_t e = site_.edge_of(state);
  // A radius by the linear rule is no bound: it is above the distance to the nearest site.
  if (clamp_ && site_.rule == RadiusRule::exact) t = std::max(t, site_.radius_of(state));
  if (!(t < std::min(time_[state], arrival_[state]))) return;
  if (site_.links.edges[e].sectors > 1 && !site_.links.edges[e].pocket) {
    lower_seam(state, e, t, through, source);
  } else {
    arrival_[state] = t;
    label(state, t, through, source);
  }
}

void Labels::lower_vertex(std::uint32_t state, double t, std::uint32_t through) {
  arrival_[state] = t;
  const std::uint32_t v = site_.links.vertex_of[state];
  const std::uint32_t first = site_.network.vertex_base[v], count = site_.network.vertex_base[v + 1] - first;
  if (count == 1) return label(state, t, through, kUnknownSource);  // a closed fan: no other sector could be lowered
  removed_.resize(count);
  for (std::uint32_t s = 0; s < count; ++s) removed_[s] = (status_[first + s] & pocket) != 0;
  const auto times = sector_times_({site_.links.ends.data() + first, count}, {arrival_.data() + first, count}, removed_,
                                   site_.radius[v]);
  for (std::uint32_t s = 0; s < count; ++s)
    if (times[s].time < time_[first + s])
      label(first + s, times[s].time, times[s].opened_by == state - first && first + s == state ? through : kNone,
            kUnknownSource);
}

// The sheets at a node inside a seam are parallel sectors: each burns when fire arrives in it, but the latest when one
// sheet is left besides it, with the second latest, whose front goes on in it. Ties: the higher rank counts as later.
void Labels::lower_seam(std::uint32_t state, std::uint32_t edge, double t, std::uint32_t through,
                        const Source& source) {
  arrival_[state] = t;
  const std::uint32_t sectors = site_.network.sectors_of(edge);
  const std::uint32_t first = state - (state - site_.network.state_base[edge]) % sectors;
  std::uint32_t last = first, second = kNone;
  for (std::uint32_t s = first + 1; s < first + sectors; ++s) {
    if (arrival_[s] >= arrival_[last]) {
      second = last;
      last = s;
    } else if (second == kNone || arrival_[s] >= arrival_[second]) {
      second = s;
    }
  }
  if (state != last) label(state, t, through, source);
  if (arrival_[second] < time_[last])
    label(last, arrival_[second], through_[second], source_.empty() ? kUnknownSource : Source(source_[second]));
}

bool Labels::next(std::uint32_t& state, bool& again) {
  const auto stale = [&](const LabelQueue::Entry& e) {
    return !(status_[e.state] & queued) || e.time > time_[e.state];
  };
  LabelQueue::Entry entry;
  while (queue_.pop(entry, stale)) {
    if (stale(entry)) continue;
    state = entry.state;
    again = status_[state] & burned;
    status_[state] = static_cast<unsigned char>((status_[state] & ~queued) | burned);
    return true;
  }
  return false;
}

void Labels::release(std::vector<double>& times, std::vector<char>& opened) {
  std::vector<Source>().swap(source_);
  std::vector<std::uint32_t>().swap(through_);
  opened.resize(time_.size());
  for (std::size_t s = 0; s < time_.size(); ++s) opened[s] = !(status_[s] & open) && time_[s] < arrival_[s];
  std::vector<double>().swap(arrival_);
  times = std::move(time_);
}

}  // namespace quench::burning
