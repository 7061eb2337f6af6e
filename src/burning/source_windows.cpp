// SPDX-License-Identifier: Apache-2.0
#include "burning/source_windows.h"

#include <utility>

namespace quench::burning {

namespace {

// The zero of a - b between two places where it has unlike signs: Newton's method, kept between them.
double zero_between(const SourceWindow& a, const SourceWindow& b, double low, double high, bool rises) {
  double x = 0.5 * (low + high);
  for (int step = 0; step < 60; ++step) {
    const double value = a.at(x) - b.at(x);
    if (value == 0) break;
    ((value < 0) == rises ? low : high) = x;
    const double next = x - value / (a.slope(x) - b.slope(x));
    const double last = x;
    x = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(x - last) <= 1e-15 * (std::abs(low) + std::abs(high))) break;
  }
  return x;
}

}  // namespace

// The difference a - b is stationary where the lines to both sources are parallel, which is one place at most, since
// depths are not negative. So it is monotone on both sides of it.
Crossings crossings(const SourceWindow& a, const SourceWindow& b, double low, double high) {
  Crossings result;
  const double turn = (a.along * b.depth - b.along * a.depth) / (b.depth - a.depth);
  const double ends[3] = {low, turn > low && turn < high ? turn : high, high};
  double before = a.at(low) - b.at(low);
  for (int i = 0; i < 2 && ends[i] < ends[i + 1]; ++i) {
    const double after = a.at(ends[i + 1]) - b.at(ends[i + 1]);
    if ((before < 0 && after > 0) || (before > 0 && after < 0))
      result.at[result.count++] = zero_between(a, b, ends[i], ends[i + 1], before < 0);
    before = after;
  }
  return result;
}

WindowEnvelope::Entry* WindowEnvelope::find(std::uint32_t id) {
  for (Entry& entry : entries_)
    if (entry.id == id) return &entry;
  return nullptr;
}

const WindowEnvelope::Entry* WindowEnvelope::at(double x, double reach) const {
  const Entry* nearest = nullptr;
  double least = reach;
  for (const Entry& entry : entries_) {
    const double away = std::max({entry.window.from - x, x - entry.window.to, 0.0});
    if (away <= least) {
      if (nearest && away == least && entry.window.at(x) >= nearest->window.at(x)) continue;
      nearest = &entry;
      least = away;
    }
  }
  return nearest;
}

void WindowEnvelope::insert(const SourceWindow& window, std::uint32_t through, double margin, double narrowest,
                            std::vector<std::uint32_t>& made) {
  // The stretches that the window wins, in order.
  std::vector<std::pair<double, double>> won;
  const auto win = [&](double from, double to) {
    if (!(from < to)) return;
    if (!won.empty() && from - won.back().second <= narrowest)
      won.back().second = to;
    else
      won.emplace_back(from, to);
  };
  double x = window.from;
  for (const Entry& entry : entries_) {
    if (entry.window.to <= x) continue;
    if (entry.window.from >= window.to) break;
    if (entry.window.from > x) win(x, entry.window.from);
    const double low = std::max(x, entry.window.from), high = std::min(window.to, entry.window.to);
    const Crossings at = crossings(window, entry.window, low, high);
    double from = low;
    for (int i = 0; i <= at.count; ++i) {
      const double to = i < at.count ? at.at[i] : high, middle = 0.5 * (from + to);
      if (window.at(middle) < entry.window.at(middle) - margin) win(from, to);
      from = to;
    }
    x = high;
  }
  win(x, window.to);
  std::erase_if(won, [&](const auto& w) { return !(w.second - w.first > narrowest); });
  if (won.empty()) return;

  std::vector<Entry> result;
  result.reserve(entries_.size() + 2 * won.size());
  std::size_t next = 0;
  const auto add_won = [&] {
    SourceWindow part = window;
    part.from = won[next].first;
    part.to = won[next].second;
    made.push_back(next_id_);
    result.push_back({part, next_id_++, through, false});
    ++next;
  };
  for (const Entry& entry : entries_) {
    double from = entry.window.from;
    bool first = true;
    const auto keep = [&](double to) {
      if (!(to - from > narrowest)) return;
      Entry part = entry;
      part.window.from = from;
      part.window.to = to;
      if (!first) {
        part.id = next_id_++;
        if (!part.sent) made.push_back(part.id);
      }
      first = false;
      result.push_back(part);
    };
    while (next < won.size() && won[next].second <= from) add_won();
    while (next < won.size() && won[next].first < entry.window.to) {
      keep(std::min(entry.window.to, won[next].first));
      from = std::max(from, won[next].second);
      if (won[next].second > entry.window.to) break;  // it goes on in the next entry
      add_won();
    }
    keep(entry.window.to);
  }
  while (next < won.size()) add_won();
  entries_ = std::move(result);
}

}  // namespace quench::burning
