// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "quench/record.h"

namespace quench::record {

/// Lines and polygons of a record that can be cells of a complex: what make_complex() takes.
struct MendedCells {
  std::vector<std::array<std::uint32_t, 2>> lines;
  std::vector<std::uint32_t> offsets{0}, corners;  ///< of the polygons
  std::size_t degenerate = 0;                      ///< lines and polygons of the record that were changed or left out
};

/// Lines from a point to itself are left out. A polygon without the corners that repeat the one before is a smaller
/// polygon, a line or a point. One that comes back to a corner later is taken apart into its sides: nothing tells where
/// its area is.
MendedCells mended_cells(const Record& data);

}  // namespace quench::record
