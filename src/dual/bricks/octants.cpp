// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/octants.h"

#include <algorithm>

#include "base/parallel.h"

namespace quench::dual::bricks {
namespace {

// A scanline of voxels, asked from left to right.
class RowReader {
 public:
  explicit RowReader(std::span<const Run> runs) : runs_(runs) {}
  bool contains(std::int64_t x) {
    while (next_ < runs_.size() && runs_[next_].end <= x) ++next_;
    return next_ < runs_.size() && runs_[next_].begin <= x;
  }

 private:
  std::span<const Run> runs_;
  std::size_t next_ = 0;
};

constexpr Squares squares_between(unsigned octants) {
  unsigned squares = 0;
  for (unsigned a = 0; a < 3; ++a)
    for (unsigned side = 0; side < 4; ++side) {
      const unsigned low = (side & 1) << (a + 1) % 3 | (side >> 1) << (a + 2) % 3, high = low | 1u << a;
      if ((octants >> low & 1) != (octants >> high & 1)) squares |= 1u << (4 * a + side);
    }
  return static_cast<Squares>(squares);
}

constexpr std::array<Squares, 256> kBoundarySquares = [] {
  std::array<Squares, 256> table{};
  for (unsigned octants = 0; octants < 256; ++octants) table[octants] = squares_between(octants);
  return table;
}();

}  // namespace

Squares boundary_squares(Octants octants) { return kBoundarySquares[octants]; }

Squares square_at(const LatticePoint& at, const LatticePoint& p, const LatticePoint& q) {
  for (unsigned a = 0; a < 3; ++a) {
    if (p[a] != at[a] || q[a] != at[a]) continue;
    unsigned side = 0;
    for (unsigned k = 0; k < 2; ++k) {
      const unsigned axis = (a + 1 + k) % 3;
      const std::int32_t low = std::min({at[axis], p[axis], q[axis]}), high = std::max({at[axis], p[axis], q[axis]});
      if (high - low != 1) return 0;
      side |= (at[axis] == low ? 1u : 0u) << k;
    }
    return static_cast<Squares>(1u << (4 * a + side));
  }
  return 0;
}

std::vector<Octants> octants_of(const VoxelShape& shape, std::span<const LatticePoint> sites, Context* context) {
  std::vector<Octants> octants(sites.size());
  const std::size_t chunks = base::chunks_for(sites.size());
  base::for_chunks(chunks, context, "delaunay", 0, 0, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(sites.size(), chunk, chunks);
    for (std::size_t begin = first, end = first; begin < last; begin = end) {
      const std::int32_t y = sites[begin][1], z = sites[begin][2];
      while (end < last && sites[end][1] == y && sites[end][2] == z) ++end;
      std::fill(octants.begin() + static_cast<std::ptrdiff_t>(begin),
                octants.begin() + static_cast<std::ptrdiff_t>(end), Octants{0});
      for (unsigned side = 0; side < 4; ++side) {
        const auto runs = shape.row(y - (side & 1 ? 0 : 1), z - (side & 2 ? 0 : 1));
        RowReader left(runs), right(runs);
        for (std::size_t s = begin; s < end; ++s) {
          const unsigned pair = (left.contains(sites[s][0] - 1) ? 1u : 0u) | (right.contains(sites[s][0]) ? 2u : 0u);
          octants[s] = static_cast<Octants>(octants[s] | pair << 2 * side);
        }
      }
    }
  });
  return octants;
}

}  // namespace quench::dual::bricks
