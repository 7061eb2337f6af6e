// SPDX-License-Identifier: Apache-2.0
#include "burning/window_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "burn_shapes.h"
#include "burning/blocks.h"
#include "burning/network.h"

namespace quench::burning {
namespace window_queue_test {

// Every block has a colour of its own.
Blocks blocks_of(std::uint32_t states, std::uint32_t count, std::mt19937& random) {
  Blocks blocks;
  blocks.color_end.resize(count);
  std::iota(blocks.color_end.begin(), blocks.color_end.end(), 1u);
  for (std::uint32_t s = 0; s < states; ++s) blocks.of_state.push_back(static_cast<std::uint16_t>(random() % count));
  return blocks;
}

// The caller's side, as label correction uses the queue.
struct Labels {
  struct Label {
    double time = kNever;
    bool queued = false;
  };
  WindowQueue queue;
  std::vector<Label> labels;

  Labels(double origin, double width, const Blocks& blocks)
      : queue(origin, width, blocks), labels(blocks.of_state.size()) {}

  double time_of(std::uint32_t s) const { return labels[s].queued ? labels[s].time : kNever; }
  bool later(std::uint32_t a, std::uint32_t b) const { return std::pair(time_of(a), a) > std::pair(time_of(b), b); }
  void start(std::uint32_t s, double time) {
    queue.push(s, time);
    labels[s] = {time, true};
  }
  void set(WindowQueue::Worker& worker, std::uint32_t s, double time) {
    Label& label = labels[s];
    if (label.queued)
      worker.lower(s, label.time, time);
    else
      worker.push(s, time);
    label = {time, true};
  }
  // Calls visit(worker, state) for every state that is popped.
  template <class Visit>
  void run(const Visit& visit) {
    const auto time_of = [&](std::uint32_t s) { return this->time_of(s); };
    queue.run([&] { return WindowQueue::Worker(queue); }, time_of, [](std::uint32_t) {},
              [&](WindowQueue::Worker& worker) {
                for (std::uint32_t state = 0; worker.pop(state, time_of);) visit(worker, state);
              },
              [](std::uint64_t) {});
  }
};

// States are queued, lowered and popped at random: each is popped once for every time it was queued, as the first of
// its block, and none is lost.
TEST(WindowQueue, PopsTheFirstOfABlock) {
  for (std::uint32_t seed = 0; seed < 300 && !testing::Test::HasFailure(); ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t states = 1 + random() % 200, count = seed % 4 == 0 ? 1 : 1 + random() % 9;
    const Blocks blocks = blocks_of(states, count, random);
    Labels labels(0, std::array{0.01, 0.7, 1000.0}[seed % 3], blocks);
    std::size_t queued = 0, popped = 0;
    for (int start = 0; start < 20; ++start) {
      const std::uint32_t s = random() % states;
      if (labels.labels[s].queued) continue;
      labels.start(s, (random() % 100) * 0.02);
      ++queued;
    }
    labels.run([&](WindowQueue::Worker& worker, std::uint32_t state) {
      EXPECT_TRUE(labels.labels[state].queued) << "seed " << seed;
      for (std::uint32_t s = 0; s < states; ++s)
        if (labels.labels[s].queued && blocks.of_state[s] == blocks.of_state[state]) {
          EXPECT_FALSE(labels.later(state, s)) << "seed " << seed << ": " << s << " before " << state;
        }
      const double now = labels.labels[state].time;
      labels.labels[state].queued = false;
      --queued;
      if (++popped > 2000) return;
      for (int i = 0; i < 2; ++i) {
        const std::uint32_t s = random() % states;
        // As in burning: later than what was popped last, or a little before it where labels are corrected.
        const double time = now + (random() % 100) * 0.02 - (random() % 10 == 0 ? 0.3 : 0);
        if (labels.labels[s].queued && !(time < labels.labels[s].time)) continue;
        queued += !labels.labels[s].queued;
        labels.set(worker, s, time);
      }
    });
    EXPECT_EQ(queued, 0u) << "seed " << seed;
    EXPECT_GT(popped, 2000u) << "seed " << seed;
  }
}

// Within a window a block pops all of its states before the next one; the next window comes when no block has any.
TEST(WindowQueue, BlocksFollowEachOtherInAWindow) {
  Blocks blocks;
  blocks.color_end = {1, 2, 3};
  blocks.of_state = {0, 1, 2, 0, 1, 2};
  Labels labels(0, 10, blocks);
  for (std::uint32_t s = 0; s < 6; ++s) labels.start(s, 9 - s);  // all in the first window
  std::vector<std::uint32_t> order;
  labels.run([&](WindowQueue::Worker& worker, std::uint32_t state) {
    labels.labels[state].queued = false;
    order.push_back(state);
    if (order.size() == 3) {       // block 1 is active
      labels.set(worker, 1, 3);    // lowered, of the active block
      labels.set(worker, 2, 2);    // lowered, of a later block
      labels.set(worker, 0, 9.5);  // queued again, of an earlier block
      labels.set(worker, 3, 12);   // in the next window
    }
  });
  EXPECT_EQ(order, (std::vector<std::uint32_t>{3, 0, 4, 1, 2, 5, 0, 3}));
}

TEST(Blocks, AreOfTheirSizeAndOfStatesThatLieTogether) {
  testing_complexes::Random random(1);
  testing_complexes::Builder b;
  testing_complexes::jittered_sheet(b, Vec3(-3, 7, 1), Vec3(80, 0, 5), Vec3(0, 60, 0), 80, 60, random);
  testing_complexes::BurnInput input = b.input([](const Vec3&) { return 1.0; });
  const BurnNetwork network = make_network(input.complex, input.points, 0.4);
  const Blocks blocks = make_blocks(input.complex, input.points, network, 600);
  ASSERT_EQ(blocks.of_state.size(), network.state_count());
  std::vector<std::size_t> states(blocks.count(), 0);
  for (const std::uint16_t block : blocks.of_state) {
    ASSERT_LT(block, blocks.count());
    ++states[block];
  }
  EXPECT_EQ(blocks.count(), (network.state_count() - 1) / 600 + 1);
  const auto is_full = [](std::size_t n) { return 540 <= n && n <= 660; };
  EXPECT_GE(std::count_if(states.begin(), states.end(), is_full),
            std::ssize(states) - 1);  // all but the last along the curve
  std::vector<Vec3> low(blocks.count(), Vec3::Constant(kNever)), high(blocks.count(), Vec3::Constant(-kNever));
  for (std::uint32_t v = 0; v < input.points.size(); ++v) {
    const std::uint16_t block = blocks.of_state[network.vertex_base[v]];
    low[block] = low[block].cwiseMin(input.points[v]);
    high[block] = high[block].cwiseMax(input.points[v]);
  }
  double extent = 0;
  for (std::size_t i = 0; i < blocks.count(); ++i) extent += (high[i] - low[i]).norm() / blocks.count();
  EXPECT_LT(extent, 25);  // of a sheet of 100 units, divided into about 80
  for (std::uint32_t e = 0; e < input.complex.edges.size(); ++e)
    for (std::uint32_t s = network.state_base[e]; s < network.state_base[e + 1]; ++s)
      ASSERT_EQ(blocks.of_state[s], blocks.of_state[network.vertex_base[input.complex.edges[e][0]]]);

  // Polygons at a vertex are of blocks of different colours.
  const auto color_of = [&](std::uint32_t v) {
    return std::upper_bound(blocks.color_end.begin(), blocks.color_end.end(), blocks.of_state[network.vertex_base[v]]) -
           blocks.color_end.begin();
  };
  EXPECT_LT(blocks.color_end.size(), 20u);
  std::vector<std::vector<std::uint32_t>> around(input.points.size());  // vertices of the polygons at a vertex
  for (std::uint32_t f = 0; f < input.complex.face_count(); ++f)
    for (const std::uint32_t v : input.complex.corners(f))
      for (const std::uint32_t w : input.complex.corners(f)) around[v].push_back(w);
  for (const auto& vertices : around)
    for (const std::uint32_t v : vertices)
      for (const std::uint32_t w : vertices)
        if (blocks.of_state[network.vertex_base[v]] != blocks.of_state[network.vertex_base[w]]) {
          ASSERT_NE(color_of(v), color_of(w));
        }

  const Blocks one = make_blocks(input.complex, input.points, network, 1u << 30);
  EXPECT_EQ(one.count(), 1u);
}

// More blocks than can be numbered are not made; points that coincide are of one.
TEST(Blocks, ManyAndOne) {
  testing_complexes::Random random(1);
  testing_complexes::Builder b;
  testing_complexes::jittered_sheet(b, Vec3(0, 0, 0), Vec3(60, 0, 0), Vec3(0, 60, 0), 60, 60, random);
  testing_complexes::BurnInput input = b.input([](const Vec3&) { return 1.0; });
  const BurnNetwork network = make_network(input.complex, input.points, 0.03);
  ASSERT_GT(network.state_count(), 1u << 16);
  const Blocks many = make_blocks(input.complex, input.points, network, 1);
  EXPECT_LE(many.count(), 1u << 16);
  EXPECT_GT(many.count(), 1u << 14);
  for (const std::uint16_t block : many.of_state) ASSERT_LT(block, many.count());
  for (Vec3& p : input.points) p = Vec3(1, 2, 3);
  const Blocks same = make_blocks(input.complex, input.points, network, 100);
  for (const std::uint16_t block : same.of_state) ASSERT_EQ(block, 0);
}

}  // namespace window_queue_test
}  // namespace quench::burning
