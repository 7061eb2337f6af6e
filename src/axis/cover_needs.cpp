// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning_in_parts.md
#include "axis/cover_needs.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "axis/cover.h"
#include "axis/length_unit.h"
#include "base/constants.h"
#include "base/parallel.h"

namespace quench::axis {
namespace {

std::vector<std::uint32_t> named(std::span<const std::uint8_t> flags) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < flags.size(); ++v)
    if (flags[v]) vertices.push_back(v);
  return vertices;
}

bool comes_before(const LatticePoint& p, const LatticePoint& q) {
  return std::array{p[2], p[1], p[0]} < std::array{q[2], q[1], q[0]};
}

// How far the paths that begin at some vertices may still go where they are nearest to their ends: `from` in units of
// length per vertex, -1 where none begins. -1 for vertices that they do not reach.
std::vector<double> lengths_left(const std::vector<double>& from, double longest, ShortestPaths& paths) {
  paths.restart(longest);
  for (std::uint32_t v = 0; v < from.size(); ++v)
    if (from[v] >= 0) paths.add_source(v, paths.longest() - std::min(from[v], paths.longest()));
  std::vector<double> left(from.size(), -1);
  const auto never = [](std::uint32_t) { return false; };
  for (std::uint32_t v; (v = paths.next(never)) != kNone;) left[v] = paths.longest() - paths.distance(v);
  return left;
}

// The length of the shortest path from each vertex to the nearest of some, not through those where stop(vertex,
// length).
template <class Stop>
std::vector<double> lengths_to(std::span<const std::uint32_t> ends, double longest, ShortestPaths& paths,
                               const Stop& stop) {
  paths.restart(longest);
  for (const std::uint32_t v : ends) paths.add_source(v);
  std::vector<double> length(paths.vertex_count(), base::kNever);
  const auto stop_at = [&](std::uint32_t v) { return stop(v, paths.distance(v)); };
  for (std::uint32_t v; (v = paths.next(stop_at)) != kNone;) length[v] = paths.distance(v);
  return length;
}

}  // namespace

CoverNeeds::CoverNeeds(const MedialAxis& axis, double least, const Vertices& vertices,
                       std::span<const LatticePoint> own, std::span<const LatticePoint> around,
                       const dual::bricks::Box& region, Context* context)
    : axis_(axis),
      least_(least),
      vertices_(vertices),
      region_(region),
      paths_(axis, kLengthUnit * least),
      thin_sites_(axis.sites.size(), 0),
      length_(axis.points.size(), -1),
      balls_(axis.points.size(), 0) {
  const BallTree kept(axis.points, axis.radius, named(vertices.significant));
  const auto add_uncovered = [&](std::span<const LatticePoint> sites) {
    const std::vector<char> uncovered = uncovered_sites(sites, axis.grid, kept, least, context);
    for (std::size_t s = 0; s < sites.size(); ++s)
      if (uncovered[s]) uncovered_.push_back(sites[s]);
  };
  add_uncovered(own);
  pending_ = uncovered_;
  add_uncovered(around);
  to_significant_ = lengths_to(named(vertices.significant), kLongestPath * least, paths_,
                               [](std::uint32_t, double) { return false; });
  const std::vector<std::uint8_t> thin = look_at_balls();
  for (std::size_t s = 0; s < uncovered_.size(); ++s) {
    if (!thin[s]) continue;
    thin_.push_back(position(s));
    const auto found = std::ranges::lower_bound(axis.sites, uncovered_[s], comes_before);
    if (found != axis.sites.end() && *found == uncovered_[s])
      thin_sites_[static_cast<std::size_t>(found - axis.sites.begin())] = 1;
  }
}

bool CoverNeeds::is_near_unknown_sites(std::uint32_t v, double length) const {
  const Vec3 at = axis_.grid.lattice(axis_.points[v]);
  for (std::size_t a = 0; a < 3; ++a) {
    const double steps = length / axis_.grid.spacing[static_cast<int>(a)], x = at[static_cast<int>(a)];
    const auto low = static_cast<double>(region_.low[a]), high = static_cast<double>(region_.high[a] - 1);
    if (x - steps < low && low > 0) return true;
    if (x + steps > high && high < static_cast<double>(axis_.grid.dims[a])) return true;
  }
  return false;
}

// A path from the balls near an uncovered site is not longer than the known way from them to what is significant, and
// neither is what is left of it at any vertex. Of the balls that make the part thick one must stay. Returns which sites
// may be of thin parts.
std::vector<std::uint8_t> CoverNeeds::look_at_balls() {
  const double longest = paths_.longest();
  const auto begin_at = [&](std::uint32_t v, double its) {
    const std::atomic_ref length(length_[v]);
    for (double before = length.load(std::memory_order_relaxed);
         before < its && !length.compare_exchange_weak(before, its, std::memory_order_relaxed);) {
    }
  };
  const auto keep_ball = [&](std::uint32_t v) { std::atomic_ref(balls_[v]).store(1, std::memory_order_relaxed); };
  const BallTree tree(axis_);
  std::vector<std::uint8_t> thin(uncovered_.size());
  const auto look = [&](std::size_t s, const std::vector<std::uint32_t>& around, std::vector<std::uint32_t>& near) {
    near.clear();
    double largest = 0, nearest = base::kNever;
    bool reaches_thick = false;  // what is significant, from a thick ball
    const Vec3 p = position(s);
    for (const std::uint32_t i : around) {
      const BallTree::Ball ball = tree.ball(i);
      if (!(outside(ball, p) < near_limit(least_))) continue;
      near.push_back(ball.vertex);
      largest = std::max(largest, ball.radius);
      const double its = to_significant_[ball.vertex];
      if (its < nearest) reaches_thick = false;
      nearest = std::min(nearest, its);
      reaches_thick |= its == nearest && its <= longest && ball.radius > kThin * least_;
    }
    thin[s] = largest <= kThin * least_;
    for (const std::uint32_t v : near) begin_at(v, std::min(nearest, longest));
    if (!near.empty() && !reaches_thick)
      keep_ball(std::ranges::max(near, {}, [&](std::uint32_t v) { return std::pair(axis_.radius[v], ~v); }));
  };
  for_blocks([&](std::span<const std::uint32_t> block, std::vector<std::uint32_t>& around,
                 std::vector<std::uint32_t>& near) {
    Vec3 low = position(block[0]), high = low;
    for (const std::uint32_t s : block) {
      low = low.cwiseMin(position(s));
      high = high.cwiseMax(position(s));
    }
    balls_near_box(tree, low, high, near_limit(least_), around);
    for (const std::uint32_t s : block) look(s, around, near);
  });
  return thin;
}

// Calls work(sites, list, list) for the uncovered sites of each box of 4^3 voxels, so that the tree is walked once for
// all of them; with lists to use.
template <class Work>
void CoverNeeds::for_blocks(const Work& work) const {
  const auto block_of = [&](std::uint32_t s) {
    const LatticePoint& p = uncovered_[s];
    return std::array{p[2] >> 2, p[1] >> 2, p[0] >> 2};
  };
  std::vector<std::uint32_t> order(uncovered_.size());
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(block_of(a), a) < std::pair(block_of(b), b);
  });
  std::vector<std::uint32_t> begin;
  for (std::uint32_t i = 0; i < order.size(); ++i)
    if (i == 0 || block_of(order[i]) != block_of(order[i - 1])) begin.push_back(i);
  begin.push_back(static_cast<std::uint32_t>(order.size()));
  struct Lists {
    std::vector<std::uint32_t> around, near;
  };
  tbb::enumerable_thread_specific<Lists> lists;
  base::for_indices(begin.size() - 1, [&](std::size_t b) {
    Lists& own = lists.local();
    work(std::span(order).subspan(begin[b], begin[b + 1] - begin[b]), own.around, own.near);
  });
}

// They begin and end at vertices, or lead from and to what is not known.
void CoverNeeds::begin_where_unknown() {
  const double longest = paths_.longest();
  base::for_indices(length_.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    const bool unknown_sites = is_near_unknown_sites(v, axis_.radius[v] + 2.01 * least_);
    if (vertices_.incomplete[v] || unknown_sites)
      length_[v] = std::max(length_[v], std::min(to_significant_[v], longest));
    if (unknown_sites) balls_[v] = 1;
  });
}

// Paths connect cells of thin parts with whatever is near, and lead to them from elsewhere.
std::vector<double> CoverNeeds::lengths_of_thin_paths(std::span<const std::uint8_t> thin) const {
  std::vector<double> length(thin.size(), -1);
  const std::vector<double> no_radius(thin_.size(), 0);
  std::vector<std::uint32_t> all(thin_.size());
  std::iota(all.begin(), all.end(), 0u);
  const BallTree sites(thin_, no_radius, std::move(all));
  const double away = (kLongestThinPath + kThin) * least_;
  for (std::uint32_t v = 0; v < length.size(); ++v) {
    double limit = away;
    if (thin[v] || (vertices_.incomplete[v] &&
                    (is_near_unknown_sites(v, away) || sites.nearest(axis_.points[v], limit) < sites.size())))
      length[v] = base::kNever;
  }
  return length;
}

CoverNeeds::Cells CoverNeeds::of_paths(std::span<const std::uint8_t> possible, std::span<const std::uint8_t> thin) {
  const double longest = kLongestPath * least_;
  paths_.restart(longest);
  begin_where_unknown();
  Cells cells{std::move(balls_), std::vector<std::uint8_t>(axis_.complex.edges.size(), 0)};
  const std::vector<double> left = lengths_left(length_, longest, paths_);
  // They may join others nearby.
  for (double& length : length_) length = std::min(length, kNearPath / kLengthUnit);
  const std::vector<double> near_left = lengths_left(length_, kNearPath * least_, paths_);
  std::vector<std::uint32_t> ends;
  for (std::uint32_t v = 0; v < left.size(); ++v)
    if ((possible[v] || vertices_.incomplete[v]) && left[v] >= 0) ends.push_back(v);
  std::vector<double> to_end =
      lengths_to(ends, longest, paths_, [&](std::uint32_t v, double length) { return left[v] < length; });
  for (std::size_t v = 0; v < left.size(); ++v) {
    to_end[v] = std::min(to_end[v], to_significant_[v]);
    if (left[v] >= to_end[v]) cells.vertex[v] = 1;
  }
  const std::vector<double> thin_left = lengths_left(lengths_of_thin_paths(thin), kLongestThinPath * least_, paths_);
  for (std::size_t v = 0; v < left.size(); ++v)
    if (thin_left[v] >= 0 || near_left[v] >= 0) cells.vertex[v] = 1;
  for (std::uint32_t e = 0; e < cells.edge.size(); ++e) {
    const auto [a, b] = axis_.complex.edges[e];
    const double length = paths_.length(e);
    cells.edge[e] = (thin_left[a] >= 0 && thin_left[b] >= 0) || (near_left[a] >= 0 && near_left[b] >= 0) ||
                    left[a] - length >= to_end[b] || left[b] - length >= to_end[a];
  }
  return cells;
}

}  // namespace quench::axis
