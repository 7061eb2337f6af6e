// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "delaunay/bounds.h"
#include "dual/cells.h"
#include "quench/shape.h"

namespace quench::dual::peel {

/// An inside voxel some of whose corners are sites. The ball through its corners has no lattice point inside, whatever
/// the spacing: a point that differs from the centre by half a voxel or more along every axis is nowhere nearer than
/// the corners. So where its sites do not lie in one plane they are a polytope of the Delaunay complex.
struct UnitCube {
  std::span<const std::uint32_t> sites;  ///< ascending
  std::uint32_t hull;                    ///< kNone where they lie in one plane
  std::uint64_t boundary;                ///< bits of the hull's facets that are boundary squares
  std::span<const Square> squares;       ///< its boundary squares, where there is no hull
};

/// The voxels between some layers of sites. O(sites and runs of these layers).
class UnitCubes {
 public:
  /// Voxels all of whose corners lie between the bounds.
  UnitCubes(const VoxelShape& shape, std::span<const LatticePoint> sites, const delaunay::Bounds& bounds, Hulls& hulls);

  /// visit(const UnitCube&) for every voxel whose sites are a polytope or that has a boundary square, in order of z, y,
  /// x.
  template <class Visit>
  void each(Visit&& visit) {
    for (std::int64_t z = low_[2]; z < high_[2]; ++z)
      for (std::int64_t y = low_[1]; y < high_[1]; ++y) {
        start_row(y, z);
        while (next_cube())
          if (x_ >= low_[0] && x_ < high_[0] && look()) visit(cube_);
      }
  }

 private:
  struct Kind {
    std::uint32_t hull = kNone;
    std::array<std::uint8_t, 6> facet;  // per side of the cube: the facet it is, 255: none
  };
  void start_row(std::int64_t y, std::int64_t z);
  bool next_cube();
  bool look();
  bool inside(std::size_t row, std::int64_t x);

  const VoxelShape& shape_;
  std::span<const LatticePoint> sites_;
  std::array<std::int64_t, 3> low_, high_;  // the first and the last lattice point, within the grid
  std::array<Kind, 256> kinds_;             // by the corners that are sites, bit x + 2 y + 4 z
  std::vector<std::uint32_t> line_begin_;   // per line of lattice points (y, z) from layer low_[2]: its first site

  // The current row of voxels: its four lines of sites, the columns of sites on both sides of the current cube, and the
  // runs of the voxels themselves and of the four rows around.
  std::array<std::uint32_t, 4> next_{}, stop_{};
  std::array<std::uint32_t, 4> left_{}, right_{};  // sites of a column by line, kNone: none
  std::int64_t x_ = 0;                             // of the cube
  struct Row {
    const Run *run, *end;
  };
  std::array<Row, 5> rows_{};  // the row, y - 1, y + 1, z - 1, z + 1
  std::array<std::uint32_t, 8> found_{};
  std::array<Square, 6> squares_{};
  UnitCube cube_{};
};

}  // namespace quench::dual::peel
