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
      late_.push_back({key, id});
      std::push_heap(late_.begin(), late_.end(), std::greater<>());
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
    while (cursor_ == open_.size() && late_.empty()) {
      if (next_ == buckets_.size()) return false;
      open_.clear();
      collect(buckets_[next_++], stale, fetch);
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
  // Buckets are lists of chunks that are used again, so that memory follows what is queued: a vector per bucket has
  // twice its size reserved, and copies.
  static constexpr std::uint32_t kChunk = 16, kChunksAtOnce = 1024, kNoChunk = ~std::uint32_t{0};
  struct Bucket {
    std::uint32_t chunk, filled;  // the newest chunk, which alone may be filled in part
  };
  struct Chunks {
    std::array<Entry, std::size_t{kChunk} * kChunksAtOnce> entries;
  };

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
  std::size_t next_ = 0;    // first bucket that is not open yet
  std::size_t cursor_ = 0;  // in open_
  std::vector<Bucket> buckets_;
  std::vector<std::unique_ptr<Chunks>> chunks_;
  std::vector<std::uint32_t> next_chunk_;  // of each chunk, in its bucket or among the free ones
  std::uint32_t free_ = kNoChunk;
  std::vector<Entry> open_, late_;
};

}  // namespace quench
