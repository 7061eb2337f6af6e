// SPDX-License-Identifier: Apache-2.0
#include "shape/voxel_components.h"

#include <array>

namespace quench::shape {

using Runs = std::span<const Run>;

base::UnionFind foreground_components(const VoxelShape& shape, Context* context) {
  base::UnionFind sets(shape.runs().size());
  for_scanlines(shape, context, "components", [&](std::int64_t y, std::int64_t z) {
    const Runs row = shape.row(y, z);
    if (row.empty()) return;
    const std::uint32_t here = first_index(shape, row);
    for (const Runs other : {shape.row(y + 1, z), shape.row(y, z + 1)}) {
      const std::uint32_t there = first_index(shape, other);
      for_overlaps(row, other, [&](std::size_t i, std::size_t j) {
        sets.unite(here + static_cast<std::uint32_t>(i), there + static_cast<std::uint32_t>(j));
      });
    }
  });
  return sets;
}

base::UnionFind touching_components(const VoxelShape& shape, Context* context) {
  base::UnionFind sets(shape.runs().size());
  for_scanlines(shape, context, "components", [&](std::int64_t y, std::int64_t z) {
    const Runs row = shape.row(y, z);
    if (row.empty()) return;
    const std::uint32_t here = first_index(shape, row);
    for (const Runs other :
         {shape.row(y + 1, z), shape.row(y - 1, z + 1), shape.row(y, z + 1), shape.row(y + 1, z + 1)}) {
      const std::uint32_t there = first_index(shape, other);
      for_touching(row, other, [&](std::size_t i, std::size_t j) {
        sets.unite(here + static_cast<std::uint32_t>(i), there + static_cast<std::uint32_t>(j));
      });
    }
  });
  return sets;
}

base::UnionFind background_components(const VoxelShape& shape, Context* context) {
  const auto outside = static_cast<std::uint32_t>(shape.runs().size());
  base::UnionFind sets(std::size_t{outside} + 1);
  for_scanlines(shape, context, "cavities", [&](std::int64_t y, std::int64_t z) {
    const Runs row = shape.row(y, z);
    if (row.empty()) return;
    const std::uint32_t here = first_index(shape, row);
    const auto after = [&](std::uint32_t first, Runs runs, std::size_t piece) {  // piece 0 lies before all runs
      return piece == 0 || piece == runs.size() ? outside : first + static_cast<std::uint32_t>(piece) - 1;
    };
    sets.unite(here + static_cast<std::uint32_t>(row.size()) - 1, outside);
    constexpr std::array<std::array<int, 2>, 8> kNeighbours{
        {{1, 0}, {-1, 1}, {0, 1}, {1, 1}, {-1, 0}, {1, -1}, {0, -1}, {-1, -1}}};
    for (std::size_t n = 0; n < kNeighbours.size(); ++n) {
      if (shape.grid().is_plane() && kNeighbours[n][1] != 0) continue;  // there is no outside above and below
      const Runs other = shape.row(y + kNeighbours[n][0], z + kNeighbours[n][1]);
      if (other.empty()) {
        for (std::size_t i = 1; i < row.size(); ++i) sets.unite(after(here, row, i), outside);
      } else if (n < 4) {  // the other four are seen from the other scanline
        // Pieces of background touch (26-connected) when the closed intervals meet; merged in order of x.
        const std::uint32_t there = first_index(shape, other);
        for (std::size_t i = 0, j = 0; i <= row.size() && j <= other.size();) {
          const bool meets = (i == row.size() || j == 0 || other[j - 1].end <= row[i].begin) &&
                             (j == other.size() || i == 0 || row[i - 1].end <= other[j].begin);
          if (meets) sets.unite(after(here, row, i), after(there, other, j));
          if (i == row.size())
            ++j;
          else if (j == other.size() || row[i].begin < other[j].begin)
            ++i;
          else
            ++j;
        }
      }
    }
  });
  return sets;
}

}  // namespace quench::shape
