// SPDX-License-Identifier: Apache-2.0
#include "verification/point_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"

namespace quench::verification {

PointMeasure::PointMeasure(const Result& result, const char* values, const char* flags) {
  const std::vector<double> all = numbers_or_empty(result.data.point_data, values),
                            flag = numbers_or_empty(result.data.point_data, flags);
  if (all.empty() || flag.empty()) return;
  for (const std::uint32_t row : result.rows) {
    value.push_back(all[row]);
    infinite.push_back(flag[row]);
    if (flag[row] == 0) largest = std::max(largest, all[row]);
  }
}

bool PointMeasure::stands_for_infinity(std::size_t v) const {
  return std::abs(value[v] - largest) <= kSingle * largest;
}

std::string wrong_thickness(const Result& result, const char* name, const PointMeasure& thickness,
                            const PointMeasure& time, const std::vector<double>& from) {
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    const double written = thickness.value[v];
    if (thickness.infinite[v] != 0) {
      if (!thickness.stands_for_infinity(v) || !time.stands_for_infinity(v))
        return fmt::format("{} does not burn and has not the largest value of {}", result.describe_vertex(v), name);
      continue;
    }
    const double expected = std::max(0.0, time.value[v] - from[v]);
    if (!(std::abs(written - expected) <= kSingle * std::max(time.value[v], from[v])))
      return fmt::format("{} has {} {:.9g}; {:.9g} less {:.9g} is {:.9g}", result.describe_vertex(v), name, written,
                         time.value[v], from[v], expected);
  }
  return {};
}

}  // namespace quench::verification
