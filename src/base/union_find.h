// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace quench::base {

/// Disjoint sets of 0 .. size-1, path halving. The root of a set is its smallest member, so that results do not depend
/// on the order of calls. 4 bytes per element.
class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size), sets_(static_cast<std::int64_t>(size)) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// True when the two were in different sets.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    if (a > b) std::swap(a, b);
    parent_[b] = a;
    --sets_;
    return true;
  }
  /// Begins anew with element i by itself. The elements of its set must all be begun anew before they are asked for;
  /// count() is lost.
  void reset(std::uint32_t i) { parent_[i] = i; }
  /// Number of sets.
  std::int64_t count() const { return sets_; }

 private:
  std::vector<std::uint32_t> parent_;
  std::int64_t sets_;
};

}  // namespace quench::base
