// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning.md, "The promise"
#include "axis/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axis/ball_tree.h"
#include "axis/length_unit.h"
#include "base/constants.h"
#include "base/csr.h"
#include "base/sorted_by_key.h"
#include "base/union_find.h"

namespace quench::axis {
namespace {

// Of vertices raised one after the other, later ones need not be raised as far: without headroom each would be raised a
// little more than the one before.
constexpr double kHeadroom = 1.25;
// Details up to this factor of the automatic one are not made as small as they could be, which would be a search for
// each vertex of thin parts.
constexpr double kEnough = 3;
// So much of a unit of length counts as rounding: together a billionth of the detail.
constexpr double kOfUnit = 1e-3;

// Vertices are decided by descending detail. For one of detail m it is to be shown that for every d > m a decided
// vertex of detail d or more has a ball that contains its own when it is grown by 2 (d - least). Half of that is for
// balls that are searched for: with them `d` is enough down to which, from infinity on, one grown by d - least contains
// its own. The other half is for neighbours: the ball of a vertex lies in that of a decided neighbour grown by what it
// sticks out, and so in those the neighbour lies in; what adds up on the way, its *debt*, must not be above m - least.
class Reach {
 public:
  Reach(const MedialAxis& axis, double least, CellValues& detail)
      : axis_(axis), least_(least), detail_(detail.vertex), tree_(axis.points, axis.radius, vertices()) {
    most_.assign(tree_.node_count(), -1);
    detail_of_ball_.assign(tree_.size(), -1);
    debt_.assign(tree_.size(), 0);
    link_neighbours(detail.edge);
  }

  void run(Context* context) {
    const std::vector<std::uint32_t> order = by_detail();
    make_roots_infinite(order);
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i % 4096 == 0)
        checkpoint(context, "detail", 0.6 + 0.4 * static_cast<double>(i) / static_cast<double>(order.size()));
      decide(order[i]);
    }
  }

 private:
  std::vector<std::uint32_t> vertices() const {
    std::vector<std::uint32_t> found;
    for (std::uint32_t v = 0; v < detail_.size(); ++v)
      if (detail_[v] >= least_) found.push_back(v);
    return found;
  }
  void link_neighbours(const std::vector<double>& edge_detail) {
    std::vector<std::uint32_t> ball_of(axis_.complex.vertex_count, kNone);
    for (std::uint32_t i = 0; i < tree_.size(); ++i) ball_of[tree_.ball(i).vertex] = i;
    neighbours_ = base::Csr<std::uint32_t>::group(tree_.size(), [&](const auto& emit) {
      for (std::size_t e = 0; e < edge_detail.size(); ++e) {
        if (edge_detail[e] < least_) continue;
        const auto [u, v] = axis_.complex.edges[e];
        emit(ball_of[u], ball_of[v]);
        emit(ball_of[v], ball_of[u]);
      }
    });
  }
  // Balls by descending detail, then radius, then vertex.
  std::vector<std::uint32_t> by_detail() const {
    return base::sorted_by_key_descending(
        tree_.size(), std::numeric_limits<std::ptrdiff_t>::max(),
        [&](std::size_t i) { return detail_[tree_.ball(i).vertex]; },
        [&](std::uint32_t a, std::uint32_t b) {
          const BallTree::Ball p = tree_.ball(a), q = tree_.ball(b);
          return p.radius != q.radius ? p.radius > q.radius : p.vertex < q.vertex;
        });
  }
  void make_roots_infinite(const std::vector<std::uint32_t>& order) {
    base::UnionFind sets(axis_.complex.vertex_count);
    for (const auto& ends : axis_.complex.edges) sets.unite(ends[0], ends[1]);
    std::vector<char> has_root(axis_.complex.vertex_count, 0);
    for (const std::uint32_t ball : order) {
      const std::uint32_t vertex = tree_.ball(ball).vertex, set = sets.find(vertex);
      if (!has_root[set]) detail_[vertex] = base::kNever;
      has_root[set] = 1;
      if (detail_[vertex] == base::kNever) put(ball, base::kNever);
    }
  }
  void decide(std::uint32_t ball) {
    double& detail = detail_[tree_.ball(ball).vertex];
    if (detail == base::kNever) return;
    const double enough = std::max(detail, kEnough * least_);
    const double debt = least_debt(ball);
    if (const double needed = least_ + debt; needed <= enough) {
      debt_[ball] = debt;
      detail = std::max(detail, needed);
    } else if (const double reached = reach_of(ball, enough); reached > detail) {
      detail = reached > enough ? kHeadroom * reached : reached;
    }
    put(ball, detail);
  }
  void put(std::size_t ball, double detail) {
    detail_of_ball_[ball] = detail;
    for (std::size_t n = tree_.leaf_of(ball); n > 0 && most_[n] < detail; n /= 2) most_[n] = detail;
  }

  double least_debt(std::uint32_t ball) const {
    double least = base::kNever;
    for (const std::uint32_t other : neighbours_[ball])
      if (detail_of_ball_[other] >= 0) least = std::min(least, debt_[other] + sticks_out(ball, other));
    return least;
  }
  // A d down to which, from infinity on, balls of detail d or more, grown by d - least, contain `ball`: the least one,
  // or one that is not above `enough`.
  double reach_of(std::uint32_t ball, double enough) const {
    const BallTree::Ball own = tree_.ball(ball);
    double d = std::numeric_limits<double>::infinity();
    for (double before = -1; before != d && d > enough;) {
      before = d;
      double limit = d;  // of the walk: d, or nothing when that is enough
      const auto bound = [&](std::size_t node) {
        if (most_[node] < d) return std::numeric_limits<double>::infinity();
        return least_ + whole(tree_.distance(node, own.centre) + own.radius - tree_.largest_radius(node));
      };
      tree_.walk(bound, limit, [&](std::size_t other) {
        if (detail_of_ball_[other] < d) return;
        d = std::min(d, least_ + sticks_out(ball, static_cast<std::uint32_t>(other)));
        limit = d > enough ? d : 0;
      });
    }
    return d;
  }
  // By how much a ball sticks out of another one.
  double sticks_out(std::uint32_t ball, std::uint32_t other) const {
    const BallTree::Ball a = tree_.ball(ball), b = tree_.ball(other);
    return whole((a.centre - b.centre).norm() + a.radius - b.radius);
  }
  double whole(double length) const {
    const double unit = kLengthUnit * least_;
    return unit * std::max(0.0, std::ceil(length / unit - kOfUnit));
  }

  const MedialAxis& axis_;
  double least_;
  std::vector<double>& detail_;
  BallTree tree_;
  base::Csr<std::uint32_t> neighbours_;        // balls whose vertices share an edge that is kept
  std::vector<double> most_, detail_of_ball_;  // per node the largest, and per ball: of what is decided; -1 before
  std::vector<double> debt_;                   // per ball
};

}  // namespace

void keep_within_reach(const MedialAxis& axis, double least, CellValues& detail, Context* context) {
  Reach(axis, least, detail).run(context);
}

}  // namespace quench::axis
