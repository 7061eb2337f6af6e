// SPDX-License-Identifier: Apache-2.0
#include "skeleton/branch_growth.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace quench::skeleton {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();

// Balls in an order, in a binary tree of boxes over their centres: node 1 is the root, leaf i node leaves + i.
class OrderedBalls {
 public:
  OrderedBalls(std::span<const Vec3> centres, std::span<const double> radii)
      : leaves_(std::bit_ceil(std::max<std::size_t>(centres.size(), 1))), nodes_(2 * leaves_) {
    for (std::size_t i = 0; i < centres.size(); ++i) nodes_[leaves_ + i] = {centres[i], centres[i], radii[i]};
    for (std::size_t n = leaves_ - 1; n > 0; --n) {
      const Node &a = nodes_[2 * n], &b = nodes_[2 * n + 1];
      nodes_[n] = {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high), std::max(a.radius, b.radius)};
    }
  }

  // The largest |x - centre| + radius of balls [first, last), or `least` where it is not above that.
  double farthest(const Vec3& x, std::size_t first, std::size_t last, double least) const {
    search(x, first, last, 1, 0, leaves_, least);
    return least;
  }

 private:
  struct Node {
    Vec3 low = Vec3::Constant(-kNothing), high = Vec3::Constant(kNothing);
    double radius = kNothing;
  };

  // No ball of the node is farther.
  double bound(const Vec3& x, std::size_t node) const {
    const Node& n = nodes_[node];
    return (x - n.low).cwiseAbs().cwiseMax((x - n.high).cwiseAbs()).norm() + n.radius;
  }
  void search(const Vec3& x, std::size_t first, std::size_t last, std::size_t node, std::size_t begin, std::size_t end,
              double& largest) const {
    if (end <= first || last <= begin || !(nodes_[node].radius > kNothing)) return;
    const double most = bound(x, node);
    if (!(most > largest)) return;
    if (end - begin == 1) {
      largest = most;
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    const bool right_first = bound(x, 2 * node + 1) > bound(x, 2 * node);
    for (const bool right : {right_first, !right_first})
      search(x, first, last, 2 * node + right, right ? middle : begin, right ? end : middle, largest);
  }

  std::size_t leaves_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<double> growth_to_contain(std::span<const StepInwards> steps, std::span<const Vec3> points,
                                      std::span<const double> times) {
  constexpr auto none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> step_of(points.size(), none), size(steps.size(), 1);
  for (std::size_t s = 0; s < steps.size(); ++s) step_of[steps[s].vertex] = s;
  const auto next = [&](std::size_t s) { return step_of[steps[s].to]; };
  for (std::size_t s = 0; s < steps.size(); ++s)
    if (next(s) != none) size[next(s)] += size[s];

  // Each step's vertex, then those whose ways pass it: what a step asks for is an interval.
  std::vector<std::size_t> place(steps.size()), free(steps.size());
  std::size_t end = 0;
  for (std::size_t s = steps.size(); s-- > 0;) {
    std::size_t& from = next(s) == none ? end : free[next(s)];
    place[s] = from;
    free[s] = from + 1;
    from += size[s];
  }
  std::vector<Vec3> centres(steps.size());
  std::vector<double> radii(steps.size());
  for (std::size_t s = 0; s < steps.size(); ++s) {
    centres[place[s]] = points[steps[s].vertex];
    radii[place[s]] = times[steps[s].vertex];
  }
  const OrderedBalls balls(centres, radii);
  std::vector<double> growth(steps.size());
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const double time = times[steps[s].vertex];
    growth[s] = balls.farthest(points[steps[s].vertex], place[s], place[s] + size[s], time) - time;
  }
  return growth;
}

}  // namespace quench::skeleton
