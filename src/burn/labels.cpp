// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "burn/fire.h"
#include "burn/prefetch_ahead.h"
#include "quench/error.h"

namespace quench::burning {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

Labels::Labels(const Site& site, double tolerance, bool clamp, bool sources)
    : site_(site),
      tolerance_(tolerance),
      clamp_(clamp),
      queue_(site.radius.empty() ? 0 : *std::min_element(site.radius.begin(), site.radius.end()),
             site.network.omega / 32) {
  const BurnNetwork& network = site.network;
  const std::uint32_t states = network.state_count();
  time_.assign(states, kNever);
  arrival_.assign(states, kNever);
  status_.assign(states, 0);
  if (sources) origin_.assign(states, {kUnknownSource, kNone});

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
    if (count > 1)
      for (std::uint32_t s = 0; s < count; ++s) status_[first + s] |= several;
    stripped.clear();
    Link({site.links.ends.data() + first, count}, removed_).strip(stripped);
    for (const std::uint32_t s : stripped) {
      status_[first + s] |= open | queued;
      time_[first + s] = site.radius[v];
    }
  }
  for (std::uint32_t e = 0; e < site.complex.edges.size(); ++e) {
    const auto sides = network.sides_of(e);
    const std::uint32_t first = network.state_base[e], sectors = network.sectors_of(e);
    for (std::uint32_t i = 1; i < network.pieces[e]; ++i)
      for (std::uint32_t r = 0; r < sectors; ++r) {
        const std::uint32_t s = first + (i - 1) * sectors + r;
        if (sectors > 1 && !site.links.edges[e].pocket) status_[s] = several;
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
  if (!origin_.empty()) origin_[state] = {source, through};
  if (!push) return;
  status_[state] |= queued;
  queue_.push(t, state);
}

void Labels::lower_time(std::uint32_t state, double t, std::uint32_t through, const Source& source) {
  if (!(status_[state] & several)) return label(state, t, through, source);
  if (!(t < arrival_[state])) return;
  if (site_.is_vertex(state))
    lower_vertex(state, t, through);
  else
    lower_seam(state, site_.edge_of(state), t, through, source);
}

void Labels::lower_vertex(std::uint32_t state, double t, std::uint32_t through) {
  arrival_[state] = t;
  const std::uint32_t v = site_.links.vertex_of[state];
  const std::uint32_t first = site_.network.vertex_base[v], count = site_.network.vertex_base[v + 1] - first;
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
    origin_.empty() ? label(last, arrival_[second], kNone, kUnknownSource)
                    : label(last, arrival_[second], origin_[second].through, Source(origin_[second].source));
}

bool Labels::next(std::uint32_t& state, bool& again) {
  const auto stale = [&](const LabelQueue::Entry& e) { return !(status_[e.id] & queued) || e.key > time_[e.id]; };
  LabelQueue::Entry entry;
  while (queue_.pop(entry, stale)) {
    prefetch_ahead(queue_, site_, time_.data());
    queue_.peek(12, [&](std::uint32_t s) {
      prefetch(&status_[s]);
      if (!origin_.empty()) prefetch(&origin_[s]);
    });
    if (stale(entry)) continue;
    state = entry.id;
    // Nothing burns before its own ball is gone: fronts of segments can be early by a fraction of the spacing. A radius
    // by the linear rule is no such bound.
    if (clamp_ && !(status_[state] & (open | floor)) && (site_.is_vertex(state) || site_.rule == RadiusRule::exact)) {
      const double least = site_.radius_of(state);
      if (time_[state] < least) {
        time_[state] = least;
        status_[state] |= floor;
        queue_.push(least, state);
        continue;
      }
    }
    again = status_[state] & burned;
    status_[state] = static_cast<unsigned char>((status_[state] & ~queued) | burned);
    return true;
  }
  return false;
}

void Labels::release(Times& times, std::vector<char>& opened) {
  lattice::HugeVector<Origin>().swap(origin_);
  opened.resize(time_.size());
  for (std::size_t s = 0; s < time_.size(); ++s)
    opened[s] = (status_[s] & several) && !(status_[s] & open) && time_[s] < arrival_[s];
  Times().swap(arrival_);
  times = std::move(time_);
}

}  // namespace quench::burning
