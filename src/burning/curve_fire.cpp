// SPDX-License-Identifier: Apache-2.0
#include "burning/curve_fire.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>

#include "base/cofaces.h"
#include "base/constants.h"
#include "quench/geometry.h"

namespace quench::burning {
namespace {

using base::kNever;

// Fire in the order of (time, vertex) needs no queue where that order cannot matter: a vertex v whose only edge leads
// to a vertex that burns later than v anyhow passes the fire on to it, whatever else burns in between. The others wait
// in a queue. There the order of two vertices v and u of one edge, the last of their tree, is that in which they would
// be burned if all waited: v waits for all that burn before it in the tree on its side, so it goes at the largest
// (time, vertex) of these; as times grow towards v, that is the time of v and the largest vertex with this time in a
// chain of edges of no length.
class Fire {
 public:
  Fire(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> used, std::span<const double> start,
       std::span<const double> length)
      : edges_(edges), start_(start), length_(length), left_(used.size()), turn_(used.size()) {
    fire_.time.assign(start.begin(), start.end());  // so far the arrival
    fire_.exit.assign(used.size(), kNone);
    fire_.last.assign(used.size(), 0);
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      for (const std::uint32_t v : edges[e]) left_[v].add(e);
    for (std::uint32_t v = 0; v < turn_.size(); ++v) turn_[v] = v;
  }

  CurveFire run(std::span<const char> used) {
    burned_.assign(used.size(), 0);
    std::vector<std::uint32_t> first;
    for (std::uint32_t v = 0; v < used.size(); ++v)
      if (used[v] && start_[v] < kNever && (left_[v].none() || left_[v].single())) first.push_back(v);
    for (const std::uint32_t v : first) burn_or_wait(v);
    while (!queue_.empty()) {
      const std::uint32_t v = std::get<2>(queue_.top());
      queue_.pop();
      burn_or_wait(burn(v));
    }
    time_last();
    for (std::size_t v = 0; v < burned_.size(); ++v)
      if (!burned_[v]) fire_.time[v] = kNever;
    return std::move(fire_);
  }

 private:
  // Follows the fire from a vertex with at most one edge left, until it has to wait or stops at a junction.
  void burn_or_wait(std::uint32_t v) {
    while (v != kNone) {
      if (left_[v].single() && !(fire_.time[v] < start_[other_end(v)])) {
        queue_.push({fire_.time[v], turn_[v], v});
        return;
      }
      v = burn(v);
    }
  }

  // Returns the vertex the fire goes on to, if this can burn now.
  std::uint32_t burn(std::uint32_t v) {
    burned_[v] = 1;
    if (left_[v].none()) {
      fire_.last[v] = 1;
      return kNone;
    }
    const std::uint32_t e = left_[v].only(), other = other_end(v);
    fire_.exit[v] = e;
    left_[v].remove(e);
    left_[other].remove(e);
    // If this was the last edge of the other end, that waits already and burns at its own time, as the last.
    if (left_[other].none()) return kNone;
    const double arrival = fire_.time[v] + length_[e];
    if (arrival > fire_.time[other]) {
      fire_.time[other] = arrival;
      turn_[other] = other;
    }
    if (fire_.time[v] == fire_.time[other]) turn_[other] = std::max(turn_[other], turn_[v]);
    return left_[other].single() && start_[other] < kNever ? other : kNone;
  }
  std::uint32_t other_end(std::uint32_t v) const {
    const auto [a, b] = edges_[left_[v].only()];
    return a == v ? b : a;
  }

  // The last of a tree burns at its own time: when fire came over all of its edges but that of the neighbour that burns
  // last. Which one this was is not known while they burn.
  void time_last() {
    struct Arrival {
      std::uint32_t at;
      double from_time;
      std::uint32_t from_turn;
      double time;
    };
    std::vector<Arrival> arrivals;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      const auto [a, b] = edges_[e];
      if (!fire_.last[a] && !fire_.last[b]) continue;
      const std::uint32_t from = fire_.last[a] ? b : a;
      arrivals.push_back({fire_.last[a] ? a : b, fire_.time[from], turn_[from], fire_.time[from] + length_[e]});
    }
    std::sort(arrivals.begin(), arrivals.end(), [](const Arrival& a, const Arrival& b) {
      return std::tie(a.at, a.from_time, a.from_turn) < std::tie(b.at, b.from_time, b.from_turn);
    });
    for (std::size_t i = 0; i < arrivals.size(); ++i) {
      const std::uint32_t v = arrivals[i].at;
      if (i == 0 || arrivals[i - 1].at != v) fire_.time[v] = start_[v];
      if (i + 1 < arrivals.size() && arrivals[i + 1].at == v) fire_.time[v] = std::max(fire_.time[v], arrivals[i].time);
    }
  }

  using Label = std::tuple<double, std::uint32_t, std::uint32_t>;  // time, turn, vertex
  std::span<const std::array<std::uint32_t, 2>> edges_;
  std::span<const double> start_, length_;
  std::vector<base::Cofaces> left_;  // edges that are left at each vertex
  std::vector<std::uint32_t> turn_;  // per vertex: the largest that burned at its time, in an unbroken chain up to it
  std::vector<char> burned_;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue_;
  CurveFire fire_;
};

}  // namespace

CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> used,
                      std::span<const double> start, std::span<const double> length) {
  return Fire(edges, used, start, length).run(used);
}

}  // namespace quench::burning
