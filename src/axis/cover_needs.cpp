// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning_in_parts.md
#include "axis/cover_needs.h"

#include <algorithm>
#include <array>
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
    : axis_(axis), least_(least), vertices_(vertices), region_(region), tree_(axis), thin_sites_(axis.sites.size(), 0) {
  const BallTree kept(axis.points, axis.radius, named(vertices.significant));
  const auto add_uncovered = [&](std::span<const LatticePoint> sites) {
    const std::vector<char> uncovered = uncovered_sites(sites, axis.grid, kept, least, context);
    for (std::size_t s = 0; s < sites.size(); ++s)
      if (uncovered[s]) uncovered_.push_back(sites[s]);
  };
  add_uncovered(own);
  pending_ = uncovered_;
  add_uncovered(around);
  std::vector<char> thin(uncovered_.size());
  base::for_indices(uncovered_.size(), [&](std::size_t s) {
    double largest = 0;
    for_balls_near(tree_, position(s), near_limit(least),
                   [&](const BallTree::Ball& ball) { largest = std::max(largest, ball.radius); });
    thin[s] = largest <= kThin * least;
  });
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
// neither is what is left of it at any vertex. Of the balls that make the part thick one must stay.
std::vector<double> CoverNeeds::lengths_of_paths(const std::vector<double>& to_significant, double longest,
                                                 std::vector<std::uint8_t>& balls) const {
  std::vector<double> length(to_significant.size(), -1);
  const auto begin_at = [&](std::uint32_t v, double its) { length[v] = std::max(length[v], its); };
  std::vector<std::uint32_t> near;
  for (std::size_t s = 0; s < uncovered_.size(); ++s) {
    near.clear();
    for_balls_near(tree_, position(s), near_limit(least_),
                   [&](const BallTree::Ball& ball) { near.push_back(ball.vertex); });
    if (near.empty()) continue;
    const auto nearest = std::ranges::min(near, {}, [&](std::uint32_t v) { return to_significant[v]; });
    for (const std::uint32_t v : near) begin_at(v, std::min(to_significant[nearest], longest));
    if (to_significant[nearest] <= longest && axis_.radius[nearest] > kThin * least_) continue;
    balls[std::ranges::max(near, {}, [&](std::uint32_t v) { return std::pair(axis_.radius[v], ~v); })] = 1;
  }
  for (std::uint32_t v = 0; v < length.size(); ++v) {
    if (vertices_.incomplete[v]) begin_at(v, std::min(to_significant[v], longest));
    if (!is_near_unknown_sites(v, axis_.radius[v] + 2.01 * least_)) continue;
    begin_at(v, std::min(to_significant[v], longest));
    balls[v] = 1;
  }
  return length;
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

CoverNeeds::Cells CoverNeeds::of_paths(std::span<const std::uint8_t> possible,
                                       std::span<const std::uint8_t> thin) const {
  Cells cells{std::vector<std::uint8_t>(axis_.points.size(), 0),
              std::vector<std::uint8_t>(axis_.complex.edges.size(), 0)};
  const double longest = kLongestPath * least_;
  ShortestPaths paths(axis_, kLengthUnit * least_);
  const std::vector<double> to_significant =
      lengths_to(named(vertices_.significant), longest, paths, [](std::uint32_t, double) { return false; });
  std::vector<double> begin = lengths_of_paths(to_significant, paths.longest(), cells.vertex);
  const std::vector<double> left = lengths_left(begin, longest, paths);
  // They may join others nearby.
  for (double& length : begin) length = std::min(length, kNearPath / kLengthUnit);
  const std::vector<double> near_left = lengths_left(begin, kNearPath * least_, paths);
  std::vector<std::uint32_t> ends;
  for (std::uint32_t v = 0; v < left.size(); ++v)
    if ((possible[v] || vertices_.incomplete[v]) && left[v] >= 0) ends.push_back(v);
  std::vector<double> to_end =
      lengths_to(ends, longest, paths, [&](std::uint32_t v, double length) { return left[v] < length; });
  for (std::size_t v = 0; v < left.size(); ++v) {
    to_end[v] = std::min(to_end[v], to_significant[v]);
    if (left[v] >= to_end[v]) cells.vertex[v] = 1;
  }
  const std::vector<double> thin_left = lengths_left(lengths_of_thin_paths(thin), kLongestThinPath * least_, paths);
  for (std::size_t v = 0; v < left.size(); ++v)
    if (thin_left[v] >= 0 || near_left[v] >= 0) cells.vertex[v] = 1;
  for (std::uint32_t e = 0; e < cells.edge.size(); ++e) {
    const auto [a, b] = axis_.complex.edges[e];
    const double length = paths.length(e);
    cells.edge[e] = (thin_left[a] >= 0 && thin_left[b] >= 0) || (near_left[a] >= 0 && near_left[b] >= 0) ||
                    left[a] - length >= to_end[b] || left[b] - length >= to_end[a];
  }
  return cells;
}

}  // namespace quench::axis
