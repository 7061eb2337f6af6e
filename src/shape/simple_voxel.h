// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

/// The 26 neighbours of a voxel as bits: that at (dx, dy, dz) is bit (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1), set where
/// it is foreground; bit 13, of the voxel itself, is of no meaning.
namespace quench::shape {

using Neighbours = std::uint32_t;

inline constexpr Neighbours kCentre = 1u << 13, kAllNeighbours = 0x7ffffffu & ~kCentre;

constexpr Neighbours neighbour_bit(int dx, int dy, int dz) { return 1u << ((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1)); }

/// The neighbours at distance `least` to `most` in steps along the axes.
constexpr Neighbours neighbours_within(int least, int most) {
  Neighbours result = 0;
  for (int i = 0; i < 27; ++i) {
    const auto off = [](int c) { return c == 1 ? 0 : 1; };
    const int steps = off(i % 3) + off(i / 3 % 3) + off(i / 9);
    if (steps >= least && steps <= most) result |= 1u << i;
  }
  return result;
}

constexpr Neighbours neighbour_layer(int divisor, int which) {
  Neighbours result = 0;
  for (int i = 0; i < 27; ++i)
    if (i / divisor % 3 == which) result |= 1u << i;
  return result;
}

inline constexpr Neighbours kFaceNeighbours = neighbours_within(1, 1), kFaceAndEdgeNeighbours = neighbours_within(1, 2);
inline constexpr std::array<int, 3> kNeighbourSteps{1, 3, 9};
inline constexpr std::array<Neighbours, 3> kNotInFirstLayer{~neighbour_layer(1, 0), ~neighbour_layer(3, 0),
                                                            ~neighbour_layer(9, 0)},
    kNotInLastLayer{~neighbour_layer(1, 2), ~neighbour_layer(3, 2), ~neighbour_layer(9, 2)};

/// Set bits and their neighbours along one axis.
constexpr Neighbours grown_along(Neighbours set, std::size_t axis) {
  return set | (set & kNotInLastLayer[axis]) << kNeighbourSteps[axis] |
         (set & kNotInFirstLayer[axis]) >> kNeighbourSteps[axis];
}

/// Whether all bits of `wanted` are in one 6-component of `set`, which holds them.
constexpr bool joined_by_faces(Neighbours set, Neighbours wanted) {
  Neighbours part = wanted & (~wanted + 1);
  for (Neighbours before = 0; part != before;) {
    before = part;
    part = (grown_along(part, 0) | grown_along(part, 1) | grown_along(part, 2)) & set;
    if ((wanted & ~part) == 0) return true;
  }
  return false;
}

/// Whether `set` is one 26-component.
constexpr bool is_joined(Neighbours set) {
  Neighbours part = set & (~set + 1);
  for (Neighbours before = 0; part != before;) {
    before = part;
    part = grown_along(grown_along(grown_along(part, 0), 1), 2) & set;
    if (part == set) return true;
  }
  return false;
}

/// Whether putting the voxel into the foreground or taking it out keeps the topology (foreground 6-connected,
/// background 26-connected): the foreground of its faces is not empty and one 6-component among the neighbours across
/// faces and edges, and the background among all neighbours is not empty and one 26-component (Bertrand, Malandain
/// 1994).
constexpr bool is_simple(Neighbours around) {
  const Neighbours faces = around & kFaceNeighbours, background = ~around & kAllNeighbours;
  return faces != 0 && background != 0 && joined_by_faces(around & kFaceAndEdgeNeighbours, faces) &&
         is_joined(background);
}

/// By how much the Euler characteristic of the foreground grows when the voxel is put into it: voxels - faces they
/// share + edges that are full - vertices that are full.
constexpr int euler_change(Neighbours around) {
  int change = 1 - std::popcount(around & kFaceNeighbours);
  const auto full = [&](Neighbours all) { return (around & all) == all ? 1 : 0; };
  for (const int i : {-1, 1})
    for (const int j : {-1, 1}) {
      change += full(neighbour_bit(i, 0, 0) | neighbour_bit(0, j, 0) | neighbour_bit(i, j, 0));
      change += full(neighbour_bit(i, 0, 0) | neighbour_bit(0, 0, j) | neighbour_bit(i, 0, j));
      change += full(neighbour_bit(0, i, 0) | neighbour_bit(0, 0, j) | neighbour_bit(0, i, j));
      for (const int k : {-1, 1})
        change -=
            full(neighbour_bit(i, 0, 0) | neighbour_bit(0, j, 0) | neighbour_bit(0, 0, k) | neighbour_bit(i, j, 0) |
                 neighbour_bit(i, 0, k) | neighbour_bit(0, j, k) | neighbour_bit(i, j, k));
    }
  return change;
}

}  // namespace quench::shape
