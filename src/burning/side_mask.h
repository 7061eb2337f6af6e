// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace quench::burning {

/// A set of nodes of a polygon: a bit for every corner and one for the inserted nodes of every side. Sides beyond the
/// 31st share their bits: a bit stands for the nodes of all of them.
class SideMask {
 public:
  static SideMask all() { return SideMask(~std::uint64_t{0}); }
  static SideMask none() { return SideMask(0); }

  bool empty() const { return bits_ == 0; }
  bool has_corner(std::uint32_t i) const { return bits_ & corner_bit(i); }
  bool has_side(std::uint32_t i) const { return bits_ & side_bit(i); }
  SideMask with_corner(std::uint32_t i) const { return SideMask(bits_ | corner_bit(i)); }
  SideMask with_side(std::uint32_t i) const { return SideMask(bits_ | side_bit(i)); }
  /// Without a corner that shares its bit with no other.
  SideMask without_corner(std::uint32_t i) const { return i < kOwn ? SideMask(bits_ & ~corner_bit(i)) : *this; }
  friend SideMask operator&(SideMask a, SideMask b) { return SideMask(a.bits_ & b.bits_); }

 private:
  static constexpr std::uint32_t kOwn = 31;
  explicit SideMask(std::uint64_t bits) : bits_(bits) {}
  static std::uint64_t side_bit(std::uint32_t i) { return std::uint64_t{1} << std::min(i, kOwn); }
  static std::uint64_t corner_bit(std::uint32_t i) { return side_bit(i) << 32; }

  std::uint64_t bits_;
};

}  // namespace quench::burning
