// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace quench::burning {

/// A priority queue of (time, state) for times that mostly grow: buckets of equal width, and a heap for the bucket that
/// is open. A time below the open bucket joins the heap. Pops in the order of (time, state), whatever the order of
/// pushes; so results are reproducible. Entries overtaken by a smaller time are the caller's to drop.
class LabelQueue {
 public:
  struct Entry {
    double time;
    std::uint32_t state;
    friend bool operator>(const Entry& a, const Entry& b) {
      return a.time != b.time ? a.time > b.time : a.state > b.state;
    }
  };

  LabelQueue(double origin, double width) : origin_(origin), scale_(width > 0 ? 1 / width : 0) {}

  void push(double time, std::uint32_t state) {
    // Times far beyond the others share the last bucket, which only costs a larger heap.
    const double place = std::min((time - origin_) * scale_, kMostBuckets);
    const std::size_t bucket = place > 0 ? static_cast<std::size_t>(place) : 0;
    if (bucket < next_) {
      heap_.push_back({time, state});
      std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
      return;
    }
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
    buckets_[bucket].push_back({time, state});
  }

  /// False when empty. `stale(entry)` entries of a bucket are dropped when it opens.
  template <class Stale>
  bool pop(Entry& entry, const Stale& stale) {
    while (heap_.empty()) {
      if (next_ == buckets_.size()) return false;
      heap_.swap(buckets_[next_]);
      std::vector<Entry>().swap(buckets_[next_++]);
      std::erase_if(heap_, stale);
      std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
    }
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    entry = heap_.back();
    heap_.pop_back();
    return true;
  }

 private:
  static constexpr double kMostBuckets = 1 << 20;
  double origin_, scale_;
  std::size_t next_ = 0;  // first bucket that is not open yet
  std::vector<std::vector<Entry>> buckets_;
  std::vector<Entry> heap_;
};

}  // namespace quench::burning
