// SPDX-License-Identifier: Apache-2.0
#include "skeleton/curve_times.h"

#include <array>
#include <utility>

#include "base/parallel.h"
#include "burning/curve_fire.h"
#include "skeleton/member.h"

namespace quench::skeleton {

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
        burning::burn_curves(edges, of_curves, axis.curve_vertex, axis.burn_time, length, blocks);
    axis.exit = std::move(first.exit);
  }
  checkpoint(context, "curves", 0.8);
  const std::uint32_t first_dual = axis.nodes + axis.doors;
  base::for_indices(axis.exit.size(), [&](std::size_t v) {
    std::uint32_t& exit = axis.exit[v];
    if (exit != kNone) exit = v < first_dual ? kNone : exit + static_cast<std::uint32_t>(halves);
  });
  measure([&](std::uint32_t v) { return axis.exit[v] == kNone ? v : other_end(axis, axis.exit[v], v); });
  burning::CurveFire second = burning::burn_curves(edges, of_curves, axis.curve_vertex, axis.burn_time, length, blocks);
  axis.curve_burn_time = std::move(second.time);
  axis.medial_point = std::move(second.last);
}

}  // namespace quench::skeleton
