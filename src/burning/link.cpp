// SPDX-License-Identifier: Apache-2.0
#include "burning/link.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace quench::burning {
namespace {

auto ends_of(std::span<const Links::Ends> ends) {
  return [ends](std::uint32_t sector) { return std::array{ends[sector].a, ends[sector].b}; };
}

constexpr auto kIsFree = [](std::uint32_t direction, std::uint32_t) { return direction != 0; };

auto note_in(std::vector<std::uint32_t>& stripped, std::span<char> removed) {
  return [&stripped, removed](std::uint32_t, std::uint32_t sector) {
    stripped.push_back(sector);
    removed[sector] = 1;
  };
}

}  // namespace

void Link::reset(std::span<const Links::Ends> ends, std::span<char> removed) {
  ends_ = ends;
  removed_ = removed;
  std::uint32_t directions = 1;
  for (const auto& e : ends)
    if (e.a != kNone) directions = std::max({directions, e.a + 1, e.b + 1});
  directions_.reset(directions);
  for (std::uint32_t s = 0; s < ends.size(); ++s) {
    if (removed[s] || ends[s].a == kNone) continue;
    directions_.add(ends[s].a, s);
    directions_.add(ends[s].b, s);
  }
}

void Link::remove(std::uint32_t sector, std::vector<std::uint32_t>& stripped) {
  removed_[sector] = 1;
  if (ends_[sector].a == kNone) return;
  directions_.remove(sector, ends_of(ends_), kIsFree, note_in(stripped, removed_));
}

void Link::strip(std::vector<std::uint32_t>& stripped) {
  directions_.peel(ends_of(ends_), kIsFree, note_in(stripped, removed_));
}

bool Link::on_cycle(std::uint32_t sector) {
  const auto [from, to] = ends_[sector];
  if (from == to) return true;  // a closed loop, or a loop at one direction
  group_.resize(directions_.vertex_count());
  std::iota(group_.begin(), group_.end(), 0u);
  const auto find = [&](std::uint32_t d) {
    while (group_[d] != d) d = group_[d] = group_[group_[d]];
    return d;
  };
  for (std::uint32_t s = 0; s < ends_.size(); ++s)
    if (s != sector && !removed_[s] && ends_[s].a != kNone) group_[find(ends_[s].a)] = find(ends_[s].b);
  return find(from) == find(to);
}

std::span<const SectorTimes::Time> SectorTimes::operator()(std::span<const Links::Ends> ends,
                                                           std::span<const double> arrival,
                                                           std::span<const char> pocket, double radius) {
  times_.assign(ends.size(), {kNever, kNone});
  removed_.assign(pocket.begin(), pocket.end());
  link_.reset(ends, removed_);
  stripped_.clear();
  link_.strip(stripped_);
  for (const std::uint32_t s : stripped_) times_[s].time = radius;
  order_.clear();
  for (std::uint32_t s = 0; s < ends.size(); ++s)
    if (!removed_[s] && arrival[s] < kNever) order_.push_back(s);
  // Most links have three to six sectors: insertion is the faster sort.
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return arrival[a] != arrival[b] ? arrival[a] < arrival[b] : a < b;
  };
  if (order_.size() > 16)
    std::sort(order_.begin(), order_.end(), earlier);
  else
    for (std::size_t i = 1; i < order_.size(); ++i) {
      const std::uint32_t s = order_[i];
      std::size_t at = i;
      for (; at > 0 && earlier(s, order_[at - 1]); --at) order_[at] = order_[at - 1];
      order_[at] = s;
    }
  for (const std::uint32_t s : order_) {
    if (removed_[s]) continue;
    stripped_.clear();
    link_.remove(s, stripped_);
    times_[s] = {arrival[s], s};
    for (const std::uint32_t t : stripped_) times_[t] = {arrival[s], s};
  }
  return times_;
}

}  // namespace quench::burning
