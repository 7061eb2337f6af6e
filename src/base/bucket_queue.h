// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/bucket_lists.h"

namespace quench::base {

/// A priority queue of (key, id) for keys that mostly grow: buckets of equal width, each sorted when the queue reaches
/// it, and a heap for entries that are pushed below the end of the current bucket. Pops in the order of (key, id),
/// whatever the order of pushes, so results are reproducible. A smaller key is pushed as a new entry; the caller
/// recognizes the stale one.
template <class Id>
class BucketQueue {
 public:
  struct Entry {
    double key;
    Id id;
    friend bool operator<(const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : a.id < b.id; }
    friend bool operator>(const Entry& a, const Entry& b) { return b < a; }
  };

  BucketQueue(double origin, double width) : origin_(origin), scale_(width > 0 ? 1 / width : 0) {}

  /// For an empty queue: other keys, from about `origin` on.
  void restart(double origin) {
    origin_ = origin;
    next_ = cursor_ = 0;
    open_.clear();
  }

  void push(double key, Id id) {
    // Keys far beyond the others share the last bucket, which only costs a larger one to sort.
    const double place = std::min((key - origin_) * scale_, kMostBuckets);
    const std::size_t bucket = place > 0 ? static_cast<std::size_t>(place) : 0;
    if (bucket < next_) {
      late_.push_back({key, id});
      std::push_heap(late_.begin(), late_.end(), std::greater<>());
      return;
    }
    buckets_.put(bucket, {key, id});
  }

  /// False when empty. Entries for which stale(entry) holds are dropped when their bucket is sorted; fetch(id) is
  /// called for each entry some time before, to prefetch what `stale` reads.
  template <class Stale, class Fetch>
  bool pop(Entry& entry, const Stale& stale, const Fetch& fetch) {
    while (cursor_ == open_.size() && late_.empty()) {
      if (next_ == buckets_.size()) return false;
      open_.clear();
      buckets_.take(
          next_++, [&](const Entry& e) { fetch(e.id); },
          [&](const Entry& e) {
            if (!stale(e)) open_.push_back(e);
          });
      if (open_.size() < kWorthThreads)
        std::sort(open_.begin(), open_.end());
      else
        tbb::parallel_sort(open_.begin(), open_.end());
      cursor_ = 0;
    }
    if (!late_.empty() && (cursor_ == open_.size() || late_.front() < open_[cursor_])) {
      std::pop_heap(late_.begin(), late_.end(), std::greater<>());
      entry = late_.back();
      late_.pop_back();
    } else {
      entry = open_[cursor_++];
    }
    return true;
  }
  template <class Stale>
  bool pop(Entry& entry, const Stale& stale) {
    return pop(entry, stale, [](const Id&) {});
  }

  /// Calls visit(id) for the entry that is likely to be popped after `ahead` others, if it is known.
  template <class Visit>
  void peek(std::size_t ahead, const Visit& visit) const {
    if (cursor_ + ahead < open_.size()) visit(open_[cursor_ + ahead].id);
  }

 private:
  static constexpr double kMostBuckets = 1 << 20;
  static constexpr std::size_t kWorthThreads = 1 << 14;  // sorting fewer on several threads is slower than on one

  double origin_, scale_;
  std::size_t next_ = 0;    // the bucket after the current one
  std::size_t cursor_ = 0;  // next entry of open_
  BucketLists<Entry> buckets_;
  std::vector<Entry> open_;  // the current bucket, sorted
  std::vector<Entry> late_;  // heap of entries pushed below its end
};

}  // namespace quench::base
