// SPDX-License-Identifier: Apache-2.0
#include "axis/ball_tree.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "base/rounded_down.h"
#include "base/z_order.h"

namespace quench::axis {
namespace {

constexpr int kBits = 21;  // of a coordinate: 63 bits of a key

struct Keyed {
  std::uint64_t key;
  std::uint32_t vertex;
  friend auto operator<=>(const Keyed&, const Keyed&) = default;
};

std::vector<Keyed> in_z_order(std::span<const Vec3> points, const std::vector<std::uint32_t>& vertices) {
  std::vector<Keyed> order(vertices.size());
  if (vertices.empty()) return order;
  Vec3 low = points[vertices[0]], high = low;
  for (const std::uint32_t v : vertices) {
    low = low.cwiseMin(points[v]);
    high = high.cwiseMax(points[v]);
  }
  const double size = (high - low).maxCoeff();
  const double scale = size > 0 ? ((1 << kBits) - 1) / size : 0;
  base::for_indices(vertices.size(), [&](std::size_t i) {
    const Vec3 at = (points[vertices[i]] - low) * scale;
    const auto whole = [&](int a) { return static_cast<std::uint64_t>(at[a]); };
    order[i] = {base::z_order(whole(2), whole(1), whole(0)), vertices[i]};
  });
  tbb::parallel_sort(order.begin(), order.end());
  return order;
}

float rounded_up(double x) { return -base::rounded_down(-x); }

}  // namespace

BallTree::BallTree(std::span<const Vec3> points, std::span<const double> radius, std::vector<std::uint32_t> vertices)
    : points_(points), radius_(radius), vertices_(std::move(vertices)) {
  {
    const std::vector<Keyed> order = in_z_order(points, vertices_);
    for (std::size_t i = 0; i < order.size(); ++i) vertices_[i] = order[i].vertex;
  }
  if (!vertices_.empty()) origin_ = points_[vertices_[0]];
  leaves_ = std::bit_ceil(size() / kLeaf + 1);
  constexpr float kEmpty = std::numeric_limits<float>::infinity();
  nodes_.resize(2 * leaves_, {{kEmpty, kEmpty, kEmpty}, {-kEmpty, -kEmpty, -kEmpty}, -kEmpty});
  base::for_indices(leaves_, [&](std::size_t leaf) { fill_leaf(leaf); });
  for (std::size_t n = leaves_ - 1; n > 0; --n) {
    const Node &p = nodes_[2 * n], &q = nodes_[2 * n + 1];
    for (int a = 0; a < 3; ++a) {
      nodes_[n].low[a] = std::min(p.low[a], q.low[a]);
      nodes_[n].high[a] = std::max(p.high[a], q.high[a]);
    }
    nodes_[n].largest_radius = std::max(p.largest_radius, q.largest_radius);
  }
}

BallTree::BallTree(const MedialAxis& axis)
    : BallTree(axis.points_of_voxels(), axis.radius_of_voxels(), [&] {
        std::vector<std::uint32_t> all(axis.points.size());
        std::iota(all.begin(), all.end(), 0u);
        return all;
      }()) {}

void BallTree::fill_leaf(std::size_t leaf) {
  Node& node = nodes_[leaves_ + leaf];
  for (std::size_t i = leaf * kLeaf; i < leaf * kLeaf + kLeaf && i < size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      const double x = points_[vertices_[i]][a] - origin_[a];
      node.low[a] = std::min(node.low[a], base::rounded_down(x));
      node.high[a] = std::max(node.high[a], rounded_up(x));
    }
    node.largest_radius = std::max(node.largest_radius, rounded_up(radius_[vertices_[i]]));
  }
}

std::size_t NearBalls::entry(std::int64_t x, std::int64_t y) const {
  const auto cell = [](std::int64_t at, std::int64_t least) { return static_cast<std::size_t>((at >> 2) & least); };
  // Sites of a plane come row by row: those above matter, as far as the image is wide.
  return grid_.is_plane() ? cell(x, 0x3fff) | cell(y, 3) << 14 : cell(x, 255) | cell(y, 255) << 8;
}

bool NearBalls::find(const LatticePoint& site, double enough, double& limit) {
  const Vec3 p = grid_.world_of(site);
  std::uint32_t& ball = last_[entry(site[0], site[1])];
  const std::size_t none = tree_.size();
  bool found = false;
  const auto try_ball = [&](std::uint32_t other) {
    if (other >= none) return false;
    const double away = outside(tree_.ball(other), p);
    if (!(away < limit)) return false;
    limit = away;
    ball = other;
    found = true;
    return away <= enough;
  };
  if (try_ball(ball)) return true;
  if (grid_.is_plane())  // squares that were left and above before this one was met
    for (const auto& [dx, dy] : {std::pair{-4, 0}, {0, -4}, {4, -4}, {-4, -4}})
      if (try_ball(last_[entry(site[0] + dx, site[1] + dy)])) return true;
  if (const std::size_t nearer = tree_.near(p, enough, limit); nearer < none) {
    ball = static_cast<std::uint32_t>(nearer);
    found = true;
  }
  return found;
}

std::size_t BallTree::near(const Vec3& p, double enough, double& limit) const {
  std::size_t found = size();
  double bar = limit;  // of the walk: nothing passes it once there is enough
  const auto bound = [&](std::size_t node) {
    const double largest = largest_radius(node);
    return largest < 0 ? std::numeric_limits<double>::infinity() : distance(node, p) - largest;
  };
  walk(bound, bar, [&](std::size_t i) {
    const double away = outside(ball(i), p);
    if (!(away < limit)) return;
    limit = away;
    found = i;
    bar = away > enough ? away : -std::numeric_limits<double>::infinity();
  });
  return found;
}

}  // namespace quench::axis
