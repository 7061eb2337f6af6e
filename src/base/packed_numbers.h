// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "quench/error.h"
#include "quench/geometry.h"

namespace quench::base {

/// Appends numbers to bytes; small ones take few: 7 bits per byte, the lowest first, the highest bit says that more
/// follow.
class NumberPacker {
 public:
  std::string bytes;

  void add(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<char>(value | 0x80));
    bytes.push_back(static_cast<char>(value));
  }
  /// Of either sign: 0, -1, 1, -2 ... as 0, 1, 2, 3 ...
  void add_signed(std::int64_t value) { add(folded(value)); }
  void add_double(double value) {
    char copy[sizeof value];
    std::memcpy(copy, &value, sizeof value);
    bytes.append(copy, sizeof value);
  }
  /// Points in order of z, y, x take one byte or two each.
  void add_points(const std::vector<LatticePoint>& points) {
    add(points.size());
    LatticePoint last{0, 0, 0};
    for (const LatticePoint& p : points) {
      const auto step = [&](std::size_t a) { return std::int64_t{p[a]} - last[a]; };
      if (p[2] == last[2] && p[1] == last[1] && p[0] > last[0]) {
        add(static_cast<std::uint64_t>(step(0)) << 1);
      } else {
        add(folded(step(2)) << 1 | 1);
        add_signed(step(1));
        add_signed(step(0));
      }
      last = p;
    }
  }

 private:
  static std::uint64_t folded(std::int64_t value) {
    return static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
  }
};

/// Reads them again. Throws Error(input), "it is damaged", where they cannot be.
class NumberReader {
 public:
  explicit NumberReader(std::string_view bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

  std::uint64_t next() {
    std::uint64_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      if (at_ == end_ || shift > 63) damaged();
      const auto byte = static_cast<unsigned char>(*at_++);
      value |= std::uint64_t{byte & 0x7Fu} << shift;
      if (byte < 0x80) return value;
    }
  }
  std::int64_t next_signed() { return signed_of(next()); }
  double next_double() {
    double value = 0;
    if (end_ - at_ < static_cast<std::ptrdiff_t>(sizeof value)) damaged();
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  unsigned next_byte() {
    if (at_ == end_) damaged();
    return static_cast<unsigned char>(*at_++);
  }
  /// A number of at most `most`.
  std::uint64_t next_up_to(std::uint64_t most) {
    const std::uint64_t value = next();
    if (value > most) damaged();
    return value;
  }
  /// A number of things of which each takes a byte or more.
  std::size_t next_count() { return next_up_to(static_cast<std::uint64_t>(end_ - at_)); }
  std::vector<LatticePoint> next_points() {
    std::vector<LatticePoint> points(next_count());
    LatticePoint last{0, 0, 0};
    for (LatticePoint& p : points) {
      const std::uint64_t first = next();
      if (first & 1) {
        last[2] = moved(last[2], signed_of(first >> 1));
        last[1] = moved(last[1], next_signed());
        last[0] = moved(last[0], next_signed());
      } else {
        last[0] = moved(last[0], static_cast<std::int64_t>(first >> 1));
      }
      p = last;
    }
    return points;
  }
  bool at_end() const { return at_ == end_; }
  [[noreturn]] static void damaged() { throw Error(ErrorCode::input, "it is damaged"); }

 private:
  static std::int64_t signed_of(std::uint64_t value) {
    return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
  }
  static std::int32_t moved(std::int32_t from, std::int64_t by) {
    const std::int64_t to =
        by > 2 * std::int64_t{INT32_MAX} + 1 || by < 2 * std::int64_t{INT32_MIN} ? INT64_MAX : from + by;
    if (to > INT32_MAX || to < INT32_MIN) damaged();
    return static_cast<std::int32_t>(to);
  }

  const char *at_, *end_;
};

}  // namespace quench::base
