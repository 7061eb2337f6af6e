// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

namespace quench::base {

/// The largest float not above `value`. With levels rounded down, `level >= x` is the same for the level and for its
/// float, for every x that is a float.
inline float rounded_down(double value) {
  if (value > std::numeric_limits<float>::max() && std::isfinite(value)) return std::numeric_limits<float>::max();
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
                                              : nearest;
}

}  // namespace quench::base
