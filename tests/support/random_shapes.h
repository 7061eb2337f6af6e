// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "quench/shape.h"

/// Small random voxel shapes, the same for the same seed: noise, blobs, unions of boxes and balls, blobs with salt.
namespace quench::testing_shapes {

inline VoxelShape from_predicate(const Grid& grid, const std::function<bool(int, int, int)>& inside) {
  VoxelShape shape(grid);
  std::vector<Run> runs;
  for (int z = 0; z < grid.dims[2]; ++z)
    for (int y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      for (int x = 0; x < grid.dims[0]; ++x)
        if (inside(x, y, z)) runs.push_back({x, x + 1});
      shape.append_row(runs);
    }
  return shape;
}

/// A box of the given size full of foreground, with `margin` empty voxels around it.
inline VoxelShape box_shape(int nx, int ny, int nz, int margin = 1) {
  Grid grid;
  grid.dims = {nx + 2 * margin, ny + 2 * margin, nz + 2 * margin};
  return from_predicate(grid, [=](int x, int y, int z) {
    return x >= margin && y >= margin && z >= margin && x < nx + margin && y < ny + margin && z < nz + margin;
  });
}

/// At least one foreground voxel. `largest` bounds the sides of the grid (4 to largest).
inline VoxelShape random_shape(std::uint64_t seed, int largest = 10, bool anisotropic = false) {
  std::mt19937_64 random(seed * 0x9E3779B97F4A7C15ull + 1);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Grid grid;
  for (auto& d : grid.dims) d = 4 + below(largest - 3);
  if (anisotropic)
    for (int a = 0; a < 3; ++a) grid.spacing[a] = 1 + below(5);
  std::vector<char> voxels(static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]), 0);
  const auto at = [&](int x, int y, int z) -> char& {
    return voxels[static_cast<std::size_t>(x + grid.dims[0] * (y + grid.dims[1] * z))];
  };
  const auto each = [&](const std::function<void(int, int, int)>& visit) {
    for (int z = 0; z < grid.dims[2]; ++z)
      for (int y = 0; y < grid.dims[1]; ++y)
        for (int x = 0; x < grid.dims[0]; ++x) visit(x, y, z);
  };
  const int type = static_cast<int>(seed % 4);
  if (type == 0) {  // noise
    const double density = 0.1 + 0.8 * unit();
    each([&](int x, int y, int z) { at(x, y, z) = unit() < density; });
  } else {  // unions of boxes and balls, some subtracted; type 3 with salt
    const int parts = 1 + below(5);
    for (int p = 0; p < parts; ++p) {
      const bool ball = type == 1 || (type == 3 && below(2));
      const char value = p > 0 && below(4) == 0 ? 0 : 1;
      double c[3], r[3];
      for (int a = 0; a < 3; ++a) {
        c[a] = 0.5 * below(2 * static_cast<int>(grid.dims[a]) + 1);
        r[a] = 0.5 + unit() * 0.5 * static_cast<double>(grid.dims[a]);
      }
      if (below(2)) r[1] = r[2] = r[0];
      each([&](int x, int y, int z) {
        const double d[3] = {(x + 0.5 - c[0]) / r[0], (y + 0.5 - c[1]) / r[1], (z + 0.5 - c[2]) / r[2]};
        const bool in = ball ? d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < 1
                             : std::abs(d[0]) < 1 && std::abs(d[1]) < 1 && std::abs(d[2]) < 1;
        if (in) at(x, y, z) = value;
      });
    }
    if (type == 3)
      each([&](int x, int y, int z) {
        if (below(20) == 0) at(x, y, z) = static_cast<char>(1 - at(x, y, z));
      });
  }
  at(below(static_cast<int>(grid.dims[0])), below(static_cast<int>(grid.dims[1])),
     below(static_cast<int>(grid.dims[2]))) = 1;
  return from_predicate(grid, [&](int x, int y, int z) { return at(x, y, z) != 0; });
}

}  // namespace quench::testing_shapes
