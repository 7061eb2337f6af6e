// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace quench::base {

/// Puts two zero bits before each of the lower 21 bits.
inline std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// The place of a point along a Z-order curve (Morton 1966): the bits of the coordinates in turns, x above y above z.
/// Of each coordinate the lower 21 bits count.
inline std::uint64_t z_order(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread_bits(x) << 2 | spread_bits(y) << 1 | spread_bits(z);
}

}  // namespace quench::base
