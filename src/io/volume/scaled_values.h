// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "quench/shape.h"

/// Values that files keep as a line of their samples: slope * sample + intercept.
namespace quench::io {

/// The smallest type that holds all whole numbers from `low` to `high`; float64 where none does.
SampleType type_of_whole_numbers(double low, double high);

/// Whether float32 tells the values of all integers of up to 16 bits apart: a step of theirs is more than the last bit
/// of the largest value.
inline bool fits_float32(double slope, double intercept) {
  constexpr double kValues = 0x1p16, kPrecision = 0x1p23;
  return std::abs(intercept) + std::abs(slope) * kValues < std::abs(slope) * kPrecision;
}

struct LinearValues {
  double slope = 1, intercept = 0;

  /// Of integers of up to 16 bits: integers where slope and intercept are, else float32 where that is exact enough.
  SampleType type(SampleType stored) const;
  /// `out` are samples of type(stored).
  void apply(SampleType stored, std::span<const std::byte> samples, std::span<std::byte> out) const;
};

}  // namespace quench::io
