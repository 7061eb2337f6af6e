// SPDX-License-Identifier: Apache-2.0
#include "base/bucket_queue.h"

#include <gtest/gtest.h>

#include <queue>
#include <random>

namespace quench {
namespace bucket_queue_test {

using Queue = base::BucketQueue<std::uint32_t>;

// Pushes and pops at random beside a heap. Few keys, so that buckets hold thousands of equal ones while
// more come in.
TEST(BucketQueue, PopsLikeAHeap) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t kinds = seed % 4 == 0 ? 1u : seed % 4 == 1 ? 5u : 4000u;
    Queue queue(0, seed % 2 ? 0.5 : 0.001);
    std::priority_queue<Queue::Entry, std::vector<Queue::Entry>, std::greater<>> heap;
    std::uint32_t id = 0;
    const auto push = [&](double key) {
      const std::uint32_t name = random() % 50000 * 64 + id++ % 64;
      queue.push(key, name);
      heap.push({key, name});
    };
    const auto pop = [&] {
      Queue::Entry entry{};
      ASSERT_TRUE(queue.pop(entry, [](const Queue::Entry&) { return false; }));
      ASSERT_EQ(entry.key, heap.top().key);
      ASSERT_EQ(entry.id, heap.top().id);
      heap.pop();
    };
    for (int i = 0; i < 20000; ++i) push(random() % kinds * 0.01);
    for (int i = 0; i < 30000 && !heap.empty(); ++i) {
      const double now = heap.top().key;
      ASSERT_NO_FATAL_FAILURE(pop());
      if (random() % 3 == 0) push(now + random() % 3 * 0.01);
      if (random() % 50 == 0) push(now / 2);
    }
    while (!heap.empty()) ASSERT_NO_FATAL_FAILURE(pop());
    Queue::Entry entry{};
    ASSERT_FALSE(queue.pop(entry, [](const Queue::Entry&) { return false; }));
  }
}

TEST(BucketQueue, StaleEntriesAreDroppedWhenABucketOpens) {
  Queue queue(0, 1);
  for (std::uint32_t i = 0; i < 5000; ++i) queue.push(i % 10, i);
  std::size_t popped = 0, fetched = 0;
  const auto odd = [](const Queue::Entry& entry) { return entry.id % 2 == 1; };
  for (Queue::Entry entry{}; queue.pop(entry, odd, [&](std::uint32_t) { ++fetched; }); ++popped)
    ASSERT_EQ(entry.id % 2, 0u);
  EXPECT_EQ(popped, 2500u);
  EXPECT_EQ(fetched, 5000u);
}

}  // namespace bucket_queue_test
}  // namespace quench
