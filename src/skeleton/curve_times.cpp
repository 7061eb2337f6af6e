// SPDX-License-Identifier: Apache-2.0
#include "skeleton/curve_times.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/parallel.h"
#include "burning/curve_fire.h"
#include "skeleton/member.h"

namespace quench::skeleton {
namespace {

// How far a course runs straight, in burn times. Shorter, and the zigzag counts; longer, and bends are cut off: of the
// values from 0.2 to 1 this is right to a few per cent on bumps, capsules, cones and boxes.
constexpr double kReach = 0.3;

// A dual that passed the fire on lies on the door it went to.
std::uint32_t place(const RefinedAxis& axis, std::uint32_t v) {
  return axis.exit[v] == kNone ? v : other_end(axis, axis.exit[v], v);
}

// Times of a fire over courses that are tight instead of the zigzag from door to door. At every vertex v the course
// that comes last runs straight from an anchor on it, which follows behind v at up to one burn time: the curve sees the
// shape no finer than the ball there. Never later than `fire`, and never earlier than the vertex before or the start.
class TightTimes {
 public:
  TightTimes(const RefinedAxis& axis, burning::CurveFire& fire, std::size_t halves)
      : axis_(axis), fire_(fire), halves_(halves), waits_for_(fire.time.size(), 0), anchor_(fire.time.size()) {}

  void run() {
    const auto n = static_cast<std::uint32_t>(fire_.time.size());
    std::vector<std::uint32_t> dropped(n, kNone);  // at the last of a tree: the neighbour that burns last
    for (std::uint32_t v = 0; v < n; ++v) {
      anchor_[v] = v;
      if (fire_.exit[v] == kNone) continue;
      const std::uint32_t to = next(v);
      ++waits_for_[to];
      if (fire_.last[to] && (dropped[to] == kNone || fire_.time[v] >= fire_.time[dropped[to]])) dropped[to] = v;
    }
    std::vector<char> leaf(n);
    for (std::uint32_t v = 0; v < n; ++v) leaf[v] = waits_for_[v] == 0 && fire_.exit[v] != kNone;
    base::for_indices(n, [&](std::size_t v) {
      if (fire_.exit[v] != kNone || fire_.last[v]) fire_.time[v] = axis_.burn_time[v];
    });
    for (std::uint32_t first = 0; first < n; ++first) {
      if (!leaf[first]) continue;
      for (std::uint32_t v = first; fire_.exit[v] != kNone;) {
        const std::uint32_t to = next(v);
        if (dropped[to] != v) arrive(v, to);
        if (--waits_for_[to] > 0) break;
        v = to;
      }
    }
  }

 private:
  std::uint32_t next(std::uint32_t v) const {
    return other_end(axis_, fire_.exit[v] + static_cast<std::uint32_t>(halves_), v);
  }
  void arrive(std::uint32_t from, std::uint32_t to) {
    const std::uint32_t anchor = anchor_[from];
    const double straight = (axis_.points[place(axis_, anchor)] - axis_.points[place(axis_, to)]).norm();
    const double time = std::max(fire_.time[from], fire_.time[anchor] + straight);
    if (!(time > fire_.time[to])) return;
    fire_.time[to] = time;
    anchor_[to] = straight > kReach * axis_.burn_time[to] ? to : anchor;
  }

  const RefinedAxis& axis_;
  burning::CurveFire& fire_;
  std::size_t halves_;
  std::vector<std::uint32_t> waits_for_, anchor_;
};

}  // namespace

void burn_curve_network(RefinedAxis& axis, Context* context) {
  // The halves of segments are never part of the curves.
  const std::size_t halves = 2 * std::size_t{axis.doors};
  const std::span edges = std::span(std::as_const(axis.complex.edges)).subspan(halves);
  const std::span of_curves = std::span(std::as_const(axis.curve_edge)).subspan(halves);
  std::vector<double> length(edges.size());
  const std::array blocks{axis.nodes, axis.nodes + axis.doors};
  const auto measure = [&](const auto& place) {
    base::for_indices(edges.size(), [&](std::size_t e) {
      if (of_curves[e]) length[e] = (axis.points[place(edges[e][0])] - axis.points[place(edges[e][1])]).norm();
    });
  };
  measure([](std::uint32_t v) { return v; });
  {
    burning::CurveFire first =
        burning::burn_curves(edges, of_curves, axis.curve_vertex, axis.burn_time, length, blocks, axis.plane);
    axis.exit = std::move(first.exit);
    if (axis.plane) {  // edges are courses as they are: there is nothing to move or to tighten
      axis.curve_burn_time = std::move(first.time);
      axis.medial_point = std::move(first.last);
      for (std::uint32_t& exit : axis.exit)
        if (exit != kNone) exit += static_cast<std::uint32_t>(halves);
      return;
    }
  }
  checkpoint(context, "curves", 0.8);
  const std::uint32_t first_dual = axis.nodes + axis.doors;
  base::for_indices(axis.exit.size(), [&](std::size_t v) {
    std::uint32_t& exit = axis.exit[v];
    if (exit != kNone) exit = v < first_dual ? kNone : exit + static_cast<std::uint32_t>(halves);
  });
  measure([&](std::uint32_t v) { return place(axis, v); });
  burning::CurveFire second = burning::burn_curves(edges, of_curves, axis.curve_vertex, axis.burn_time, length, blocks);
  TightTimes(axis, second, halves).run();
  axis.curve_burn_time = std::move(second.time);
  axis.medial_point = std::move(second.last);
}

}  // namespace quench::skeleton
