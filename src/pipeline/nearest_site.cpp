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
  const auto first_from = [&](double row, double x) {
    return std::lower_bound(sites.begin(), sites.end(), std::array{row, x},
                            [](const LatticePoint& site, const std::array<double, 2>& yx) {
                              return site[1] != yx[0] ? site[1] < yx[0] : site[0] < yx[1];
                            });
  };
  constexpr double kLeft = -std::numeric_limits<double>::infinity();
  // Measures the two sites of a row beside the point; false when the row is too far away for a nearer one.
  const auto look_at = [&](double row) {
    const double dy = (row - at[1]) * grid.spacing[1];
    if (dy * dy >= squared) return false;
    const auto next = first_from(row, at[0]);
    const auto measure = [&](const LatticePoint& site) {
      if (site[1] != row) return;
      const double dx = (site[0] - at[0]) * grid.spacing[0];
      squared = std::min(squared, dx * dx + dy * dy);
    };
    if (next != sites.end()) measure(*next);
    if (next != sites.begin()) measure(*(next - 1));
    return true;
  };
  // Rows that have sites, from the point upwards and downwards in turns.
  auto up = first_from(at[1], kLeft), down = up;
  bool look_up = true, look_down = true;
  while (look_up || look_down) {
    look_up = look_up && up != sites.end() && look_at((*up)[1]);
    if (look_up) up = first_from((*up)[1] + 1.0, kLeft);
    look_down = look_down && down != sites.begin() && look_at((*(down - 1))[1]);
    if (look_down) down = first_from((*(down - 1))[1], kLeft);
  }
  return std::sqrt(squared);
}

}  // namespace quench::pipeline
