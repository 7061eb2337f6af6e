// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

#include "quench/geometry.h"

/// Sentences about grids: of pixels in the plane, of voxels in space.
namespace quench::base {

inline std::string cell_name(const Grid& grid) { return grid.is_plane() ? "pixel" : "voxel"; }

/// "0.5 x 0.5 x 2", of a plane "0.5 x 0.5": a value per axis, each written as the format string `each` says.
template <class PerAxis>
std::string axes_text(const Grid& grid, const PerAxis& values, const char* each = "{}") {
  std::string text = fmt::format(fmt::runtime(each), values[0]);
  for (std::size_t a = 1; a < (grid.is_plane() ? 2 : 3); ++a)
    text += " x " + fmt::format(fmt::runtime(each), values[static_cast<decltype(values.size())>(a)]);
  return text;
}

}  // namespace quench::base
