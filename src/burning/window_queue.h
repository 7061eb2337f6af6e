// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/bucket_lists.h"
#include "base/bucket_queue.h"

namespace quench::burning {

/// A block of space per state, such that the states of a block, and what fire reads of them, fit a processor's cache.
struct Blocks {
  std::vector<std::uint16_t> of_state;
  std::uint32_t count = 1;
};

using StateQueue = base::BucketQueue<std::uint32_t>;  ///< of states, by time

/// A queue of states by time for label correcting, which need not pop states in the order of time: within a window of
/// time it pops the states of one block after those of another. In the order of time alone, states that follow each
/// other lie all over a shape, and cache misses were half of the cost of burning.
///
/// Windows are processed in the order of time, and within a window the blocks in the order of their numbers, again and
/// again until none has a state in it. A block pops its states in the order of (time, state) until it has none left in
/// the window; states that are pushed into other blocks meanwhile are deferred until these are processed. With one
/// block, the order is that of (time, state). The order depends on what is pushed only, so results are reproducible.
///
/// Deferred states are stored without keys, so decreasing a label within its window needs no queue operation.
class WindowQueue {
 public:
  WindowQueue() : WindowQueue(0, 0, {}) {}
  /// Times are about `origin` or later; `width`: of a window.
  WindowQueue(double origin, double width, Blocks blocks)
      : origin_(origin),
        width_(width),
        scale_(width > 0 ? 1 / width : 0),
        blocks_(std::move(blocks)),
        active_bucket_(origin, width / kParts) {}

  /// Queues a state that is not in the queue, or has been popped.
  void push(std::uint32_t state, double time) {
    if (const std::size_t window = window_of(time); window >= next_)
      lists_.put(blocks_.count + window, state);
    else
      enqueue_now(state, time, false);
  }
  /// Moves a state that is queued with time `before` to an earlier time.
  void lower(std::uint32_t state, double before, double time) {
    const std::size_t from = window_of(before), window = window_of(time);
    if (window < next_)
      enqueue_now(state, time, from < next_);
    else if (window != from)
      lists_.put(blocks_.count + window, state);
  }

  /// The next state; false when the queue is empty. `time_of(state)` is its time, infinite when it is no longer queued;
  /// `fetch(state)` is called some time before, to prefetch what `time_of` reads.
  template <class TimeOf, class Fetch>
  bool pop(std::uint32_t& state, const TimeOf& time_of, const Fetch& fetch) {
    const auto stale = [&](const StateQueue::Entry& e) { return e.key != time_of(e.id); };
    do {
      for (StateQueue::Entry entry{}; active_bucket_.pop(entry, stale);)
        if (!stale(entry)) {
          state = entry.id;
          return true;
        }
    } while (next_block(time_of, fetch));
    return false;
  }

 private:
  static constexpr int kParts = 32;  // buckets of a window: about ten states of a block in each
  // Times far beyond the others share the last window, which only makes it slower.
  static constexpr double kMostWindows = 1 << 20;
  std::size_t window_of(double time) const {
    const double place = std::min((time - origin_) * scale_, kMostWindows);
    return place > 0 ? static_cast<std::size_t>(place) : 0;
  }

  // Activates the next block with deferred states, of the next window where there are none; false when nothing is left.
  template <class TimeOf, class Fetch>
  bool next_block(const TimeOf& time_of, const Fetch& fetch) {
    if (deferred_ > 0) {
      block_ = block_ + 1 == blocks_.count ? 0 : block_ + 1;
    } else {
      if (blocks_.count + next_ >= lists_.size()) return false;
      lists_.take(
          blocks_.count + next_++, [](std::uint32_t) {}, [&](std::uint32_t s) { defer(blocks_.of_state[s], s); });
      block_ = 0;
    }
    active_bucket_.restart(origin_ + static_cast<double>(next_ - 1) * width_);
    lists_.take(block_, fetch, [&](std::uint32_t s) {
      --deferred_;
      if (const double time = time_of(s); window_of(time) < next_) active_bucket_.push(time, s);
    });
    return true;
  }

  // Inserts into the active window. If the block of the state has not been processed yet, deferring suffices, and where
  // it is deferred already (`deferred`) nothing is to be done.
  void enqueue_now(std::uint32_t state, double time, bool deferred) {
    const std::uint32_t block = blocks_.of_state[state];
    if (block == block_)
      active_bucket_.push(time, state);
    else if (!deferred)
      defer(block, state);
  }
  void defer(std::uint32_t block, std::uint32_t state) {
    lists_.put(block, state);
    ++deferred_;
  }

  double origin_, width_, scale_;
  Blocks blocks_;
  // Lists of states: first one per block, of its deferred states in the active window; then one per later window.
  base::BucketLists<std::uint32_t> lists_;
  std::size_t next_ = 0;      // the window after the active one
  std::size_t deferred_ = 0;  // number of states in the lists of blocks
  std::uint32_t block_ = 0;   // the active block
  StateQueue active_bucket_;  // its states in the active window
};

}  // namespace quench::burning
