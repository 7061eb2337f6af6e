// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "quench/error.h"
#include "quench/shape.h"

namespace quench {
namespace complex_topology_test {

// Rank over Z/2 of a matrix given by the rows of its columns; plain elimination.
std::int64_t rank(std::vector<std::vector<std::uint32_t>> columns, std::size_t rows) {
  std::vector<std::vector<std::uint8_t>> dense;
  for (const auto& column : columns) {
    std::vector<std::uint8_t> d(rows, 0);
    for (std::uint32_t r : column) d[r] ^= 1;
    dense.push_back(std::move(d));
  }
  std::int64_t result = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    const auto pivot = std::find_if(dense.begin() + result, dense.end(), [r](const auto& d) { return d[r]; });
    if (pivot == dense.end()) continue;
    std::iter_swap(dense.begin() + result, pivot);
    for (std::size_t c = 0; c < dense.size(); ++c)
      if (static_cast<std::int64_t>(c) != result && dense[c][r])
        for (std::size_t k = 0; k < rows; ++k) dense[c][k] ^= dense[static_cast<std::size_t>(result)][k];
    ++result;
  }
  return result;
}

// Betti numbers from the ranks of the boundary matrices.
Topology topology_by_ranks(const CellComplex& complex) {
  std::vector<std::vector<std::uint32_t>> edges, faces;
  for (const auto& e : complex.edges) edges.push_back({e[0], e[1]});
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto s = complex.sides(f);
    faces.emplace_back(s.begin(), s.end());
  }
  const std::int64_t d1 = rank(edges, complex.vertex_count), d2 = rank(faces, complex.edges.size());
  Topology t;
  const auto v = static_cast<std::int64_t>(complex.vertex_count), e = static_cast<std::int64_t>(edges.size()),
             f = static_cast<std::int64_t>(faces.size());
  t.betti = {v - d1, e - d1 - d2, f - d2};
  t.euler = v - e + f;
  return t;
}

// Random squares of a small cubical grid (pockets, seams, junctions and pinch points abound), random lone edges of it,
// random isolated vertices.
CellComplex random_complex(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const int n = 2 + static_cast<int>(random() % 2);
  const std::uint64_t percent = 20 + random() % 80;
  const auto id = [n](int x, int y, int z) { return static_cast<std::uint32_t>(x + (n + 1) * (y + (n + 1) * z)); };
  std::vector<std::uint32_t> offsets{0}, corners;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        const int p[3] = {x, y, z};
        for (int a = 0; a < 3; ++a) {
          int u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
          u[(a + 1) % 3] = v[(a + 2) % 3] = 1;
          if (p[(a + 1) % 3] < n && random() % 100 < 5)
            edges.push_back({id(x, y, z), id(x + u[0], y + u[1], z + u[2])});
          if (p[(a + 1) % 3] == n || p[(a + 2) % 3] == n || random() % 100 >= percent) continue;
          for (std::uint32_t c :
               {id(x, y, z), id(x + u[0], y + u[1], z + u[2]), id(x + u[0] + v[0], y + u[1] + v[1], z + u[2] + v[2]),
                id(x + v[0], y + v[1], z + v[2])})
            corners.push_back(c);
          offsets.push_back(static_cast<std::uint32_t>(corners.size()));
        }
      }
  return make_complex(static_cast<std::uint32_t>((n + 1) * (n + 1) * (n + 1)), edges, offsets, corners);
}

TEST(ComplexTopology, EqualsTheRanksOfTheBoundaryMatrices) {
  std::map<std::int64_t, int> seen;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const CellComplex complex = random_complex(seed);
    ASSERT_NO_THROW(complex.validate());
    const Topology expected = topology_by_ranks(complex);
    ASSERT_EQ(topology(complex), expected) << "seed " << seed;
    ++seen[std::min<std::int64_t>(expected.betti[2], 3)];
  }
  EXPECT_EQ(seen.size(), 4u);  // the sample holds complexes without, with one, two and more cavities
}

TEST(ComplexTopology, KnownComplexes) {
  const auto square = make_complex(4, {}, {0, 4}, {0, 1, 2, 3});
  EXPECT_EQ(topology(square), (Topology{1, {1, 0, 0}}));
  const auto tetrahedron = make_complex(4, {}, {0, 3, 6, 9, 12}, {0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3});
  EXPECT_EQ(topology(tetrahedron), (Topology{2, {1, 0, 1}}));
  const auto with_a_wall = make_complex(5, std::vector<std::array<std::uint32_t, 2>>{{0, 4}}, {0, 3, 6, 9, 12},
                                        {0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3});
  EXPECT_EQ(topology(with_a_wall), (Topology{2, {1, 0, 1}}));
  // The projective plane of six vertices has a 2-cycle over Z/2 (and none over the integers).
  const auto plane =
      make_complex(6, {}, {0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30},
                   {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 1, 1, 2, 4, 2, 3, 5, 3, 4, 1, 4, 5, 2, 5, 1, 3});
  EXPECT_EQ(topology(plane), (Topology{1, {1, 1, 1}}));
  EXPECT_EQ(topology(make_complex(3, {}, {0}, {})), (Topology{3, {3, 0, 0}}));
  EXPECT_EQ(topology(CellComplex{}), (Topology{0, {0, 0, 0}}));
}

TEST(CellComplex, MakeRefusesAndValidateNames) {
  EXPECT_THROW(make_complex(2, {}, {0, 3}, {0, 1, 2}), Error);
  EXPECT_THROW(make_complex(3, {}, {0, 2}, {0, 1}), Error);
  EXPECT_THROW(make_complex(2, std::vector<std::array<std::uint32_t, 2>>{{1, 1}}, {0}, {}), Error);
  auto complex = make_complex(4, {}, {0, 4}, {0, 1, 2, 3});
  complex.face_edges[2] = complex.face_edges[1];
  EXPECT_THROW(complex.validate(), Error);
  complex = make_complex(4, {}, {0, 3, 6}, {0, 1, 2, 1, 2, 0});
  EXPECT_THROW(complex.validate(), Error) << "the same face twice";
}

}  // namespace complex_topology_test
}  // namespace quench
