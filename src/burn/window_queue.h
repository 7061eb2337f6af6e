// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "bucket_lists.h"

namespace quench::burning {

/// A part of space per state, so that the states of a part, and what fire reads of them, fit a processor's cache.
struct Blocks {
  std::vector<std::uint16_t> of_state;
  std::uint32_t count = 1;
};

/// A queue of states by time for label correction, which may take states out of order at a price: those of one block
/// after those of another, within a window of time. States in the order of time alone lie all over a shape, and waiting
/// for memory was half of the cost of burning.
///
/// Windows of time open one after the other; in a window the blocks take turns. A block's turn lasts until it has
/// nothing left in the window, in the order of (time, state); what it sends to another block waits for that one's turn,
/// in the same window if it has to. With one block, this is the order of (time, state). The order depends on what is
/// pushed only, so results are reproducible. Entries overtaken by a smaller time are the caller's to drop.
class WindowQueue {
 public:
  struct Entry {
    double time;
    std::uint32_t state;
    friend bool operator>(const Entry& a, const Entry& b) {
      return a.time != b.time ? a.time > b.time : a.state > b.state;
    }
  };

  WindowQueue(double origin, double width, Blocks blocks)
      : origin_(origin), scale_(width > 0 ? 1 / width : 0), blocks_(std::move(blocks)), waiting_(blocks_.count) {}

  void push(double time, std::uint32_t state) {
    // Times far beyond the others share the last window, which costs time only.
    const double place = std::min((time - origin_) * scale_, kMostWindows);
    const std::size_t window = place > 0 ? static_cast<std::size_t>(place) : 0;
    if (window < next_)
      wait({time, state});
    else
      windows_.put(window, {time, state});
  }

  /// False when empty. `stale(entry)` entries are dropped when their window opens; `fetch(state)` is called for each
  /// some time before, to prefetch what `stale` reads.
  template <class Stale, class Fetch>
  bool pop(Entry& entry, const Stale& stale, const Fetch& fetch) {
    while (waiting_[turn_].empty()) {
      if (waits_ == 0) {
        if (next_ == windows_.size()) return false;
        turn_ = kNobody;
        windows_.take(
            next_++, [&](const Entry& e) { fetch(e.state); },
            [&](const Entry& e) {
              if (!stale(e)) wait(e);
            });
        turn_ = 0;
      } else {
        turn_ = turn_ + 1 == blocks_.count ? 0 : turn_ + 1;
      }
      std::make_heap(waiting_[turn_].begin(), waiting_[turn_].end(), std::greater<>());
    }
    std::vector<Entry>& heap = waiting_[turn_];
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    entry = heap.back();
    heap.pop_back();
    --waits_;
    return true;
  }

 private:
  static constexpr double kMostWindows = 1 << 20;
  static constexpr std::uint32_t kNobody = ~std::uint32_t{0};

  void wait(const Entry& entry) {
    const std::uint32_t block = blocks_.of_state[entry.state];
    waiting_[block].push_back(entry);
    ++waits_;
    if (block == turn_) std::push_heap(waiting_[block].begin(), waiting_[block].end(), std::greater<>());
  }

  double origin_, scale_;
  Blocks blocks_;
  BucketLists<Entry> windows_;
  std::size_t next_ = 0;                     // first window that is not open yet
  std::vector<std::vector<Entry>> waiting_;  // per block, in the open windows; a heap for the one whose turn it is
  std::size_t waits_ = 0;                    // in all blocks
  std::uint32_t turn_ = 0;
};

}  // namespace quench::burning
