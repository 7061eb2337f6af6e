// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace quench::burning {

/// A priority queue of (time, state) for times that mostly grow: buckets of equal width, sorted when they open, and a
/// heap for times that come in below the open bucket's end. Pops in the order of (time, state), whatever the order of
/// pushes; so results are reproducible. Entries overtaken by a smaller time are the caller's to drop.
class LabelQueue {
 public:
  struct Entry {
    double time;
    std::uint32_t state;
    friend bool operator<(const Entry& a, const Entry& b) {
      return a.time != b.time ? a.time < b.time : a.state < b.state;
    }
    friend bool operator>(const Entry& a, const Entry& b) { return b < a; }
  };

  LabelQueue(double origin, double width) : origin_(origin), scale_(width > 0 ? 1 / width : 0) {}

  void push(double time, std::uint32_t state) {
    // Times far beyond the others share the last bucket, which only costs a larger one to sort.
    const double place = std::min((time - origin_) * scale_, kMostBuckets);
    const std::size_t bucket = place > 0 ? static_cast<std::size_t>(place) : 0;
    if (bucket < next_) {
      late_.push_back({time, state});
      std::push_heap(late_.begin(), late_.end(), std::greater<>());
      return;
    }
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
    buckets_[bucket].push_back({time, state});
  }

  /// False when empty. `stale(entry)` entries of a bucket are dropped when it opens.
  template <class Stale>
  bool pop(Entry& entry, const Stale& stale) {
    while (cursor_ == open_.size() && late_.empty()) {
      if (next_ == buckets_.size()) return false;
      open_.clear();
      open_.swap(buckets_[next_]);
      std::vector<Entry>().swap(buckets_[next_++]);
      std::erase_if(open_, stale);
      std::sort(open_.begin(), open_.end());
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

  /// Calls visit(state) for the entry that is likely to be popped after `ahead` others, if it is known.
  template <class Visit>
  void peek(std::size_t ahead, const Visit& visit) const {
    if (cursor_ + ahead < open_.size()) visit(open_[cursor_ + ahead].state);
  }

 private:
  static constexpr double kMostBuckets = 1 << 20;
  double origin_, scale_;
  std::size_t next_ = 0;    // first bucket that is not open yet
  std::size_t cursor_ = 0;  // in open_
  std::vector<std::vector<Entry>> buckets_;
  std::vector<Entry> open_, late_;
};

}  // namespace quench::burning
