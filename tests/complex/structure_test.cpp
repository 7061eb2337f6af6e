// SPDX-License-Identifier: Apache-2.0
#include "quench/structure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "random_complexes.h"

namespace quench {
namespace structure_test {

// Three triangles around an edge, with a fourth beside one of them.
TEST(Structure, OfTrianglesAroundAnEdge) {
  // 0 and 1 are the ends of the edge.
  const std::vector<std::array<std::uint32_t, 2>> edges{{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3},
                                                        {0, 4}, {1, 4}, {4, 5}, {1, 5}, {5, 6}};
  const CellComplex c = make_complex(7, edges, {0, 3, 6, 9, 12}, {0, 1, 2, 0, 1, 3, 0, 1, 4, 1, 4, 5});
  const Structure s = structure_of(c);
  EXPECT_EQ(s.sheets, 3u);
  EXPECT_EQ(s.face_sheet, (std::vector<std::int32_t>{0, 1, 2, 2}));
  EXPECT_EQ(s.seams, 1u);
  EXPECT_EQ(std::count(s.edge_seam.begin(), s.edge_seam.end(), 0), 1);
  EXPECT_EQ(s.vertex_seam, std::vector<std::int32_t>(7, -1));  // the seam has no vertex inside
  EXPECT_EQ(s.junction, (std::vector<char>{1, 1, 0, 0, 0, 0, 0}));
}

// Three fans of triangles around a path of two edges, 0 - 1 - 2.
TEST(Structure, OfASeamOfTwoEdges) {
  std::vector<std::array<std::uint32_t, 2>> edges{{0, 1}, {1, 2}};
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const std::uint32_t tip : {3u, 4u, 5u}) {
    for (const std::uint32_t v : {0u, 1u, 2u}) edges.push_back({v, tip});
    for (const std::uint32_t v : {0u, 1u}) {
      corners.insert(corners.end(), {v, v + 1, tip});
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    }
  }
  const Structure s = structure_of(make_complex(6, edges, offsets, corners));
  EXPECT_EQ(s.sheets, 3u);
  EXPECT_EQ(s.seams, 1u);
  EXPECT_EQ(s.vertex_seam, (std::vector<std::int32_t>{-1, 0, -1, -1, -1, -1}));
  EXPECT_EQ(s.junction, (std::vector<char>{1, 0, 1, 0, 0, 0}));
}

TEST(Structure, OfNothing) {
  const Structure s = structure_of(CellComplex{});
  EXPECT_EQ(s.sheets, 0u);
  EXPECT_EQ(s.seams, 0u);
}

// Two faces are of one sheet exactly when one is reached from the other over edges of two faces, and seams the same one
// dimension down.
TEST(Structure, IsThatOfWalking) {
  std::size_t seams = 0;
  for (std::uint64_t seed = 0; seed < 1000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const CellComplex c = testing_complexes::random_input(seed).complex;
    const Structure s = structure_of(c);
    std::map<std::uint32_t, std::set<std::uint32_t>> faces_at, seams_at;
    for (std::uint32_t f = 0; f < c.face_count(); ++f)
      for (const std::uint32_t e : c.sides(f)) faces_at[e].insert(f);
    for (std::uint32_t e = 0; e < c.edges.size(); ++e) {
      ASSERT_EQ(s.edge_seam[e] >= 0, faces_at[e].size() > 2);
      if (faces_at[e].size() > 2)
        for (const std::uint32_t v : c.edges[e]) seams_at[v].insert(e);
    }
    // Repeats until nothing changes: every element has the least number that reaches it.
    const auto least = [](std::size_t count, const auto& places) {
      std::vector<std::uint32_t> number(count);
      for (std::uint32_t i = 0; i < count; ++i) number[i] = i;
      for (bool changed = true; changed;) {
        changed = false;
        for (const auto& [place, at] : places) {
          if (at.size() != 2) continue;
          const std::uint32_t low = std::min(number[*at.begin()], number[*at.rbegin()]);
          for (const std::uint32_t i : at) {
            changed |= number[i] != low;
            number[i] = low;
          }
        }
      }
      return number;
    };
    const auto same_sets = [](const std::vector<std::uint32_t>& expected, const std::vector<std::int32_t>& numbers) {
      std::map<std::uint32_t, std::int32_t> known;
      std::int32_t next = 0;
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (numbers[i] < 0) continue;
        const auto [at, is_new] = known.emplace(expected[i], next);
        next += is_new;
        if (at->second != numbers[i]) return false;
      }
      return true;
    };
    EXPECT_TRUE(same_sets(least(c.face_count(), faces_at), s.face_sheet));
    EXPECT_TRUE(same_sets(least(c.edges.size(), seams_at), s.edge_seam));
    for (std::uint32_t v = 0; v < c.vertex_count; ++v) {
      ASSERT_EQ(s.junction[v] != 0, seams_at.contains(v) && seams_at[v].size() != 2);
      ASSERT_EQ(s.vertex_seam[v],
                seams_at.contains(v) && seams_at[v].size() == 2 ? s.edge_seam[*seams_at[v].begin()] : -1);
    }
    seams += s.seams;
  }
  EXPECT_GT(seams, 500u);
}

}  // namespace structure_test
}  // namespace quench
