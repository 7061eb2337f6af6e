// SPDX-License-Identifier: Apache-2.0
#include "base/graph_peeler.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace quench::base {
namespace graph_peeler_test {

using Edges = std::vector<std::array<std::uint32_t, 2>>;

// Looks at all vertices again after each removal.
std::vector<char> naively_peeled(std::uint32_t vertices, const Edges& edges, const std::vector<char>& kept_vertex,
                                 const std::vector<char>& kept_edge) {
  std::vector<char> left(edges.size(), 1);
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::vector<std::uint32_t>> at(vertices);
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      for (const std::uint32_t v : edges[e])
        if (left[e]) at[v].push_back(e);
    for (std::uint32_t v = 0; v < vertices && !changed; ++v)
      if (at[v].size() == 1 && !kept_vertex[v] && !kept_edge[at[v][0]]) {
        left[at[v][0]] = 0;
        changed = true;
      }
  }
  return left;
}

// Loops, parallel edges, vertices and edges that must stay.
TEST(GraphPeeler, RemovesWhatRepeatedSearchRemoves) {
  std::size_t peeled = 0;
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t vertices = 1 + random() % 20;
    Edges edges(random() % 25);
    for (auto& e : edges)
      e = {static_cast<std::uint32_t>(random() % vertices), static_cast<std::uint32_t>(random() % vertices)};
    std::vector<char> kept_vertex(vertices), kept_edge(edges.size());
    for (char& kept : kept_vertex) kept = random() % 8 == 0;
    for (char& kept : kept_edge) kept = random() % 12 == 0;

    GraphPeeler peeler(vertices);
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      for (const std::uint32_t v : edges[e]) peeler.add(v, e);
    std::vector<char> left(edges.size(), 1);
    peeler.peel(
        [&](std::uint32_t e) -> const auto& { return edges[e]; },
        [&](std::uint32_t v, std::uint32_t e) { return !kept_vertex[v] && !kept_edge[e]; },
        [&](std::uint32_t v, std::uint32_t e) {
          EXPECT_TRUE(left[e]) << "seed " << seed;
          EXPECT_TRUE(edges[e][0] == v || edges[e][1] == v) << "seed " << seed;
          left[e] = 0;
          ++peeled;
        });
    ASSERT_EQ(left, naively_peeled(vertices, edges, kept_vertex, kept_edge)) << "seed " << seed;
    for (std::uint32_t v = 0; v < vertices; ++v) {
      std::size_t degree = 0;
      for (std::uint32_t e = 0; e < edges.size(); ++e)
        for (const std::uint32_t end : edges[e]) degree += left[e] && end == v;
      ASSERT_EQ(peeler.edges_at(v).none(), degree == 0) << "seed " << seed;
      ASSERT_EQ(peeler.edges_at(v).single(), degree == 1) << "seed " << seed;
    }
  }
  EXPECT_GT(peeled, 5000u);
}

// A cycle with a tail: nothing is free but the tail; without one of its edges the cycle is a path.
TEST(GraphPeeler, RemovingAnEdgeOpensItsCycle) {
  const Edges edges{{0, 1}, {1, 2}, {2, 0}, {2, 3}};
  GraphPeeler peeler(4);
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) peeler.add(v, e);
  const auto ends_of = [&](std::uint32_t e) -> const auto& { return edges[e]; };
  const auto any = [](std::uint32_t, std::uint32_t) { return true; };
  std::vector<std::uint32_t> removed;
  const auto note = [&](std::uint32_t, std::uint32_t e) { removed.push_back(e); };
  peeler.peel(ends_of, any, note);
  EXPECT_EQ(removed, std::vector<std::uint32_t>{3});
  removed.clear();
  peeler.remove(0, ends_of, any, note);
  EXPECT_EQ(removed, (std::vector<std::uint32_t>{1, 2}));
}

}  // namespace graph_peeler_test
}  // namespace quench::base
