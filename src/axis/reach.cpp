// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning.md, "Larger details"
#include "axis/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axis/ball_tree.h"
#include "base/constants.h"
#include "base/union_find.h"

namespace quench::axis {
namespace {

// Of the vertices raised one by one, those after them need not be raised as far: less than this factor more would make
// each a little more than the one before.
constexpr double kHeadroom = 1.25;
// Details up to this factor of the automatic one are not made as small as they could be: in thin parts that would be a
// search without end for each vertex.
constexpr double kEnough = 2;
// A factor of the automatic detail, and what of a unit counts as rounding: together a billionth of the detail.
constexpr double kLengthUnit = 0x1p-20, kOfUnit = 1e-3;

class Reach {
 public:
  Reach(const MedialAxis& axis, double least, std::vector<double>& detail)
      : axis_(axis), least_(least), detail_(detail), tree_(axis.points, axis.radius, vertices()) {
    most_.assign(tree_.node_count(), -1);
    detail_of_ball_.assign(tree_.balls().size(), -1);
    leans_on_.assign(tree_.balls().size(), kNone);
  }

  void run(Context* context) {
    const std::vector<std::uint32_t> order = by_detail();
    make_roots_infinite(order);
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i % 4096 == 0)
        checkpoint(context, "detail", 0.6 + 0.4 * static_cast<double>(i) / static_cast<double>(order.size()));
      const std::uint32_t ball = order[i];
      double& detail = detail_[tree_.balls()[ball].vertex];
      if (const double needed = reach_of(ball, std::max(detail, kEnough * least_)); needed > detail)
        detail = needed > kEnough * least_ ? kHeadroom * needed : needed;
      put(ball, detail);
    }
  }

 private:
  std::vector<std::uint32_t> vertices() const {
    std::vector<std::uint32_t> found;
    for (std::uint32_t v = 0; v < detail_.size(); ++v)
      if (detail_[v] >= least_) found.push_back(v);
    return found;
  }
  // Balls by descending detail, then radius, then vertex.
  std::vector<std::uint32_t> by_detail() const {
    std::vector<std::uint32_t> order(tree_.balls().size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const BallTree::Ball &p = tree_.balls()[a], &q = tree_.balls()[b];
      if (detail_[p.vertex] != detail_[q.vertex]) return detail_[p.vertex] > detail_[q.vertex];
      return p.radius != q.radius ? p.radius > q.radius : p.vertex < q.vertex;
    });
    return order;
  }
  void make_roots_infinite(const std::vector<std::uint32_t>& order) {
    base::UnionFind sets(axis_.complex.vertex_count);
    for (const auto& ends : axis_.complex.edges) sets.unite(ends[0], ends[1]);
    std::vector<char> has_root(axis_.complex.vertex_count, 0);
    for (const std::uint32_t ball : order) {
      const std::uint32_t vertex = tree_.balls()[ball].vertex, set = sets.find(vertex);
      if (!has_root[set]) detail_[vertex] = base::kNever;
      has_root[set] = 1;
      if (detail_[vertex] == base::kNever) put(ball, base::kNever);
    }
  }
  void put(std::size_t ball, double detail) {
    detail_of_ball_[ball] = detail;
    for (std::size_t n = tree_.leaf_of(ball); n > 0 && most_[n] < detail; n /= 2) most_[n] = detail;
  }

  // A d down to which, from infinity on, balls of detail d or more, grown by 2 (d - least), contain `ball`: the least
  // one, or one that is not above `enough`.
  double reach_of(std::uint32_t ball, double enough) {
    double d = std::numeric_limits<double>::infinity();
    lean_as_neighbour(ball, d);
    for (double before = -1; before != d && d > enough;) {
      before = d;
      double limit = d;  // of the walk: d, or nothing when that is enough
      const auto bound = [&](std::size_t node) {
        if (most_[node] < d) return std::numeric_limits<double>::infinity();
        const BallTree::Ball& own = tree_.balls()[ball];
        return needed_for(tree_.distance(node, own.centre) + own.radius - tree_.largest_radius(node));
      };
      tree_.walk(bound, limit, [&](std::size_t other) {
        lean(ball, static_cast<std::uint32_t>(other), d);
        limit = d > enough ? d : 0;
      });
    }
    return d;
  }
  // Lowers d to what another ball allows.
  void lean(std::uint32_t ball, std::uint32_t other, double& d) {
    if (detail_of_ball_[other] < d) return;
    if (const double needed = between(ball, other); needed < d) {
      d = needed;
      leans_on_[ball] = other;
    }
  }
  // What a decided ball nearby leans on is mostly right for its neighbours, too.
  void lean_as_neighbour(std::uint32_t ball, double& d) {
    constexpr std::uint32_t kAround = 16;  // along the Z-order curve
    const std::uint32_t first = ball / kAround * kAround;
    std::uint32_t nearest = kNone;
    for (std::uint32_t i = first; i < first + kAround && i < tree_.balls().size(); ++i)
      if (detail_of_ball_[i] >= 0 && (nearest == kNone || between(ball, i) < between(ball, nearest))) nearest = i;
    chain_.clear();
    for (std::uint32_t i = nearest; i != kNone && chain_.size() < 64; i = leans_on_[i]) chain_.push_back(i);
    for (auto i = chain_.rbegin(); i != chain_.rend(); ++i) lean(ball, *i, d);
  }
  double between(std::uint32_t ball, std::uint32_t other) const {
    const BallTree::Ball &a = tree_.balls()[ball], &b = tree_.balls()[other];
    return needed_for((a.centre - b.centre).norm() + a.radius - b.radius);
  }
  // The detail from which on a ball that sticks out by so much of another may be left to it.
  // A multiple of a small unit, since rounding depends on where a shape lies, and what is kept must not.
  double needed_for(double sticks_out) const {
    const double unit = kLengthUnit * least_;
    return least_ + 0.5 * unit * std::max(0.0, std::ceil(sticks_out / unit - kOfUnit));
  }

  const MedialAxis& axis_;
  double least_;
  std::vector<double>& detail_;
  BallTree tree_;
  std::vector<double> most_, detail_of_ball_;  // per node the largest, and per ball: of what is decided; -1 before
  std::vector<std::uint32_t> leans_on_;        // per ball: the last one that it was found to be in reach of
  std::vector<std::uint32_t> chain_;
};

}  // namespace

void keep_within_reach(const MedialAxis& axis, double least, std::vector<double>& vertex_detail, Context* context) {
  Reach(axis, least, vertex_detail).run(context);
}

}  // namespace quench::axis
