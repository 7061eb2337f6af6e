// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "verification/result.h"

namespace quench::verification {

/// Flags and values of a point array that may be infinite, per vertex: 1, and the largest finite value, where it is.
struct PointMeasure {
  std::vector<double> value, infinite;
  double largest = 0;  ///< of the finite ones

  PointMeasure(const Result& result, const char* values, const char* flags);
  bool known() const { return !value.empty(); }
  /// Whether the value stands for infinity.
  bool stands_for_infinity(std::size_t v) const;
};

/// That `thickness`, the array `name`, is the difference of two others, or 0 where that is negative; where it is
/// infinite, its value is the largest finite one. Empty when it is, else the first counterexample.
std::string wrong_thickness(const Result& result, const char* name, const PointMeasure& thickness,
                            const PointMeasure& time, const std::vector<double>& from);

}  // namespace quench::verification
