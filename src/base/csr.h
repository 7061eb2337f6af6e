// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "quench/error.h"

namespace quench::base {

/// Items grouped by row (compressed sparse rows): those of row r are items()[offsets()[r]] up to
/// items()[offsets()[r + 1]]. 4 bytes per row beside the items.
template <class T>
class Csr {
 public:
  Csr() = default;

  /// Groups items of the rows 0 .. rows - 1; within a row they keep the order in which they are given. `visit(emit)`
  /// calls emit(row, item) for every item; it is run twice, to count and to fill, and must give the same items both
  /// times. O(rows + items). Throws Error(failed) for 2^32 items or more.
  template <class Visit>
  static Csr group(std::size_t rows, const Visit& visit) {
    Csr csr;
    // While the items are put in, offsets_[r + 1] is the place of the next one of row r: it ends as the end of the row.
    csr.offsets_.assign(rows + 2, 0);
    std::uint64_t count = 0;
    visit([&](std::size_t row, const T&) {
      ++csr.offsets_[row + 2];
      ++count;
    });
    if (count > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::failed, "an index has more than 2^32 entries; use a smaller or coarser input");
    for (std::size_t r = 2; r <= rows; ++r) csr.offsets_[r + 1] += csr.offsets_[r];
    csr.items_.resize(count);
    visit([&](std::size_t row, const T& item) { csr.items_[csr.offsets_[row + 1]++] = item; });
    csr.offsets_.pop_back();
    return csr;
  }

  std::size_t rows() const { return offsets_.size() - 1; }
  std::span<const T> operator[](std::size_t row) const {
    return {items_.data() + offsets_[row], items_.data() + offsets_[row + 1]};
  }
  std::span<T> operator[](std::size_t row) {
    return {items_.data() + offsets_[row], items_.data() + offsets_[row + 1]};
  }
  /// rows() + 1 offsets into items().
  const std::vector<std::uint32_t>& offsets() const { return offsets_; }
  const std::vector<T>& items() const { return items_; }

 private:
  std::vector<std::uint32_t> offsets_{0};
  std::vector<T> items_;
};

}  // namespace quench::base
