// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace quench {

/// Whether tests do all they can (QUENCH_TEST_FULL=1). Otherwise those that repeat the same on many shapes take a part
/// of the repetitions, spread over all of them.
inline bool full_run() { return std::getenv("QUENCH_TEST_FULL") != nullptr; }

/// How often to repeat something.
template <class T>
T repeats(T in_full_run, T otherwise) {
  return full_run() ? in_full_run : otherwise;
}

}  // namespace quench
