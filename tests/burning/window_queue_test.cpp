// SPDX-License-Identifier: Apache-2.0
#include "burning/window_queue.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <utility>

#include "burn_shapes.h"
#include "burning/blocks.h"
#include "burning/network.h"

namespace quench::burning {
namespace {

Blocks blocks_of(std::uint32_t states, std::uint32_t count, std::mt19937& random) {
  Blocks blocks;
  blocks.count = count;
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
  void set(std::uint32_t s, double time) {
    Label& label = labels[s];
    if (label.queued)
      queue.lower(s, label.time, time);
    else
      queue.push(s, time);
    label = {time, true};
  }
  bool pop(std::uint32_t& state) {
    return queue.pop(
        state, [&](std::uint32_t s) { return time_of(s); }, [](std::uint32_t) {});
  }
};

// States are queued, lowered and popped at random: each is popped once for every time it was queued, as the first of
// its block, and none is lost.
TEST(WindowQueue, PopsTheFirstOfABlock) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t states = 1 + random() % 200, count = seed % 4 == 0 ? 1 : 1 + random() % 9;
    const Blocks blocks = blocks_of(states, count, random);
    Labels labels(0, std::array{0.01, 0.7, 1000.0}[seed % 3], blocks);
    std::size_t queued = 0;
    double now = 0;
    const auto pop = [&] {
      std::uint32_t state = 0;
      if (!labels.pop(state)) {
        ASSERT_EQ(queued, 0u) << "seed " << seed;
        return;
      }
      ASSERT_TRUE(labels.labels[state].queued) << "seed " << seed;
      for (std::uint32_t s = 0; s < states; ++s)
        if (labels.labels[s].queued && blocks.of_state[s] == blocks.of_state[state]) {
          ASSERT_FALSE(labels.later(state, s)) << "seed " << seed << ": " << s << " before " << state;
        }
      now = labels.labels[state].time;
      labels.labels[state].queued = false;
      --queued;
    };
    for (int step = 0; step < 5000; ++step) {
      if (random() % 3 == 0) {
        ASSERT_NO_FATAL_FAILURE(pop());
        continue;
      }
      const std::uint32_t s = random() % states;
      // As in burning: later than what was popped last, or a little before it where labels are corrected.
      const double time = now + (random() % 100) * 0.02 - (random() % 10 == 0 ? 0.3 : 0);
      if (labels.labels[s].queued && !(time < labels.labels[s].time)) continue;
      queued += !labels.labels[s].queued;
      labels.set(s, time);
    }
    while (queued > 0) ASSERT_NO_FATAL_FAILURE(pop());
    ASSERT_NO_FATAL_FAILURE(pop());
  }
}

// Within a window a block pops all of its states before the next one; the next window comes when no block has any.
TEST(WindowQueue, BlocksFollowEachOtherInAWindow) {
  Blocks blocks;
  blocks.count = 3;
  blocks.of_state = {0, 1, 2, 0, 1, 2};
  Labels labels(0, 10, blocks);
  for (std::uint32_t s = 0; s < 6; ++s) labels.set(s, 9 - s);  // all in the first window
  std::vector<std::uint32_t> order;
  for (std::uint32_t state = 0; labels.pop(state);) {
    labels.labels[state].queued = false;
    order.push_back(state);
    if (order.size() == 3) {  // block 1 is active
      labels.set(1, 3);       // lowered, of the active block
      labels.set(2, 2);       // lowered, of a later block
      labels.set(0, 9.5);     // queued again, of an earlier block
      labels.set(3, 12);      // in the next window
    }
  }
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
  std::vector<std::size_t> states(blocks.count, 0);
  for (const std::uint16_t block : blocks.of_state) {
    ASSERT_LT(block, blocks.count);
    ++states[block];
  }
  EXPECT_EQ(blocks.count, (network.state_count() - 1) / 600 + 1);
  for (std::size_t i = 0; i + 1 < states.size(); ++i) EXPECT_NEAR(static_cast<double>(states[i]), 600, 60) << i;
  std::vector<Vec3> low(blocks.count, Vec3::Constant(kNever)), high(blocks.count, Vec3::Constant(-kNever));
  for (std::uint32_t v = 0; v < input.points.size(); ++v) {
    const std::uint16_t block = blocks.of_state[network.vertex_base[v]];
    low[block] = low[block].cwiseMin(input.points[v]);
    high[block] = high[block].cwiseMax(input.points[v]);
  }
  double extent = 0;
  for (std::size_t i = 0; i < blocks.count; ++i) extent += (high[i] - low[i]).norm() / blocks.count;
  EXPECT_LT(extent, 25);  // of a sheet of 100 units, divided into about 80
  for (std::uint32_t e = 0; e < input.complex.edges.size(); ++e)
    for (std::uint32_t s = network.state_base[e]; s < network.state_base[e + 1]; ++s)
      ASSERT_EQ(blocks.of_state[s], blocks.of_state[network.vertex_base[input.complex.edges[e][0]]]);

  const Blocks one = make_blocks(input.complex, input.points, network, 1u << 30);
  EXPECT_EQ(one.count, 1u);
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
  EXPECT_LE(many.count, 1u << 16);
  EXPECT_GT(many.count, 1u << 14);
  for (const std::uint16_t block : many.of_state) ASSERT_LT(block, many.count);
  for (Vec3& p : input.points) p = Vec3(1, 2, 3);
  const Blocks same = make_blocks(input.complex, input.points, network, 100);
  for (const std::uint16_t block : same.of_state) ASSERT_EQ(block, 0);
}

}  // namespace
}  // namespace quench::burning
