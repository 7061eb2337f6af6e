// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace quench::base {

/// Gives memory that was freed back to the system. Many threads leave much of it behind in their heaps, between what is
/// still held there, where large arrays find no room. Milliseconds per gigabyte; does nothing without glibc.
inline void return_free_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace quench::base
