// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/bucket_lists.h"
#include "base/bucket_queue.h"

namespace quench::burning {

/// A block of space per state, such that the states of a block, and what fire reads of them, fit a processor's cache.
/// Blocks of one colour share no node that fire from either of them can reach: they can be processed at the same time.
struct Blocks {
  std::vector<std::uint16_t> of_state;
  std::vector<std::uint32_t> color_end = {1};  ///< per colour: the first block after it; blocks are numbered by colours

  std::uint32_t count() const { return color_end.back(); }
};

using StateQueue = base::BucketQueue<std::uint32_t>;  ///< of states, by time

/// A queue of states by time for label correcting, which need not pop states in the order of time: within a window of
/// time it pops the states of one block after those of another. In the order of time alone, states that follow each
/// other lie all over a shape, and cache misses were half of the cost of burning.
///
/// Windows are processed in the order of time, and within a window the blocks colour by colour, again and again until
/// none has a state in it, those of one colour on all threads. A block pops its states in the order of (time, state)
/// until it has none left in the window; states that are pushed into other blocks meanwhile are deferred until these
/// are processed. With one block, the order is that of (time, state). What is popped depends on what is pushed only, so
/// results are reproducible, on any number of threads.
///
/// Deferred states are stored without keys, so decreasing a label within its window needs no queue operation.
class WindowQueue {
 public:
  WindowQueue() : WindowQueue(0, 0, {}) {}
  /// Times are about `origin` or later; `width`: of a window.
  WindowQueue(double origin, double width, Blocks blocks)
      : origin_(origin), width_(width), scale_(width > 0 ? 1 / width : 0), blocks_(std::move(blocks)) {}

  /// What one thread needs to process a block.
  class Worker {
   public:
    explicit Worker(const WindowQueue& queue) : queue_(queue), states_(queue.origin_, queue.width_ / kParts) {}

    /// Queues a state that is not in the queue, or has been popped.
    void push(std::uint32_t state, double time) {
      if (const std::size_t window = queue_.window_of(time); window >= queue_.next_)
        put(queue_.blocks_.count() + window, state);
      else
        enqueue_now(state, time, false);
    }
    /// Moves a state that is queued with time `before` to an earlier time.
    void lower(std::uint32_t state, double before, double time) {
      const std::size_t from = queue_.window_of(before), window = queue_.window_of(time);
      if (window < queue_.next_)
        enqueue_now(state, time, from < queue_.next_);
      else if (window != from)
        put(queue_.blocks_.count() + window, state);
    }
    /// The next state of the block; false when it has none left in the window. `time_of(state)` is its time, infinite
    /// when it is no longer queued.
    template <class TimeOf>
    bool pop(std::uint32_t& state, const TimeOf& time_of) {
      const auto stale = [&](const StateQueue::Entry& e) { return e.key != time_of(e.id); };
      for (StateQueue::Entry entry{}; states_.pop(entry, stale);)
        if (!stale(entry)) {
          state = entry.id;
          ++popped_;
          return true;
        }
      return false;
    }

   private:
    friend WindowQueue;
    // Inserts into the active window. If the block of the state has not been processed yet, deferring suffices, and
    // where it is deferred already (`deferred`) nothing is to be done.
    void enqueue_now(std::uint32_t state, double time, bool deferred) {
      const std::uint32_t block = queue_.blocks_.of_state[state];
      if (block == block_)
        states_.push(time, state);
      else if (!deferred)
        put(block, state);
    }
    void put(std::size_t list, std::uint32_t state) { outbox_.emplace_back(static_cast<std::uint32_t>(list), state); }

    const WindowQueue& queue_;
    std::uint32_t block_ = 0;
    StateQueue states_;                                            // of the block, in the active window
    std::vector<std::pair<std::uint32_t, std::uint32_t>> outbox_;  // (list, state): for other blocks or windows
    std::uint64_t popped_ = 0;
  };

  /// Queues a state before the first run().
  void push(std::uint32_t state, double time) { lists_.put(blocks_.count() + window_of(time), state); }

  /// Processes all states: calls work(worker) for every block that has some, on several threads at the same time for
  /// blocks of one colour; `work` pops until there are none. `make_worker()` makes a Worker, or what derives from it.
  /// `time_of` is as for pop(); `fetch(state)` prefetches what it reads; pause(popped) is called every now and then, on
  /// the thread of the caller, with the number of states popped so far.
  template <class MakeWorker, class TimeOf, class Fetch, class Work, class Pause>
  void run(const MakeWorker& make_worker, const TimeOf& time_of, const Fetch& fetch, const Work& work,
           const Pause& pause) {
    tbb::enumerable_thread_specific<decltype(make_worker())> workers(make_worker);
    std::vector<Task> tasks;
    while (blocks_.count() + next_ < lists_.size()) {
      lists_.take(
          blocks_.count() + next_++, [](std::uint32_t) {},
          [&](std::uint32_t s) { lists_.put(blocks_.of_state[s], s); });
      for (bool again = true; again;) {
        again = false;
        for (std::size_t color = 0; color < blocks_.color_end.size(); ++color) {
          const std::size_t states = take_blocks(color, tasks);
          if (tasks.empty()) continue;
          again = true;
          const auto process = [&](std::size_t i) {
            auto& worker = workers.local();
            start(worker, tasks[i], time_of, fetch);
            work(worker);
          };
          if (states < kWorthThreads || tasks.size() == 1)
            for (std::size_t i = 0; i < tasks.size(); ++i) process(i);
          else
            tbb::parallel_for(std::size_t{0}, tasks.size(), process, tbb::simple_partitioner());
          std::uint64_t popped = 0;
          for (Worker& worker : workers) {
            for (const auto& [list, state] : worker.outbox_) lists_.put(list, state);
            worker.outbox_.clear();
            popped += worker.popped_;
          }
          pause(popped);
        }
      }
    }
  }

 private:
  static constexpr int kParts = 32;  // buckets of a window: about ten states of a block in each
  static constexpr std::size_t kWorthThreads = 64;
  // Times far beyond the others share the last window, which only makes it slower.
  static constexpr double kMostWindows = 1 << 20;
  std::size_t window_of(double time) const {
    const double place = std::min((time - origin_) * scale_, kMostWindows);
    return place > 0 ? static_cast<std::size_t>(place) : 0;
  }

  struct Task {
    std::uint32_t block;
    std::vector<std::uint32_t> states;
  };
  // The blocks of a colour that have deferred states, with these; returns the number of all.
  std::size_t take_blocks(std::size_t color, std::vector<Task>& tasks) {
    tasks.clear();
    std::size_t states = 0;
    for (std::uint32_t b = color == 0 ? 0 : blocks_.color_end[color - 1]; b < blocks_.color_end[color]; ++b) {
      if (lists_.is_empty(b)) continue;
      tasks.push_back({b, {}});
      lists_.take(
          b, [](std::uint32_t) {}, [&](std::uint32_t s) { tasks.back().states.push_back(s); });
      states += tasks.back().states.size();
    }
    return states;
  }
  template <class TimeOf, class Fetch>
  void start(Worker& worker, const Task& task, const TimeOf& time_of, const Fetch& fetch) const {
    worker.block_ = task.block;
    worker.states_.restart(origin_ + static_cast<double>(next_ - 1) * width_);
    for (const std::uint32_t s : task.states) fetch(s);
    for (const std::uint32_t s : task.states)
      if (const double time = time_of(s); window_of(time) < next_) worker.states_.push(time, s);
  }

  double origin_, width_, scale_;
  Blocks blocks_;
  // Lists of states: first one per block, of its deferred states in the active window; then one per later window.
  base::BucketLists<std::uint32_t> lists_;
  std::size_t next_ = 0;  // the window after the active one
};

}  // namespace quench::burning
