// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::dual::peel {

/// Finds the sites in small boxes of the lattice: blocks of 4^3 lattice points as one word each, and blocks of 16^3
/// above them. Some 6 bytes per site and 4 per block of 16^3.
class SiteIndex {
 public:
  /// Blocks of 16^3 of the lattice points of a grid.
  static std::size_t groups(const std::array<std::int64_t, 3>& dims) {
    std::size_t groups = 1;
    for (const std::int64_t d : dims) groups *= static_cast<std::size_t>(d / 16 + 1);
    return groups;
  }
  /// `sites`: in order of z, y, x, coordinates not negative. O(sites).
  explicit SiteIndex(std::span<const LatticePoint> sites);

  /// visit(x, y, z, entry) for all sites from `low` to `high`, both included, in no order that matters; site(entry) is
  /// the number of one, which is rarely wanted of all.
  template <class Visit>
  void each_in_box(LatticePoint low, LatticePoint high, Visit&& visit) const {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(low[a], 0);
      high[a] = std::min(high[a], last_[a]);
      if (low[a] > high[a]) return;
    }
    for (std::int32_t bz = low[2] >> 2; bz <= high[2] >> 2; ++bz) {
      const std::uint64_t in_z = range(bz, low[2], high[2], 16);
      for (std::int32_t by = low[1] >> 2; by <= high[1] >> 2; ++by) {
        const std::uint64_t in_yz = in_z & range(by, low[1], high[1], 4) * 0x0001000100010001ull;
        const std::uint32_t* group = nullptr;
        for (std::int32_t bx = low[0] >> 2; bx <= high[0] >> 2; ++bx) {
          if (!group || (bx & 3) == 0) {
            group = find_group(bx, by, bz);
            if (!group) {
              bx |= 3;
              continue;
            }
          }
          const std::uint32_t number = group[slot(bx, by, bz)];
          if (number == kEmpty) continue;
          std::uint64_t found = blocks_[number].mask & in_yz;
          if (4 * bx < low[0] || 4 * bx + 3 > high[0]) found &= range(bx, low[0], high[0], 1) * 0x1111111111111111ull;
          for (; found; found &= found - 1) {
            const int bit = std::countr_zero(found);
            visit(4 * bx + (bit & 3), 4 * by + (bit >> 2 & 3), 4 * bz + (bit >> 4), Entry{number, bit});
          }
        }
      }
    }
  }
  struct Entry {
    std::uint32_t block;
    int bit;
  };
  std::uint32_t site(const Entry& entry) const {
    constexpr std::uint8_t kCount[8] = {0, 1, 1, 2, 1, 2, 2, 3};
    const Block& block = blocks_[entry.block];
    const std::uint64_t before = block.mask >> (entry.bit & ~3) & ((1ull << (entry.bit & 3)) - 1);
    return block.first[static_cast<std::size_t>(entry.bit >> 2)] + kCount[before];
  }

 private:
  struct Block {
    std::uint64_t mask = 0;                    // bit x + 4 y + 16 z
    std::array<std::uint32_t, 16> first = {};  // per y + 4 z: the site of the lowest bit of its four
  };
  static constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();

  // Which of the four places of block `b` lie in [low, high], as fields of `width` bits that are all set.
  static std::uint64_t range(std::int32_t b, std::int32_t low, std::int32_t high, int width) {
    const int from = std::max(low - 4 * b, 0) * width, count = (std::min(high - 4 * b, 3) + 1) * width - from;
    return (count == 64 ? ~0ull : (1ull << count) - 1) << from;
  }
  const std::uint32_t* find_group(std::int32_t bx, std::int32_t by, std::int32_t bz) const {
    const std::uint32_t group =
        groups_[static_cast<std::size_t>(bx >> 2) +
                dims_[0] * (static_cast<std::size_t>(by >> 2) + dims_[1] * static_cast<std::size_t>(bz >> 2))];
    return group == kEmpty ? nullptr : slots_.data() + 64 * std::size_t{group};
  }
  static std::size_t slot(std::int32_t bx, std::int32_t by, std::int32_t bz) {
    return static_cast<std::size_t>((bx & 3) | (by & 3) << 2 | (bz & 3) << 4);
  }

  LatticePoint last_{-1, -1, -1};
  std::array<std::size_t, 3> dims_{};
  std::vector<std::uint32_t> groups_;  // per 16^3: a group of 64 slots
  std::vector<std::uint32_t> slots_;   // per 4^3 of an occupied group: its block
  std::vector<Block> blocks_;
};

}  // namespace quench::dual::peel
