// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "quench/geometry.h"

namespace quench {

/// The largest coordinate or radius of a medial axis: squares and sums of squares of what is larger may be no numbers.
inline constexpr double kLargestLength = 1e150;

/// The longest side of the box around the points; 0 for none.
inline double longest_side_of(std::span<const Vec3> points) {
  if (points.empty()) return 0;
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).maxCoeff();
}

}  // namespace quench
