// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.h"

namespace quench::base {

/// The indices 0 .. count - 1 by descending key (0 or more, infinite allowed); equal keys by before(a, b), then by
/// index; more than `most_ties` of one key may be left in the order of indices. Made for keys of which many are equal:
/// counting by their leading bits does most of the sorting. On the threads of the arena; the result does not depend on
/// their number.
template <class Key, class Before>
std::vector<std::uint32_t> sorted_by_key_descending(std::size_t count, std::ptrdiff_t most_ties, const Key& key,
                                                    const Before& before) {
  const std::size_t chunks = chunks_for(count);
  const auto for_all = [&](const auto& body) {
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = part_of(count, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) body(chunk, i);
    });
  };
  // Numbers that are not negative have the order of their bits.
  const auto bits_of = [&](std::size_t i) { return std::bit_cast<std::uint64_t>(key(i) + 0.0); };
  struct Range {
    std::uint64_t low = ~std::uint64_t{0}, high = 0;
  };
  std::vector<Range> ranges(chunks);
  for_all([&](std::size_t chunk, std::size_t i) {
    if (key(i) == std::numeric_limits<double>::infinity()) return;
    ranges[chunk].low = std::min(ranges[chunk].low, bits_of(i));
    ranges[chunk].high = std::max(ranges[chunk].high, bits_of(i));
  });
  Range range;
  for (const Range& r : ranges) range = {std::min(range.low, r.low), std::max(range.high, r.high)};
  constexpr std::uint64_t kBuckets = std::uint64_t{1} << 14;
  int shift = 0;
  while (range.high >= range.low && (range.high - range.low) >> shift >= kBuckets - 1) ++shift;
  const auto bucket_of = [&](std::size_t i) {  // infinity is bucket 0
    return std::min(((range.high - bits_of(i)) >> shift) + 1, kBuckets) % kBuckets;
  };

  std::vector<std::uint32_t> place(chunks * kBuckets, 0), begin, order(count);
  for_all([&](std::size_t chunk, std::size_t i) { ++place[chunk * kBuckets + bucket_of(i)]; });
  std::uint32_t sum = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    begin.push_back(sum);
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) sum += std::exchange(place[chunk * kBuckets + bucket], sum);
  }
  begin.push_back(sum);
  for_all([&](std::size_t chunk, std::size_t i) {
    order[place[chunk * kBuckets + bucket_of(i)]++] = static_cast<std::uint32_t>(i);
  });
  tbb::parallel_for(std::size_t{0}, std::size_t{kBuckets}, [&](std::size_t bucket) {
    const auto first = order.begin() + begin[bucket], last = order.begin() + begin[bucket + 1];
    const auto same = [&](std::uint32_t i) { return key(i) == key(*first); };
    if (last - first > most_ties && std::all_of(first, last, same)) return;
    std::sort(first, last, [&](std::uint32_t a, std::uint32_t b) {
      if (key(a) != key(b)) return key(a) > key(b);
      return before(a, b) || (!before(b, a) && a < b);
    });
  });
  return order;
}

}  // namespace quench::base
