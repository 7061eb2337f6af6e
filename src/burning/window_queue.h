// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/bucket_lists.h"
#include "base/bucket_queue.h"

namespace quench::burning {

/// A part of space per state, so that the states of a part, and what fire reads of them, fit a processor's cache.
struct Blocks {
  std::vector<std::uint16_t> of_state;
  std::uint32_t count = 1;
};

using StateQueue = base::BucketQueue<std::uint32_t>;  ///< of states, by time

/// A queue of states by time for label correction, which may take states out of order at a price: those of one block
/// after those of another, within a window of time. States in the order of time alone lie all over a shape, and waiting
/// for memory was half of the cost of burning.
///
/// Windows of time open one after the other; in a window the blocks take turns. A block's turn lasts until it has
/// nothing left in the window, in the order of (time, state); what it sends to another block waits for that one's turn,
/// in the same window if it has to. With one block, this is the order of (time, state). The order depends on what is
/// pushed only, so results are reproducible.
///
/// What waits is a list of states: a time that drops within its window, as most do, costs nothing.
class WindowQueue {
 public:
  WindowQueue(double origin, double width, Blocks blocks)
      : origin_(origin),
        width_(width),
        scale_(width > 0 ? 1 / width : 0),
        blocks_(std::move(blocks)),
        turn_(origin, width / kParts) {}

  /// Queues a state that is not queued, or has been popped.
  void push(std::uint32_t state, double time) {
    if (const std::size_t window = window_of(time); window >= next_)
      lists_.put(blocks_.count + window, state);
    else
      join(state, time, false);
  }
  /// Moves a state that is queued with time `before` to an earlier time.
  void lower(std::uint32_t state, double before, double time) {
    const std::size_t from = window_of(before), window = window_of(time);
    if (window < next_)
      join(state, time, from < next_);
    else if (window != from)
      lists_.put(blocks_.count + window, state);
  }

  /// The next state; false when empty. `time_of(state)` is its time, infinite when it is not queued any more;
  /// `fetch(state)` is called some time before, to prefetch what that reads.
  template <class TimeOf, class Fetch>
  bool pop(std::uint32_t& state, const TimeOf& time_of, const Fetch& fetch) {
    const auto overtaken = [&](const StateQueue::Entry& e) { return e.key != time_of(e.id); };
    do {
      for (StateQueue::Entry entry{}; turn_.pop(entry, overtaken);)
        if (!overtaken(entry)) {
          state = entry.id;
          return true;
        }
    } while (next_turn(time_of, fetch));
    return false;
  }

 private:
  static constexpr int kParts = 32;  // buckets of a turn: of ten states or so each
  // Times far beyond the others share the last window, which costs time only.
  static constexpr double kMostWindows = 1 << 20;
  std::size_t window_of(double time) const {
    const double place = std::min((time - origin_) * scale_, kMostWindows);
    return place > 0 ? static_cast<std::size_t>(place) : 0;
  }

  // False when nothing is left.
  template <class TimeOf, class Fetch>
  bool next_turn(const TimeOf& time_of, const Fetch& fetch) {
    if (waits_ > 0) {
      block_ = block_ + 1 == blocks_.count ? 0 : block_ + 1;
    } else {
      if (blocks_.count + next_ >= lists_.size()) return false;
      lists_.take(
          blocks_.count + next_++, [](std::uint32_t) {}, [&](std::uint32_t s) { wait(blocks_.of_state[s], s); });
      block_ = 0;
    }
    turn_.restart(origin_ + static_cast<double>(next_ - 1) * width_);
    lists_.take(block_, fetch, [&](std::uint32_t s) {
      --waits_;
      if (const double time = time_of(s); window_of(time) < next_) turn_.push(time, s);
    });
    return true;
  }

  // Into a window that is open. Where the block's turn is still to come, `waits` already is enough.
  void join(std::uint32_t state, double time, bool waits) {
    const std::uint32_t block = blocks_.of_state[state];
    if (block == block_)
      turn_.push(time, state);
    else if (!waits)
      wait(block, state);
  }
  void wait(std::uint32_t block, std::uint32_t state) {
    lists_.put(block, state);
    ++waits_;
  }

  double origin_, width_, scale_;
  Blocks blocks_;
  // Of states: per block what waits for its turn in the open windows; then one per window.
  base::BucketLists<std::uint32_t> lists_;
  std::size_t next_ = 0;     // first window that is not open yet
  std::size_t waits_ = 0;    // states in the lists of blocks
  std::uint32_t block_ = 0;  // whose turn it is
  StateQueue turn_;
};

}  // namespace quench::burning
