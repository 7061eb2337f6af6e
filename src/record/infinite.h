// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace quench::record {

/// How measures that may be infinite are written: colour ranges of viewers break on infinity, so the largest finite
/// value stands for it (0 if there is none), and an array of flags tells where.
inline std::vector<double> finite(std::vector<double> values) {
  double largest = 0;
  for (const double v : values)
    if (std::isfinite(v)) largest = std::max(largest, v);
  for (double& v : values)
    if (!std::isfinite(v)) v = largest;
  return values;
}
inline std::vector<std::uint8_t> flags_of_infinite(const std::vector<double>& values) {
  std::vector<std::uint8_t> flags;
  flags.reserve(values.size());
  for (const double v : values) flags.push_back(std::isinf(v));
  return flags;
}

}  // namespace quench::record
