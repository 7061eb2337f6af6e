// SPDX-License-Identifier: Apache-2.0
// Puts the program's large arrays on huge pages: everything walks through arrays of hundreds of megabytes at random,
// and page faults and page-table walks take some 8 % of its time otherwise. The library leaves the allocator to its
// user.
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>

namespace {

constexpr std::size_t kPage = std::size_t{1} << 21, kLarge = 4 * kPage;

void* allocate(std::size_t bytes) {
  if (bytes < kLarge) return std::malloc(bytes ? bytes : 1);
  if (bytes > static_cast<std::size_t>(-1) - kPage) return nullptr;
  void* memory = std::aligned_alloc(kPage, (bytes + kPage - 1) / kPage * kPage);
  if (memory) madvise(memory, bytes, MADV_HUGEPAGE);  // only a hint
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) {
  for (;;) {
    if (void* memory = allocate(bytes)) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif
