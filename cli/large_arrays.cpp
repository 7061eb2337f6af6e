// SPDX-License-Identifier: Apache-2.0
// Puts the program's large arrays on huge pages: everything walks through arrays of hundreds of megabytes at random,
// and page faults and page-table walks take 4 to 10 % of its time otherwise. The library leaves the allocator to its
// user.
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <malloc.h>
#include <sys/mman.h>

namespace {

constexpr std::size_t kPage = std::size_t{1} << 21, kLarge = 4 * kPage;  // 8 MB

#if defined(__GLIBC__)
// Large arrays have mappings of their own, so that their memory goes back to the system when they go. Otherwise glibc
// takes those below 32 MB from heaps that stay as large as they ever were (a fifth more memory on thin shapes).
[[maybe_unused]] const int own_mappings = mallopt(M_MMAP_THRESHOLD, kLarge);
#endif

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
