// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_forest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "base/union_find.h"

namespace quench::tree {
namespace repair_forest_test {

struct Case {
  std::uint32_t vertices;
  std::vector<ForestEdge> edges;
  std::vector<std::uint32_t> marked;
};

// Number of edges and gain of a set of edges; nothing where it has a cycle or two marked vertices in one tree.
std::optional<std::pair<int, double>> value_of(const Case& c, std::uint32_t set) {
  base::UnionFind trees(c.vertices);
  std::pair<int, double> value{0, 0};
  for (std::size_t e = 0; e < c.edges.size(); ++e) {
    if (!(set >> e & 1u)) continue;
    if (!trees.unite(c.edges[e].a, c.edges[e].b)) return {};
    ++value.first;
    value.second += c.edges[e].gain;
  }
  for (std::size_t i = 0; i < c.marked.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (trees.find(c.marked[i]) == trees.find(c.marked[k])) return {};
  return value;
}

TEST(SpanningForest, IsTheBestOfAllSubsets) {
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int repeat = 0; repeat < 3000; ++repeat) {
    Case c;
    c.vertices = 2 + below(6);
    const std::uint32_t count = below(11);
    for (std::uint32_t e = 0; e < count; ++e)
      c.edges.push_back({below(c.vertices), below(c.vertices), static_cast<double>(below(9)) - 4});  // many ties
    for (std::uint32_t v = 0; v < c.vertices; ++v)
      if (repeat % 3 != 0 && below(3) == 0) c.marked.push_back(v);
    std::pair<int, double> best{0, 0};
    for (std::uint32_t set = 0; set < 1u << c.edges.size(); ++set)
      if (const auto value = value_of(c, set)) best = std::max(best, *value);
    const std::vector<std::uint8_t> kept = spanning_forest(c.vertices, c.edges, c.marked, {});
    std::uint32_t set = 0;
    for (std::size_t e = 0; e < kept.size(); ++e) set |= static_cast<std::uint32_t>(kept[e]) << e;
    const auto value = value_of(c, set);
    ASSERT_TRUE(value.has_value()) << repeat;
    ASSERT_EQ(*value, best) << repeat;
  }
}

TEST(SpanningForest, BridgesMustPay) {
  const std::vector<ForestEdge> edges{{0, 1, -3}, {1, 2, -1}};
  const std::vector<double> worth{10, 2, 0.5};
  // The second one is looked at first: what hangs on it is worth less than it costs, and so is then the first.
  EXPECT_EQ(spanning_forest(3, edges, {}, worth), (std::vector<std::uint8_t>{0, 0}));
  const std::vector<double> more{10, 2, 1.5};
  EXPECT_EQ(spanning_forest(3, edges, {}, more), (std::vector<std::uint8_t>{1, 1}));
  // What must be there needs no worth of its own.
  const std::vector<std::uint32_t> marked{2};
  EXPECT_EQ(spanning_forest(3, edges, marked, worth), (std::vector<std::uint8_t>{1, 1}));
}

TEST(SpanningForest, TiesGoToTheFirst) {
  const std::vector<ForestEdge> edges{{0, 1, 1}, {1, 2, 1}, {2, 0, 1}};
  EXPECT_EQ(spanning_forest(3, edges, {}, {}), (std::vector<std::uint8_t>{1, 1, 0}));
}

}  // namespace repair_forest_test
}  // namespace quench::tree
