// SPDX-License-Identifier: Apache-2.0
#include "base/sorted_by_key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <span>

namespace quench {
namespace sorted_by_key_test {

constexpr std::ptrdiff_t kMostTies = 100;

// Keys of a few values (of which some occur more often than kMostTies), of many, and infinite ones.
std::vector<double> keys(std::size_t count, std::mt19937& random) {
  std::vector<double> result(count);
  for (double& key : result) {
    const auto kind = random() % 4;
    if (kind == 0) key = std::numeric_limits<double>::infinity();
    if (kind == 1) key = 0.25 * static_cast<double>(random() % 3);
    if (kind > 1) key = std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 40) - 60);
  }
  return result;
}

TEST(SortedByKey, AsAComparisonSort) {
  std::mt19937 random(3);
  for (const std::size_t count : {0u, 1u, 50u, 5000u, 200000u}) {  // the last in several chunks
    const std::vector<double> key = keys(count, random);
    std::vector<std::uint32_t> second(count);
    for (std::uint32_t& s : second) s = random() % 5;
    const auto sorted = base::sorted_by_key_descending(
        count, kMostTies, [&](std::size_t i) { return key[i]; },
        [&](std::uint32_t a, std::uint32_t b) { return second[a] > second[b]; });

    std::vector<std::uint32_t> wanted(count);
    std::iota(wanted.begin(), wanted.end(), 0u);
    std::ranges::stable_sort(wanted, [&](std::uint32_t a, std::uint32_t b) { return key[a] > key[b]; });
    ASSERT_EQ(sorted.size(), count);
    for (std::size_t first = 0, last = 0; first < count; first = last) {
      while (last < count && key[wanted[last]] == key[wanted[first]]) ++last;
      const std::span<std::uint32_t> same(wanted.data() + first, last - first);
      const auto is_sorted = [&] {
        return std::equal(same.begin(), same.end(), sorted.begin() + static_cast<std::ptrdiff_t>(first));
      };
      // More than kMostTies are left in the order of indices, unless another key shares their bucket.
      if (static_cast<std::ptrdiff_t>(same.size()) > kMostTies && is_sorted()) continue;
      std::ranges::stable_sort(same, [&](std::uint32_t a, std::uint32_t b) { return second[a] > second[b]; });
      EXPECT_TRUE(is_sorted());
    }
  }
}

}  // namespace sorted_by_key_test
}  // namespace quench
