// SPDX-License-Identifier: Apache-2.0
// A file of its own: a compiler that sees both the operators and their callers takes free() for a mistake.
#include "failing_memory.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> failing{false};
std::atomic<int> left{0};
thread_local bool concerned_here = false;

void* allocated(std::size_t size, std::size_t alignment) {
  if (concerned_here && failing && left.fetch_sub(1) <= 0) throw std::bad_alloc();
  void* memory = alignment == 0 ? std::malloc(size ? size : 1)
                                : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

void failing_memory::begin(int allocations) {
  left = allocations;
  failing = true;
}

void failing_memory::end() { failing = false; }

void failing_memory::concern_this_thread(bool concerned) { concerned_here = concerned; }

void* operator new(std::size_t size) { return allocated(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocated(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
