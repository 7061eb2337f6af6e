// SPDX-License-Identifier: Apache-2.0
#include "burning/curve_fire.h"

#include <limits>
#include <queue>
#include <utility>

#include "quench/burn.h"

namespace quench::burning {

CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> used,
                      std::span<const double> start, std::span<const double> length) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  CurveFire fire;
  fire.time.assign(used.size(), kNever);
  fire.exit.assign(used.size(), kNone);
  fire.last.assign(used.size(), 0);
  // Edges left at each vertex, and their XOR: with one left that is the one.
  std::vector<std::uint32_t> left(used.size(), 0), edges_xor(used.size(), 0);
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) {
      ++left[v];
      edges_xor[v] ^= e;
    }
  std::vector<double> arrival(start.begin(), start.end());  // never before its start
  using Label = std::pair<double, std::uint32_t>;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue;
  const auto offer = [&](std::uint32_t v) {
    if (start[v] < kNever) queue.push({arrival[v], v});
  };
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (used[v] && left[v] <= 1) offer(v);
  while (!queue.empty()) {
    const auto [t, v] = queue.top();
    queue.pop();
    fire.time[v] = t;
    if (left[v] == 0) {
      fire.last[v] = 1;
      continue;
    }
    const std::uint32_t e = edges_xor[v], other = edges[e][0] == v ? edges[e][1] : edges[e][0];
    fire.exit[v] = e;
    left[v] = 0;
    edges_xor[other] ^= e;
    // With one edge left before, the other end burns on its own time; it only has nothing to pass fire to any more.
    if (--left[other] == 0) continue;
    arrival[other] = std::max(arrival[other], t + length[e]);
    if (left[other] == 1) offer(other);
  }
  return fire;
}

}  // namespace quench::burning
