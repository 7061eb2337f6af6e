// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "quench/axis.h"

namespace quench::axis {

/// A measure that is derived cell by cell from another one. It is computed when a file is written, and takes no memory
/// before unless it is added to the axis.
struct DerivedMeasure {
  std::string_view name;
  std::string_view from;  ///< the measure it needs
  /// The value of the cell with these corners, whose value of `from` is given.
  double (*value)(const MedialAxis& axis, std::span<const std::uint32_t> corners, double from);
};

/// Those that can be derived from what the axis has, in the order of the table in measures.cpp.
std::vector<DerivedMeasure> derivable(const MedialAxis& axis);

/// A new measure is a function in a file of its own, declared here, and a line in the table.
double object_angle(const MedialAxis& axis, std::span<const std::uint32_t> corners, double lambda);

}  // namespace quench::axis
