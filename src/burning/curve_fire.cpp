// SPDX-License-Identifier: Apache-2.0
#include "burning/curve_fire.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <queue>
#include <tuple>
#include <utility>

#include "base/cofaces.h"
#include "base/constants.h"
#include "base/parallel.h"
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
      : edges_(edges),
        of_curves_(of_curves),
        start_(start),
        length_(length),
        vertices_(std::make_unique_for_overwrite<Vertex[]>(start.size())),
        last_(start.size(), 0) {
    base::for_indices(start.size(), [&](std::size_t v) {
      vertices_[v] = {{}, start[v], static_cast<std::uint32_t>(v), kNone};
    });
    const bool shared = base::several_threads();
    base::for_indices(edges.size(), [&](std::size_t e) {
      if (!of_curves[e]) return;
      for (const std::uint32_t v : edges[e]) vertices_[v].left.add(static_cast<std::uint32_t>(e), shared);
    });
  }

  CurveFire run(std::span<const char> used, std::span<const std::uint32_t> blocks, bool by_arrival) {
    Vertices waiting = burn_zones(used, blocks);
    const Zone all({}, start_.size(), 0, 1);
    // Most that wait can go when others have gone.
    for (std::size_t before = ~std::size_t{0}; 2 * waiting.size() < before;) {
      before = waiting.size();
      const Vertices now = std::exchange(waiting, {});
      for (const std::uint32_t v : now) burn_or_wait(v, all, waiting);
    }
    for (;;) {
      for (const std::uint32_t v : waiting) queue_.push({vertices_[v].time, vertices_[v].turn, v});
      waiting.clear();
      if (queue_.empty()) break;
      const std::uint32_t v = std::get<2>(queue_.top());
      queue_.pop();
      burn_or_wait(burn(v), all, waiting);
    }
    time_last(by_arrival);
    CurveFire fire;
    fire.time.resize(start_.size());
    fire.exit.resize(start_.size());
    base::for_indices(start_.size(), [&](std::size_t v) {
      fire.exit[v] = vertices_[v].exit;
      fire.time[v] = fire.exit[v] != kNone || last_[v] ? vertices_[v].time : kNever;
    });
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
  using Vertices = std::vector<std::uint32_t>;

  // What one thread may look at and burn, while others burn other zones: a share of every block of vertices.
  class Zone {
   public:
    Zone(std::span<const std::uint32_t> blocks, std::size_t vertices, std::size_t zone, std::size_t zones) {
      std::size_t begin = 0;
      for (std::size_t i = 0; i <= blocks.size(); ++i) {
        const std::size_t end = i < blocks.size() ? blocks[i] : vertices;
        const auto [first, last] = base::part_of(end - begin, zone, zones);
        ranges_.push_back({begin + first, begin + last});
        begin = end;
      }
    }
    bool has(std::uint32_t v) const {
      for (const auto& [first, last] : ranges_)
        if (v < last) return v >= first;
      return false;
    }
    const std::vector<std::pair<std::size_t, std::size_t>>& ranges() const { return ranges_; }

   private:
    std::vector<std::pair<std::size_t, std::size_t>> ranges_;
  };

  // Burns what zones can by themselves; returns what waits then.
  Vertices burn_zones(std::span<const char> used, std::span<const std::uint32_t> blocks) {
    const auto zones = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    std::vector<Vertices> waiting(zones);
    tbb::parallel_for(std::size_t{0}, zones, [&](std::size_t z) {
      const Zone zone(blocks, start_.size(), z, zones);
      Vertices first;
      for (const auto& [begin, end] : zone.ranges())
        for (std::size_t v = begin; v < end; ++v) {
          const base::Cofaces left = vertices_[v].left;
          if (used[v] && start_[v] < kNever && (left.none() || left.single()))
            first.push_back(static_cast<std::uint32_t>(v));
        }
      for (const std::uint32_t v : first) burn_or_wait(v, zone, waiting[z]);
    });
    Vertices all;
    for (const Vertices& some : waiting) all.insert(all.end(), some.begin(), some.end());
    return all;
  }

  // Follows the fire from a vertex with at most one edge left, until it has to wait or stops at a junction. One that
  // waited may be the last by now.
  void burn_or_wait(std::uint32_t v, const Zone& zone, Vertices& waiting) {
    while (v != kNone) {
      if (!may_burn(v, zone)) return waiting.push_back(v);
      v = burn(v);
    }
  }

  // Whether nothing can come to a vertex over its only edge before it burns: not from the other end, nor, where just
  // one more edge is left there, from beyond that, and so on.
  bool may_burn(std::uint32_t v, const Zone& zone) const {
    constexpr int kFar = 16;
    const double time = vertices_[v].time;
    base::Cofaces left = vertices_[v].left;
    if (left.none()) return true;
    for (int step = 0; step < kFar && left.single(); ++step) {
      const std::uint32_t e = left.only();
      const auto [a, b] = edges_[e];
      v = a == v ? b : a;
      if (!zone.has(v)) return false;
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
  void time_last(bool by_arrival) {
    struct Arrival {
      std::uint32_t at;
      double from_time;
      std::uint32_t from_turn;
      double time;
    };
    const std::size_t chunks = base::chunks_for(edges_.size());
    std::vector<std::vector<Arrival>> found(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, end] = base::part_of(edges_.size(), chunk, chunks);
      for (std::size_t e = first; e < end; ++e) {
        const auto [a, b] = edges_[e];
        if (!of_curves_[e] || (!last_[a] && !last_[b])) continue;
        const Vertex& from = vertices_[last_[a] ? b : a];
        found[chunk].push_back({last_[a] ? a : b, from.time, from.turn, from.time + length_[e]});
      }
    });
    std::vector<Arrival> arrivals;
    for (const auto& some : found) arrivals.insert(arrivals.end(), some.begin(), some.end());
    std::sort(arrivals.begin(), arrivals.end(), [by_arrival](const Arrival& a, const Arrival& b) {
      if (by_arrival) return std::tie(a.at, a.time) < std::tie(b.at, b.time);
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
  std::unique_ptr<Vertex[]> vertices_;
  std::vector<char> last_;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue_;
};

}  // namespace

CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> of_curves,
                      std::span<const char> used, std::span<const double> start, std::span<const double> length,
                      std::span<const std::uint32_t> blocks, bool by_arrival) {
  return Fire(edges, of_curves, start, length).run(used, blocks, by_arrival);
}

}  // namespace quench::burning
