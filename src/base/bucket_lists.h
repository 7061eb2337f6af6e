// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace quench::base {

/// Numbered buckets into which entries are put one by one and from which they are taken all at once: lists of chunks
/// that are reused, so that memory is proportional to the entries held. (A vector per bucket would reserve twice its
/// size, and copy.)
template <class Entry>
class BucketLists {
 public:
  std::size_t size() const { return buckets_.size(); }  ///< one more than the largest bucket ever put into
  bool is_empty(std::size_t bucket) const { return bucket >= size() || buckets_[bucket].chunk == kNoChunk; }

  void put(std::size_t bucket, const Entry& entry) {
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1, {kNoChunk, kChunk});
    Bucket& in = buckets_[bucket];
    if (in.filled == kChunk) {
      const std::uint32_t chunk = take_chunk();
      next_chunk_[chunk] = in.chunk;
      in = {chunk, 0};
    }
    entries_of(in.chunk)[in.filled++] = entry;
  }

  /// Empties a bucket: calls visit(entry) for each of its entries, and fetch(entry) some time before, to prefetch what
  /// `visit` reads. `visit` may put entries into these lists.
  template <class Fetch, class Visit>
  void take(std::size_t bucket, const Fetch& fetch, const Visit& visit) {
    if (is_empty(bucket)) return;
    const Bucket from = buckets_[bucket];
    buckets_[bucket] = {kNoChunk, kChunk};
    std::uint32_t filled = from.filled;
    for (std::uint32_t i = 0; i < filled; ++i) fetch(entries_of(from.chunk)[i]);
    for (std::uint32_t chunk = from.chunk; chunk != kNoChunk;) {
      const std::uint32_t next = next_chunk_[chunk];
      const Entry* entry = entries_of(chunk);
      if (next != kNoChunk)
        for (std::uint32_t i = 0; i < kChunk; ++i) fetch(entries_of(next)[i]);
      for (std::uint32_t i = 0; i < filled; ++i) visit(entry[i]);
      next_chunk_[chunk] = free_;
      free_ = chunk;
      chunk = next;
      filled = kChunk;
    }
  }

 private:
  static constexpr std::uint32_t kChunk = 16, kChunksAtOnce = 1024, kNoChunk = ~std::uint32_t{0};
  struct Bucket {
    std::uint32_t chunk, filled;  // the newest chunk and its number of entries; all older chunks are full
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

  std::vector<Bucket> buckets_;
  std::vector<std::unique_ptr<Chunks>> chunks_;
  std::vector<std::uint32_t>
      next_chunk_;  // next_chunk_[c]: the chunk after c in its bucket or in the list of free ones
  std::uint32_t free_ = kNoChunk;
};

}  // namespace quench::base
