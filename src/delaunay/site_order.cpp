// SPDX-License-Identifier: Apache-2.0
#include "delaunay/site_order.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "base/parallel.h"
#include "delaunay/bounds.h"

namespace quench::delaunay {
namespace {

constexpr int kHilbertBits = 20;  // of a coordinate: 3 * 20 bits of a key, and 4 for the round above them

// Skilling 2004: transforms coordinates to the transposed Hilbert index, then interleaves its bits.
// `bits` per axis, 1 to kHilbertBits.
std::uint64_t hilbert_key(std::array<std::uint32_t, 3> x, int bits) {
  for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1) {
    const std::uint32_t p = q - 1;
    for (int i = 0; i < 3; ++i) {
      if (x[i] & q) {
        x[0] ^= p;
      } else {
        const std::uint32_t t = (x[0] ^ x[i]) & p;
        x[0] ^= t;
        x[i] ^= t;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t t = 0;
  for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1)
    if (x[2] & q) t ^= q - 1;
  for (auto& v : x) v ^= t;
  std::uint64_t key = 0;
  for (int b = bits - 1; b >= 0; --b)
    for (int i = 0; i < 3; ++i) key = key << 1 | (x[i] >> b & 1);
  return key;
}

std::uint64_t hash(std::uint64_t x) {  // splitmix64 finaliser
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ x >> 27) * 0x94D049BB133111EBull;
  return x ^ x >> 31;
}

}  // namespace

std::vector<std::uint32_t> insertion_order(std::span<const LatticePoint> sites) {
  struct Entry {
    std::uint64_t key;
    std::uint32_t index;
    bool operator<(const Entry& other) const { return key != other.key ? key < other.key : index < other.index; }
  };
  if (sites.empty()) return {};
  const auto [low, high] = bounds_of(sites);
  std::uint32_t largest = 1;  // at least one bit per axis
  for (std::size_t a = 0; a < 3; ++a) largest = std::max(largest, static_cast<std::uint32_t>(high[a] - low[a]));
  // Lattice points go from 0 to 2^20, one bit too many: on the longest of grids neighbours share a key.
  const int shift = std::max(0, static_cast<int>(std::bit_width(largest)) - kHilbertBits);
  const int bits = static_cast<int>(std::bit_width(largest)) - shift;
  // A site enters in the last round with probability 1/2, in the one before with 1/4, ...; the first has some 1000
  // sites.
  const int rounds = std::clamp(static_cast<int>(std::bit_width(sites.size())) - 10, 0, 15);
  std::vector<Entry> entries(sites.size());
  base::for_indices(sites.size(), [&, &low = low](std::size_t i) {
    const int before_last = std::min(std::countr_zero(hash(i) | 1ull << 60), rounds);
    const std::array<std::uint32_t, 3> x{static_cast<std::uint32_t>(sites[i][0] - low[0]) >> shift,
                                         static_cast<std::uint32_t>(sites[i][1] - low[1]) >> shift,
                                         static_cast<std::uint32_t>(sites[i][2] - low[2]) >> shift};
    entries[i] = {static_cast<std::uint64_t>(rounds - before_last) << 3 * kHilbertBits | hilbert_key(x, bits),
                  static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(entries.begin(), entries.end());
  std::vector<std::uint32_t> order(sites.size());
  base::for_indices(sites.size(), [&](std::size_t i) { order[i] = entries[i].index; });
  return order;
}

}  // namespace quench::delaunay
