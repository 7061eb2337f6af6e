// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "quench/pipeline.h"

namespace quench::pipeline {

double PlaneSites::distance(const Vec3& point) const {
  const Vec3 at = grid.lattice(point);
  double squared = std::numeric_limits<double>::infinity();
  const auto before = [](const LatticePoint& site, const std::array<double, 2>& yx) {
    return site[1] != yx[0] ? site[1] < yx[0] : site[0] < yx[1];
  };
  // Rows of sites outwards from the point, up and down, as far as they may hold a nearer one.
  const auto look_at = [&](double row) {
    const double dy = (row - at[1]) * grid.spacing[1];
    if (dy * dy >= squared) return false;
    const auto next = std::lower_bound(sites.begin(), sites.end(), std::array{row, at[0]}, before);
    const auto measure = [&](const LatticePoint& site) {
      if (site[1] != row) return;
      const double dx = (site[0] - at[0]) * grid.spacing[0];
      squared = std::min(squared, dx * dx + dy * dy);
    };
    if (next != sites.end()) measure(*next);
    if (next != sites.begin()) measure(*(next - 1));
    return true;
  };
  const double first = std::floor(at[1]), lowest = sites.empty() ? 1 : sites.front()[1],
               highest = sites.empty() ? 0 : sites.back()[1];
  bool down = true, up = true;
  for (double step = 0; down || up; ++step) {
    const double below = first - step, above = first + 1 + step;
    down = down && below >= lowest && (below > highest || look_at(below));
    up = up && above <= highest && (above < lowest || look_at(above));
  }
  return std::sqrt(squared);
}

}  // namespace quench::pipeline
