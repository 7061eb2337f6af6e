// SPDX-License-Identifier: Apache-2.0
#include "burning/curve_fire.h"

#include <algorithm>
#include <queue>
#include <utility>

#include "base/cofaces.h"
#include "base/constants.h"
#include "quench/geometry.h"

namespace quench::burning {

using base::kNever;

CurveFire burn_curves(std::span<const std::array<std::uint32_t, 2>> edges, std::span<const char> used,
                      std::span<const double> start, std::span<const double> length) {
  CurveFire fire;
  fire.time.assign(used.size(), kNever);
  fire.exit.assign(used.size(), kNone);
  fire.last.assign(used.size(), 0);
  std::vector<base::Cofaces> left(used.size());  // edges that are left at each vertex
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) left[v].add(e);
  std::vector<double> arrival(start.begin(), start.end());
  using Label = std::pair<double, std::uint32_t>;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue;
  const auto push = [&](std::uint32_t v) {
    if (start[v] < kNever) queue.push({arrival[v], v});
  };
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (used[v] && (left[v].none() || left[v].single())) push(v);
  while (!queue.empty()) {
    const auto [t, v] = queue.top();
    queue.pop();
    fire.time[v] = t;
    if (left[v].none()) {
      fire.last[v] = 1;
      continue;
    }
    const std::uint32_t e = left[v].only(), other = edges[e][0] == v ? edges[e][1] : edges[e][0];
    fire.exit[v] = e;
    left[v].remove(e);
    left[other].remove(e);
    // If this was the last edge of the other end, that is queued already and burns at its own time, as the last.
    if (left[other].none()) continue;
    arrival[other] = std::max(arrival[other], t + length[e]);
    if (left[other].single()) push(other);
  }
  return fire;
}

}  // namespace quench::burning
