// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace quench {

/// A priority queue of (key, id) for keys that mostly grow: buckets of equal width, sorted when they open, and a heap
/// for entries that come in below the open bucket's end. Pops in the order of (key, id), whatever the order of pushes;
/// so results are reproducible. Entries overtaken by a smaller key are the caller's to drop.
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

  void push(double key, Id id) {
    // Keys far beyond the others share the last bucket, which only costs a larger one to sort.
    const double place = std::min((key - origin_) * scale_, kMostBuckets);
    const std::size_t bucket = place > 0 ? static_cast<std::size_t>(place) : 0;
    if (bucket < next_) {
      push_late({key, id});
      return;
    }
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1, {kNoChunk, kChunk});
    Bucket& in = buckets_[bucket];
    if (in.filled == kChunk) {
      const std::uint32_t chunk = take_chunk();
      next_chunk_[chunk] = in.chunk;
      in = {chunk, 0};
    }
    entries_of(in.chunk)[in.filled++] = {key, id};
  }

  /// False when empty. `stale(entry)` entries of a bucket are dropped when it opens; `fetch(id)` is called for each
  /// some time before, to prefetch what `stale` reads.
  template <class Stale, class Fetch>
  bool pop(Entry& entry, const Stale& stale, const Fetch& fetch) {
    while (cursor_ == segment_.size() && late_.empty()) {
      if (segments_done_ * kSegment >= open_.size()) {
        if (next_ == buckets_.size()) return false;
        open_.clear();
        collect(buckets_[next_++], stale, fetch);
        tbb::parallel_sort(open_.begin(), open_.end());
        segments_done_ = 0;
        if (pending_.size() * kSegment < open_.size()) pending_.resize(open_.size() / kSegment + 1);
        if (open_.empty()) continue;
      }
      next_segment();
    }
    if (!late_.empty() && (cursor_ == segment_.size() || late_.front() < segment_[cursor_])) {
      std::pop_heap(late_.begin(), late_.end(), std::greater<>());
      entry = late_.back();
      late_.pop_back();
    } else {
      entry = segment_[cursor_++];
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
    if (cursor_ + ahead < segment_.size()) visit(segment_[cursor_ + ahead].id);
  }

 private:
  static constexpr double kMostBuckets = 1 << 20;
  // Buckets are lists of chunks that are used again, so that memory follows what is queued: a vector per bucket has
  // twice its size reserved, and copies.
  static constexpr std::uint32_t kChunk = 16, kChunksAtOnce = 1024, kNoChunk = ~std::uint32_t{0};
  struct Bucket {
    std::uint32_t chunk, filled;  // the newest chunk, which alone may be filled in part
  };
  struct Chunks {
    std::array<Entry, std::size_t{kChunk} * kChunksAtOnce> entries;
  };

  // An open bucket is worked through in segments. What comes in for a later one waits there unsorted: many equal keys
  // make a large bucket, and a heap over half of it would be slow and tell nothing about what comes next.
  static constexpr std::size_t kSegment = 1024;

  void push_late(const Entry& entry) {
    if (segments_done_ * kSegment >= open_.size() || entry < open_[segments_done_ * kSegment]) {
      late_.push_back(entry);
      std::push_heap(late_.begin(), late_.end(), std::greater<>());
      return;
    }
    // The last segment that does not begin after it.
    std::size_t low = segments_done_, high = (open_.size() - 1) / kSegment + 1;
    while (high - low > 1) {
      const std::size_t middle = low + (high - low) / 2;
      (entry < open_[middle * kSegment] ? high : low) = middle;
    }
    pending_[low].push_back(entry);
  }

  void next_segment() {
    const std::size_t begin = segments_done_ * kSegment, end = std::min(begin + kSegment, open_.size());
    std::vector<Entry>& pending = pending_[segments_done_++];
    std::sort(pending.begin(), pending.end());
    segment_.resize(end - begin + pending.size());
    std::merge(open_.begin() + static_cast<std::ptrdiff_t>(begin), open_.begin() + static_cast<std::ptrdiff_t>(end),
               pending.begin(), pending.end(), segment_.begin());
    pending.clear();
    cursor_ = 0;
  }

  Entry* entries_of(std::uint32_t chunk) {
    return chunks_[chunk / kChunksAtOnce]->entries.data() + std::size_t{chunk % kChunksAtOnce} * kChunk;
  }
  std::uint32_t take_chunk() {
    if (free_ == kNoChunk) {
      const auto first = static_cast<std::uint32_t>(next_chunk_.size());
      chunks_.push_back(std::make_unique_for_overwrite<Chunks>());
      next_chunk_.resize(first + kChunksAtOnce);
      for (std::uint32_t c = first; c < first + kChunksAtOnce; ++c) next_chunk_[c] = c + 1;
      next_chunk_.back() = kNoChunk;
      free_ = first;
    }
    const std::uint32_t chunk = free_;
    free_ = next_chunk_[chunk];
    return chunk;
  }

  // What is left of a bucket goes into open_, its chunks back to the free ones.
  template <class Stale, class Fetch>
  void collect(const Bucket& bucket, const Stale& stale, const Fetch& fetch) {
    std::uint32_t filled = bucket.filled;
    if (bucket.chunk != kNoChunk)
      for (std::uint32_t i = 0; i < filled; ++i) fetch(entries_of(bucket.chunk)[i].id);
    for (std::uint32_t chunk = bucket.chunk; chunk != kNoChunk;) {
      const std::uint32_t next = next_chunk_[chunk];
      const Entry* entry = entries_of(chunk);
      if (next != kNoChunk)
        for (std::uint32_t i = 0; i < kChunk; ++i) fetch(entries_of(next)[i].id);
      for (std::uint32_t i = 0; i < filled; ++i)
        if (!stale(entry[i])) open_.push_back(entry[i]);
      next_chunk_[chunk] = free_;
      free_ = chunk;
      chunk = next;
      filled = kChunk;
    }
  }

  double origin_, scale_;
  std::size_t next_ = 0;           // first bucket that is not open yet
  std::size_t segments_done_ = 0;  // segments of the open bucket up to the current one
  std::size_t cursor_ = 0;         // in segment_
  std::vector<Bucket> buckets_;
  std::vector<std::unique_ptr<Chunks>> chunks_;
  std::vector<std::uint32_t> next_chunk_;  // of each chunk, in its bucket or among the free ones
  std::uint32_t free_ = kNoChunk;
  std::vector<Entry> open_;                  // the open bucket, sorted
  std::vector<std::vector<Entry>> pending_;  // per segment of it
  std::vector<Entry> segment_, late_;        // the current segment, and a heap of what came in for it since
};

}  // namespace quench
