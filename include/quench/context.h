// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "quench/error.h"

namespace quench {

/// How a long computation talks to its caller: threads, progress, notes, cancel. One object per computation; a null
/// pointer is allowed wherever a `Context*` is taken.
///
/// `cancel()` may be called from any thread and from a signal handler, and is idempotent. `progress` and `note` are
/// called from one thread at a time; the fraction grows within a pass of a stage and ends at 1.
class Context {
 public:
  /// How many threads every function that takes a context works on, at most as many as TBB may use; 0: those of the
  /// caller's task arena, all processors outside of any. What takes no context always works in the caller's arena.
  int threads = 0;
  std::function<void(std::string_view stage, double fraction)> progress;  ///< may be empty
  std::function<void(const std::string& sentence)> note;  ///< what the caller should know, e.g. warnings
  std::int64_t memory_limit = 0;                          ///< bytes a computation may hold; 0: the memory that is free

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> cancelled_{false};
};

/// Throws Error(cancelled) when the caller asked to stop; reports progress otherwise. Cheap enough for every few
/// thousand steps of a loop.
inline void checkpoint(Context* context, std::string_view stage, double fraction) {
  if (!context) return;
  if (context->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  if (context->progress) context->progress(stage, fraction);
}

inline void note(Context* context, const std::string& sentence) {
  if (context && context->note) context->note(sentence);
}

}  // namespace quench
