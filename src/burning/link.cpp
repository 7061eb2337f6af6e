// SPDX-License-Identifier: Apache-2.0
#include "burning/link.h"

#include <algorithm>
#include <numeric>

namespace quench::burning {

void Link::reset(std::span<const Links::Ends> ends, std::span<char> removed) {
  ends_ = ends;
  removed_ = removed;
  std::uint32_t directions = 1;
  for (const auto& e : ends)
    if (e.a != kNone) directions = std::max({directions, e.a + 1, e.b + 1});
  count_ = directions;
  if (directions_.size() < directions) directions_.resize(directions);
  for (std::uint32_t d = 0; d < directions; ++d) directions_[d] = {0, 0};
  for (std::uint32_t s = 0; s < ends.size(); ++s) {
    if (removed[s] || ends[s].a == kNone) continue;
    for (const std::uint32_t d : {ends[s].a, ends[s].b}) {
      ++directions_[d].degree;
      directions_[d].sectors_xor ^= s;
    }
  }
}

void Link::detach(std::uint32_t sector) {
  removed_[sector] = 1;
  if (ends_[sector].a == kNone) return;
  for (const std::uint32_t d : {ends_[sector].a, ends_[sector].b}) {
    directions_[d].sectors_xor ^= sector;
    if (--directions_[d].degree == 1 && d != 0) free_.push_back(d);
  }
}

void Link::remove(std::uint32_t sector, std::vector<std::uint32_t>& stripped) {
  free_.clear();
  detach(sector);
  while (!free_.empty()) {
    const std::uint32_t d = free_.back();
    free_.pop_back();
    if (directions_[d].degree != 1) continue;  // its last sector went from the other end
    stripped.push_back(directions_[d].sectors_xor);
    detach(directions_[d].sectors_xor);
  }
}

void Link::strip(std::vector<std::uint32_t>& stripped) {
  for (std::uint32_t d = 1; d < count_; ++d)
    if (directions_[d].degree == 1) {
      const std::uint32_t sector = directions_[d].sectors_xor;
      stripped.push_back(sector);
      remove(sector, stripped);
    }
}

bool Link::on_cycle(std::uint32_t sector) {
  const auto [from, to] = ends_[sector];
  if (from == to) return true;  // a closed loop, or a loop at one direction
  group_.resize(count_);
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
  constexpr double kNever = std::numeric_limits<double>::infinity();
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
