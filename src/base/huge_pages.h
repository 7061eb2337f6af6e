// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace quench::base {

/// Asks for huge pages under large arrays that are accessed at random, to save page-table walks. Only a hint; small
/// arrays are allocated as usual. With `kRaw`, resize() leaves new elements as they are: memory that has not been
/// written yet costs nothing.
template <class T, bool kRaw = false>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  struct rebind {
    using other = HugePageAllocator<U, kRaw>;
  };
  template <class U>
  HugePageAllocator(const HugePageAllocator<U, kRaw>&) {}  // NOLINT: converting on purpose, as allocators do

  static constexpr std::size_t kPage = std::size_t{1} << 21;

  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T) - kPage) throw std::bad_alloc();
    const std::size_t bytes = n * sizeof(T);
    if (bytes < 4 * kPage) return static_cast<T*>(::operator new(bytes, std::align_val_t(64)));
    void* memory = std::aligned_alloc(kPage, (bytes + kPage - 1) / kPage * kPage);
    if (!memory) throw std::bad_alloc();
#if defined(__linux__)
    madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* p, std::size_t n) noexcept {
    if (n * sizeof(T) < 4 * kPage)
      ::operator delete(p, std::align_val_t(64));
    else
      std::free(p);
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    if constexpr (kRaw && sizeof...(Arguments) == 0)
      ::new (static_cast<void*>(place)) U;
    else
      ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
  template <class U>
  bool operator==(const HugePageAllocator<U, kRaw>&) const {
    return true;
  }
};

/// Gives the memory of elements that will not be read again back to the system, in whole pages; they still belong to
/// their array, with any values. `array` must be the start of an array from HugePageAllocator, `count` its size.
template <class T>
void release_elements(T* array, std::size_t count, std::size_t first, std::size_t last) {
#if defined(__linux__)
  constexpr std::size_t kPage = HugePageAllocator<T>::kPage;
  if (count * sizeof(T) < 4 * kPage) return;
  const std::size_t begin = (first * sizeof(T) + kPage - 1) / kPage * kPage, end = last * sizeof(T) / kPage * kPage;
  if (begin < end) madvise(reinterpret_cast<char*>(array) + begin, end - begin, MADV_DONTNEED);
#else
  static_cast<void>(array), static_cast<void>(count), static_cast<void>(first), static_cast<void>(last);
#endif
}

template <class T>
using HugeVector = std::vector<T, HugePageAllocator<T>>;
template <class T>
using RawHugeVector = std::vector<T, HugePageAllocator<T, true>>;

}  // namespace quench::base
