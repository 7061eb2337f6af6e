// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "quench/error.h"

/// What the targets share: which ends of a reader are good ones.
namespace quench::fuzz {

[[noreturn]] inline void defect(const char* what) {
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();  // libFuzzer keeps the input
}

/// Runs a reader. Success, or one sentence as Error(input), or as Error(failed) about memory where a limit was given;
/// any other exception ends the target.
template <class Action>
void reads_or_refuses(const Action& action, bool memory_is_limited = false) {
  try {
    action();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::input && !(memory_is_limited && error.code() == ErrorCode::failed))
      defect("the error of a damaged file has another code than input");
    for (const char* c = error.what(); *c; ++c)
      if (static_cast<unsigned char>(*c) < ' ') defect("the error is not one sentence");
    if (!*error.what()) defect("the error has no sentence");
  }
}

}  // namespace quench::fuzz
