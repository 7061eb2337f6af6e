// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace quench::io {

using Colour = std::array<std::uint8_t, 3>;

/// From dark violet over teal to yellow, of nearly even steps in lightness, as in viridis.
inline Colour viridis(double fraction) {
  constexpr double table[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double place = 4 * std::clamp(fraction, 0.0, 1.0);
  const int step = std::min(3, static_cast<int>(place));
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] =
        static_cast<std::uint8_t>(std::lround(table[step][c] + (place - step) * (table[step + 1][c] - table[step][c])));
  return colour;
}

}  // namespace quench::io
