// SPDX-License-Identifier: Apache-2.0
#include "envelope/element_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "base/rounded_down.h"

namespace quench::envelope {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Halved along the longest side of the box of the middles, again and again, so that leaves hold neighbours.
void halve(std::vector<std::uint32_t>& rows, const std::vector<Vec3>& middles, std::size_t first, std::size_t end,
           std::size_t leaves) {
  const auto at = [&](std::size_t leaf) { return base::part_of(rows.size(), leaf, leaves).first; };
  const std::size_t middle = first + (end - first) / 2, from = at(first), to = end == leaves ? rows.size() : at(end),
                    half = at(middle);
  if (end - first < 2 || to - from < 2) return;
  Vec3 low = Vec3::Constant(kInfinite), high = -low;
  for (std::size_t i = from; i < to; ++i) {
    low = low.cwiseMin(middles[rows[i]]);
    high = high.cwiseMax(middles[rows[i]]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const auto begin = rows.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(from), begin + static_cast<std::ptrdiff_t>(half),
                   begin + static_cast<std::ptrdiff_t>(to), [&](std::uint32_t a, std::uint32_t b) {
                     const double x = middles[a][axis], y = middles[b][axis];
                     return x != y ? x < y : a < b;
                   });
  constexpr std::size_t kTask = 4096;
  if (to - from < kTask) {
    halve(rows, middles, first, middle, leaves);
    halve(rows, middles, middle, end, leaves);
  } else {
    tbb::parallel_invoke([&] { halve(rows, middles, first, middle, leaves); },
                         [&] { halve(rows, middles, middle, end, leaves); });
  }
}

float up(double x) { return -base::rounded_down(-x); }

}  // namespace

ElementTree::ElementTree(std::vector<Element> elements) : rows_(elements.size()) {
  std::iota(rows_.begin(), rows_.end(), 0u);
  leaves_ = std::bit_ceil(std::max<std::size_t>(1, (elements.size() + kLeaf - 1) / kLeaf));
  std::vector<Vec3> middles(elements.size());
  base::for_indices(elements.size(), [&](std::size_t i) {
    middles[i] = elements[i].corner(0);
    for (int k = 1; k < elements[i].corners(); ++k) middles[i] += elements[i].corner(k);
    middles[i] /= elements[i].corners();
  });
  halve(rows_, middles, 0, leaves_, leaves_);
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf)
    first_.push_back(static_cast<std::uint32_t>(base::part_of(elements.size(), leaf, leaves_).first));
  first_.push_back(static_cast<std::uint32_t>(elements.size()));
  elements_.reserve(elements.size());
  for (const std::uint32_t row : rows_) elements_.push_back(elements[row]);
  if (!elements_.empty()) origin_ = elements_[0].corner(0);
  constexpr float kEmpty = std::numeric_limits<float>::infinity();
  nodes_.resize(2 * leaves_, {{kEmpty, kEmpty, kEmpty},
                              {-kEmpty, -kEmpty, -kEmpty},
                              {kEmpty, kEmpty, kEmpty},
                              {-kEmpty, -kEmpty, -kEmpty},
                              -kEmpty});
  base::for_indices(leaves_, [&](std::size_t leaf) { fill_leaf(leaf); });
  for (std::size_t n = leaves_ - 1; n > 0; --n) {
    const Node &p = nodes_[2 * n], &q = nodes_[2 * n + 1];
    for (int a = 0; a < 3; ++a) {
      nodes_[n].low[a] = std::min(p.low[a], q.low[a]);
      nodes_[n].high[a] = std::max(p.high[a], q.high[a]);
      nodes_[n].axis_low[a] = std::min(p.axis_low[a], q.axis_low[a]);
      nodes_[n].axis_high[a] = std::max(p.axis_high[a], q.axis_high[a]);
    }
    nodes_[n].largest_radius = std::max(p.largest_radius, q.largest_radius);
  }
}

void ElementTree::fill_leaf(std::size_t leaf) {
  Node& node = nodes_[leaves_ + leaf];
  for (std::size_t i = first_[leaf]; i < first_[leaf + 1]; ++i)
    for (int k = 0; k < elements_[i].corners(); ++k) {
      const Vec3 at = elements_[i].corner(k) - origin_;
      const double r = elements_[i].radius(k);
      for (int a = 0; a < 3; ++a) {
        node.low[a] = std::min(node.low[a], base::rounded_down(at[a] - r));
        node.high[a] = std::max(node.high[a], up(at[a] + r));
        node.axis_low[a] = std::min(node.axis_low[a], base::rounded_down(at[a]));
        node.axis_high[a] = std::max(node.axis_high[a], up(at[a]));
      }
      node.largest_radius = std::max(node.largest_radius, up(r));
    }
}

double ElementTree::bound(std::size_t node, const Vec3& p) const {
  const Node& n = nodes_[node];
  if (n.largest_radius < 0) return kInfinite;
  double squared = 0, axis_squared = 0, inside = -kInfinite;
  for (int a = 0; a < 3; ++a) {
    const double beyond = std::max(static_cast<double>(n.low[a]) - p[a], p[a] - static_cast<double>(n.high[a]));
    if (beyond > 0) squared += beyond * beyond;
    inside = std::max(inside, beyond);
    const double off = std::max(static_cast<double>(n.axis_low[a]) - p[a], p[a] - static_cast<double>(n.axis_high[a]));
    if (off > 0) axis_squared += off * off;
  }
  return std::max(squared > 0 ? std::sqrt(squared) : inside,
                  std::sqrt(axis_squared) - static_cast<double>(n.largest_radius));
}

template <class Visit>
void ElementTree::walk(const Vec3& p, const double& limit, const Visit& visit) const {
  if (elements_.empty()) return;
  struct Deferred {
    std::size_t node;
    double bound;
  };
  std::array<Deferred, 64> stack;
  std::size_t depth = 0;
  const Vec3 at = p - origin_;
  for (Deferred now{1, bound(1, at)};;) {
    if (now.bound < limit) {
      if (now.node >= leaves_) {
        const std::size_t leaf = now.node - leaves_;
        for (std::size_t i = first_[leaf]; i < first_[leaf + 1]; ++i) visit(i);
      } else {
        Deferred left{2 * now.node, bound(2 * now.node, at)}, right{2 * now.node + 1, bound(2 * now.node + 1, at)};
        if (right.bound < left.bound) std::swap(left, right);
        if (right.bound < limit) stack[depth++] = right;
        now = left;
        continue;
      }
    }
    if (depth == 0) return;
    now = stack[--depth];
  }
}

ElementTree::Near ElementTree::nearest(const Vec3& p, double within, double enough) const {
  Near best;
  best.ball.distance = within;
  double limit = within;
  walk(p, limit, [&](std::size_t i) {
    if (!(elements_[i].bound(p) < limit)) return;
    const NearBall near = elements_[i].nearest(p);
    if (!(near.distance < best.ball.distance)) return;
    best = {near, rows_[i]};
    limit = near.distance > enough ? near.distance : -kInfinite;
  });
  return best;
}

bool ElementTree::contains(const Vec3& p, double slack) const {
  const double most = slack * std::max(0.0, static_cast<double>(nodes_[1].largest_radius));
  double limit = std::nextafter(most, kInfinite);
  bool found = false;
  walk(p, limit, [&](std::size_t i) {
    if (found || !(elements_[i].bound(p) < limit)) return;
    const NearBall near = elements_[i].nearest(p);
    if (!(near.distance <= slack * near.radius)) return;
    found = true;
    limit = -kInfinite;
  });
  return found;
}

}  // namespace quench::envelope
