// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "base/parallel.h"

namespace quench::base {

/// The cofaces that are left of a cell (the faces at an edge, the edges at a vertex) as count * 2^32 + sum of indices:
/// if the count is 1, the low word is the index of the only one. A coface may be added twice, as a loop is to its
/// vertex. With `shared`, several threads may add at the same time, in any order. Cofaces{} is none; without
/// initializer the value is undefined, as that of an integer, so that large arrays are first written by those who fill
/// them.
class Cofaces {
 public:
  void add(std::uint32_t cell, bool shared = false) { fetch_add(sum_, one(cell), shared); }
  void remove(std::uint32_t cell, bool shared = false) { fetch_add(sum_, -one(cell), shared); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(sum_ >> 32); }
  bool none() const { return sum_ == 0; }
  bool single() const { return count() == 1; }
  std::uint32_t only() const { return static_cast<std::uint32_t>(sum_); }

 private:
  static std::uint64_t one(std::uint32_t cell) { return std::uint64_t{1} << 32 | cell; }
  std::uint64_t sum_;
};

}  // namespace quench::base
