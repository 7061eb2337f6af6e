// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "quench/shape.h"

/// Small pixel shapes, the same for the same seed.
namespace quench::testing_planes {

inline Grid plane_grid(std::int64_t width, std::int64_t height, std::array<double, 2> spacing = {1, 1}) {
  Grid grid;
  grid.dims = {width, height, 1};
  grid.spacing = Vec3(spacing[0], spacing[1], 1);
  grid.make_plane();
  return grid;
}

inline VoxelShape plane_shape(const Grid& grid, const std::function<bool(int, int)>& inside) {
  VoxelShape shape(grid);
  std::vector<Run> runs;
  for (int y = 0; y < grid.dims[1]; ++y) {
    runs.clear();
    for (int x = 0; x < grid.dims[0]; ++x)
      if (inside(x, y)) runs.push_back({x, x + 1});
    shape.append_row(runs);
  }
  return shape;
}

/// A plane shape from rows of text: '#' is foreground.
inline VoxelShape plane_picture(const std::vector<const char*>& rows) {
  const auto width = static_cast<std::int64_t>(std::char_traits<char>::length(rows[0]));
  return plane_shape(plane_grid(width, static_cast<std::int64_t>(rows.size())),
                     [&](int x, int y) { return rows[static_cast<std::size_t>(y)][x] == '#'; });
}

/// Noise of any density, unions of boxes and discs with parts cut out, and these with salt. At least one pixel. Sides
/// of the grid are 2 to `largest`.
inline VoxelShape random_plane_shape(std::uint64_t seed, int largest, std::array<double, 2> spacing = {1, 1}) {
  std::mt19937_64 random(seed * 0x9E3779B97F4A7C15ull + 7);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const int width = 2 + below(largest - 1), height = 2 + below(largest - 1);
  std::vector<char> pixels(static_cast<std::size_t>(width * height), 0);
  const auto at = [&](int x, int y) -> char& { return pixels[static_cast<std::size_t>(x + width * y)]; };
  const auto each = [&](const std::function<void(int, int)>& visit) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) visit(x, y);
  };
  const int type = static_cast<int>(seed % 4);
  if (type == 0) {
    const double density = 0.05 + 0.9 * unit();
    each([&](int x, int y) { at(x, y) = unit() < density; });
  } else {
    for (int part = 1 + below(5); part > 0; --part) {
      const bool disc = type == 1 || (type == 3 && below(2));
      const char value = below(4) > 0;
      const double cx = 0.5 * below(2 * width + 1), cy = 0.5 * below(2 * height + 1);
      const double rx = 0.5 + unit() * 0.6 * width, ry = below(2) ? rx : 0.5 + unit() * 0.6 * height;
      each([&](int x, int y) {
        const double dx = (x + 0.5 - cx) / rx, dy = (y + 0.5 - cy) / ry;
        if (disc ? dx * dx + dy * dy < 1 : std::abs(dx) < 1 && std::abs(dy) < 1) at(x, y) = value;
      });
    }
    if (type == 3)
      each([&](int x, int y) {
        if (below(10) == 0) at(x, y) = static_cast<char>(1 - at(x, y));
      });
  }
  at(below(width), below(height)) = 1;
  return plane_shape(plane_grid(width, height, spacing), [&](int x, int y) { return at(x, y) != 0; });
}

}  // namespace quench::testing_planes
