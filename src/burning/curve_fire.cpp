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
  Fire(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> of_curves,
       std::span<const double> start, std::span<const double> length)
      : edges_(edges), of_curves_(of_curves), start_(start), length_(length), vertices_(start.size()) {
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) vertices_[v] = {{}, start[v], v, kNone};
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      if (of_curves[e])
        for (const std::uint32_t v : edges[e]) vertices_[v].left.add(e);
    last_.assign(start.size(), 0);
  }

  CurveFire run(std::span<const char> used) {
    std::vector<std::uint32_t> first;
    for (std::uint32_t v = 0; v < used.size(); ++v) {
      const base::Cofaces left = vertices_[v].left;
      if (used[v] && start_[v] < kNever && (left.none() || left.single())) first.push_back(v);
    }
    for (const std::uint32_t v : first) burn_or_wait(v);
    // Most that wait can go when others have gone.
    for (std::size_t before = first.size(); 2 * waiting_.size() < before;) {
      before = waiting_.size();
      first.swap(waiting_);
      waiting_.clear();
      for (const std::uint32_t v : first) burn_or_wait(v);
    }
    for (;;) {
      for (const std::uint32_t v : waiting_) queue_.push({vertices_[v].time, vertices_[v].turn, v});
      waiting_.clear();
      if (queue_.empty()) break;
      const std::uint32_t v = std::get<2>(queue_.top());
      queue_.pop();
      burn_or_wait(burn(v));
    }
    time_last();
    CurveFire fire;
    fire.time.resize(vertices_.size());
    fire.exit.resize(vertices_.size());
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
      fire.exit[v] = vertices_[v].exit;
      fire.time[v] = fire.exit[v] != kNone || last_[v] ? vertices_[v].time : kNever;
    }
    fire.last = std::move(last_);
    return fire;
  }

 private:
  struct Vertex {
    base::Cofaces left;  // edges that are left
    double time;         // of the fire that has come so far, at least the start
    std::uint32_t turn;  // the largest vertex that burned at this time, in an unbroken chain up to this one
    std::uint32_t exit;
  };

  // Follows the fire from a vertex with at most one edge left, until it has to wait or stops at a junction. One that
  // waited may be the last by now.
  void burn_or_wait(std::uint32_t v) {
    while (v != kNone) {
      if (!may_burn(v)) return waiting_.push_back(v);
      v = burn(v);
    }
  }

  // Whether nothing can come to a vertex over its only edge before it burns: not from the other end, nor, where just
  // one more edge is left there, from beyond that, and so on.
  bool may_burn(std::uint32_t v) const {
    constexpr int kFar = 16;
    const double time = vertices_[v].time;
    base::Cofaces left = vertices_[v].left;
    if (left.none()) return true;
    for (int step = 0; step < kFar && left.single(); ++step) {
      const std::uint32_t e = left.only();
      const auto [a, b] = edges_[e];
      v = a == v ? b : a;
      if (time < vertices_[v].time) return true;
      left = vertices_[v].left;
      left.remove(e);
    }
    return false;
  }

  // Returns the vertex the fire goes on to, if this can burn now.
  std::uint32_t burn(std::uint32_t v) {
    Vertex& from = vertices_[v];
    if (from.left.none()) {
      last_[v] = 1;
      return kNone;
    }
    const std::uint32_t e = from.left.only(), other = other_end(v);
    Vertex& to = vertices_[other];
    from.exit = e;
    from.left.remove(e);
    to.left.remove(e);
    // If this was the last edge of the other end, that waits already and burns at its own time, as the last.
    if (to.left.none()) return kNone;
    const double arrival = from.time + length_[e];
    if (arrival > to.time) {
      to.time = arrival;
      to.turn = other;
    }
    if (from.time == to.time) to.turn = std::max(to.turn, from.turn);
    return to.left.single() && start_[other] < kNever ? other : kNone;
  }
  std::uint32_t other_end(std::uint32_t v) const {
    const auto [a, b] = edges_[vertices_[v].left.only()];
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
      if (!of_curves_[e] || (!last_[a] && !last_[b])) continue;
      const Vertex& from = vertices_[last_[a] ? b : a];
      arrivals.push_back({last_[a] ? a : b, from.time, from.turn, from.time + length_[e]});
    }
    std::sort(arrivals.begin(), arrivals.end(), [](const Arrival& a, const Arrival& b) {
      return std::tie(a.at, a.from_time, a.from_turn) < std::tie(b.at, b.from_time, b.from_turn);
    });
    for (std::size_t i = 0; i < arrivals.size(); ++i) {
      const std::uint32_t v = arrivals[i].at;
      double& time = vertices_[v].time;
      if (i == 0 || arrivals[i - 1].at != v) time = start_[v];
      if (i + 1 < arrivals.size() && arrivals[i + 1].at == v) time = std::max(time, arrivals[i].time);
    }
  }

  using Label = std::tuple<double, std::uint32_t, std::uint32_t>;  // time, turn, vertex
  std::span<const std::array<std::uint32_t, 2>> edges_;
  std::span<const char> of_curves_;
  std::span<const double> start_, length_;
  std::vector<Vertex> vertices_;
  std::vector<char> last_;
  std::vector<std::uint32_t> waiting_;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue_;
};

}  // namespace

CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> of_curves,
                      std::span<const char> used, std::span<const double> start, std::span<const double> length) {
  return Fire(edges, of_curves, start, length).run(used);
}

}  // namespace quench::burning
