// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <string_view>
#include <thread>
#include <utility>

#include "quench/context.h"

namespace quench::base {

/// Runs `work` on as many threads as the context asks for, without a wish on those of the caller. Every public function
/// that takes a context and works in parallel goes through it. Nested calls with the same context stay in one arena, so
/// that for_chunks() always finds the calling thread in it. Of an arena larger than what TBB may use it would complain
/// on stderr.
template <class Work>
auto in_arena(const Context* context, const Work& work) {
  if (!context || context->threads <= 0) return work();
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int threads = static_cast<int>(std::min(static_cast<std::size_t>(context->threads), allowed));
  if (threads == tbb::this_task_arena::max_concurrency()) return work();
  tbb::task_arena arena(threads);
  return arena.execute(work);
}

/// Runs body(chunk) for every chunk in [0, chunks) on the threads of the arena. Every chunk asks first whether the
/// caller wants to stop. Progress of the stage, from `begin` to `end`, is told by the calling thread only, which works
/// too. Results must not depend on which chunk comes first.
template <class Body>
void for_chunks(std::size_t chunks, Context* context, std::string_view stage, double begin, double end,
                const Body& body) {
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> done{0};
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    if (std::this_thread::get_id() == caller)
      checkpoint(context, stage,
                 begin + (end - begin) * static_cast<double>(done.load(std::memory_order_relaxed)) /
                             static_cast<double>(chunks));
    else if (context && context->cancelled())
      return;  // the caller throws
    body(chunk);
    done.fetch_add(1, std::memory_order_relaxed);
  });
  checkpoint(context, stage, end);
}

/// Whether more than one thread may be at work, in the arena of the caller.
inline bool several_threads() { return tbb::this_task_arena::max_concurrency() > 1; }

/// Adds to a counter and returns what it was before; `shared`: other threads may add at the same time. Without them a
/// locked instruction would be a waste.
template <class T>
T fetch_add(T& counter, T by, bool shared) {
  if (shared) return std::atomic_ref<T>(counter).fetch_add(by, std::memory_order_relaxed);
  const T old = counter;
  counter += by;
  return old;
}

/// Raises a place that other threads may raise at the same time. A maximum does not depend on who comes first.
inline void raise(double& place, double value) {
  const std::atomic_ref<double> shared(place);
  double old = shared.load(std::memory_order_relaxed);
  while (old < value && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

/// The chunk-th of `chunks` nearly equal parts of [0, count).
inline std::pair<std::size_t, std::size_t> part_of(std::size_t count, std::size_t chunk, std::size_t chunks) {
  const auto at = [&](std::size_t i) { return count / chunks * i + count % chunks * i / chunks; };
  return {at(chunk), at(chunk + 1)};
}

/// Number of chunks of about `size` elements; one task each.
inline std::size_t chunks_for(std::size_t count, std::size_t size = std::size_t{1} << 16) { return count / size + 1; }

/// Calls body(i) for every i in [0, count), in chunks on the threads of the arena.
template <class Body>
void for_indices(std::size_t count, const Body& body) {
  const std::size_t chunks = chunks_for(count);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    const auto [first, last] = part_of(count, chunk, chunks);
    for (std::size_t i = first; i < last; ++i) body(i);
  });
}

}  // namespace quench::base
