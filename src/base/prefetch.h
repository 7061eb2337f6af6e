// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace quench::base {

/// Asks for the memory at an address that will be read soon. Only a hint.
inline void prefetch(const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#else
  static_cast<void>(address);
#endif
}

}  // namespace quench::base
