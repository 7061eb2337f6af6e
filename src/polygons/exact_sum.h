// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace quench::polygons {

/// A sum of products of doubles without rounding: a fixed-point number wide enough for all of them (Kulisch's
/// accumulator). Factors are finite and below 2^150; denormal ones are exact too.
///
/// Bounds: the bits of a product are worth 2^-2148 to 2^300, and 106 of them are added to five limbs at most, so that
/// 80 limbs of 32 bits hold all; a limb takes 2^30 products before its 64 bits overflow.
class ExactSum {
 public:
  void add_product(double a, double b) {
    const Parts pa = parts(a), pb = parts(b);
    const unsigned __int128 product = static_cast<unsigned __int128>(pa.mantissa) * pb.mantissa;
    const bool negative = pa.negative != pb.negative;
    const auto place = static_cast<std::size_t>(pa.exponent + pb.exponent - 2 * kLeastExponent);
    const std::size_t limb = place / 32, shift = place % 32;
    add(static_cast<unsigned __int128>(static_cast<std::uint64_t>(product)) << shift, limb, negative);
    add((product >> 64) << shift, limb + 2, negative);
  }
  void add(double value) { add_product(value, 1); }

  /// -1, 0 or 1.
  int sign() const {
    std::int64_t carry = 0;
    bool any = false;
    for (const std::int64_t limb : limbs_) {
      const std::int64_t sum = limb + carry;
      any |= (sum & 0xFFFFFFFF) != 0;
      carry = sum >> 32;
    }
    return carry < 0 ? -1 : carry > 0 || any ? 1 : 0;
  }

 private:
  static constexpr int kLeastExponent = -1074;
  struct Parts {
    std::uint64_t mantissa;
    int exponent;
    bool negative;
  };
  static Parts parts(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const int field = static_cast<int>(bits >> 52 & 0x7FF);
    if (field == 0) return {fraction, kLeastExponent, bits >> 63 != 0};
    return {fraction | std::uint64_t{1} << 52, field - 1075, bits >> 63 != 0};
  }
  void add(unsigned __int128 bits, std::size_t limb, bool negative) {
    for (; bits != 0; bits >>= 32, ++limb) {
      const auto digit = static_cast<std::int64_t>(static_cast<std::uint64_t>(bits) & 0xFFFFFFFF);
      limbs_[limb] += negative ? -digit : digit;
    }
  }

  std::array<std::int64_t, 80> limbs_{};  // limb k is worth 2^(32 k - 2148)
};

}  // namespace quench::polygons
