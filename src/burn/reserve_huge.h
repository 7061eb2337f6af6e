// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <cstddef>
#include <cstdint>
#include <vector>

namespace quench::burning {

/// Reserves memory for a plain vector that will be large and read at random, with huge pages under the whole pages of
/// 2 MB it covers, to save page-table walks. To be called before anything is written to it. Only a hint.
template <class T>
void reserve_huge(std::vector<T>& vector, std::size_t count) {
  vector.reserve(count);
#if defined(__linux__)
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;
  const auto begin = reinterpret_cast<std::uintptr_t>(vector.data());
  const std::uintptr_t first = (begin + page - 1) / page * page, end = (begin + count * sizeof(T)) / page * page;
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

}  // namespace quench::burning
