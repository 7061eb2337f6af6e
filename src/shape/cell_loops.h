// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace quench::shape {

/// The cells dual to lattice points: cubes whose corners are the centres of 2 x 2 x 2 voxels. Corner dx + 2 dy + 4 dz;
/// edges along x: dy + 2 dz, along y: 4 + dx + 2 dz, along z: 8 + dx + 2 dy.
inline constexpr int kCellEdges = 12;

/// The two corners of an edge of a cell, the one with the smaller coordinate first.
constexpr std::array<int, 2> corners_of_edge(int edge) {
  const int axis = edge / 4, first = edge & 1, second = edge >> 1 & 1;
  const int corner = axis == 0 ? 2 * first + 4 * second : axis == 1 ? first + 4 * second : first + 2 * second;
  return {corner, corner | 1 << axis};
}

/// Where a surface between the foreground and the background corners of a cell meets its edges: closed loops on the
/// boundary of the cell, anticlockwise seen from the background. Diagonal foreground corners of a face are separated,
/// so that the foreground is 6-connected and the background 26-connected. Every loop bounds a disc in the cell, but
/// for `tube`: there both loops, of three edges each, bound an annulus, since two opposite background corners are
/// connected through the middle of the cell.
struct CellLoops {
  std::array<std::uint8_t, kCellEdges> edges{};  ///< loop after loop
  std::array<std::uint8_t, 4> length{};          ///< of every loop
  std::uint8_t count = 0;
  bool tube = false;
};

/// The loops for every set of foreground corners, as a bit per corner.
const std::array<CellLoops, 256>& cell_loops();

}  // namespace quench::shape
