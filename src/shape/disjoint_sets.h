// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace quench::detail {

/// Disjoint sets of 0 .. size-1 (union-find with path halving; the smaller index is the root). 4 bytes per element.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size), sets_(static_cast<std::int64_t>(size)) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t element) {
    while (parent_[element] != element) element = parent_[element] = parent_[parent_[element]];
    return element;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return;
    if (b < a) std::swap(a, b);
    parent_[b] = a;
    --sets_;
  }
  std::int64_t count() const { return sets_; }

 private:
  std::vector<std::uint32_t> parent_;
  std::int64_t sets_;
};

}  // namespace quench::detail
