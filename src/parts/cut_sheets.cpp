// SPDX-License-Identifier: Apache-2.0
#include "parts/cut_sheets.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "base/union_find.h"
#include "quench/geometry.h"

namespace quench::parts {
namespace {

// Sets of triangles, each with a parity relative to the least one of its set.
class TurningSets {
 public:
  explicit TurningSets(std::size_t size) : parent_(size), parity_(size, 0), bad_(size, 0) {
    for (std::uint32_t i = 0; i < size; ++i) parent_[i] = i;
  }
  // The root of i; `parity` becomes that of i relative to it.
  std::uint32_t find(std::uint32_t i, char& parity) {
    std::uint32_t root = i;
    char sum = 0;
    while (parent_[root] != root) {
      sum = static_cast<char>(sum ^ parity_[root]);
      root = parent_[root];
    }
    parity = sum;
    while (parent_[i] != root && i != root) {
      const std::uint32_t next = parent_[i];
      const char own = parity_[i];
      parity_[i] = sum;
      parent_[i] = root;
      sum = static_cast<char>(sum ^ own);
      i = next;
    }
    return root;
  }
  void unite(std::uint32_t a, std::uint32_t b, char differ) {
    char of_a = 0, of_b = 0;
    a = find(a, of_a);
    b = find(b, of_b);
    const char turn = static_cast<char>(of_a ^ of_b ^ differ);
    if (a == b) {
      if (turn) bad_[a] = 1;
      return;
    }
    if (a > b) std::swap(a, b);
    parent_[b] = a;
    parity_[b] = turn;
    bad_[a] = static_cast<char>(bad_[a] | bad_[b]);
  }
  bool bad(std::uint32_t root) const { return bad_[root]; }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<char> parity_, bad_;
};

}  // namespace

std::vector<TriangleSide> sorted_sides(std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<TriangleSide> sides(3 * triangles.size());
  base::for_indices(triangles.size(), [&](std::size_t t) {
    for (std::uint8_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
      sides[3 * t + i] = {a, b, static_cast<std::uint32_t>(t), i};
    }
  });
  tbb::parallel_sort(sides, [](const TriangleSide& x, const TriangleSide& y) {
    return std::tie(x.a, x.b, x.triangle, x.side) < std::tie(y.a, y.b, y.triangle, y.side);
  });
  return sides;
}

CutSheets cut_sheets(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const TriangleSide> sides) {
  CutSheets cut;
  base::UnionFind corners(3 * triangles.size());
  TurningSets sheets(triangles.size());
  each_edge(sides, [&](std::span<const TriangleSide> at) {
    if (at.size() != 2) return;
    const auto corner = [&](const TriangleSide& s, bool second) { return 3 * s.triangle + (s.side + second) % 3; };
    const bool first_up = triangles[at[0].triangle][at[0].side] == at[0].a;
    const bool second_up = triangles[at[1].triangle][at[1].side] == at[1].a;
    for (const bool end : {false, true}) corners.unite(corner(at[0], end == first_up), corner(at[1], end == second_up));
    sheets.unite(at[0].triangle, at[1].triangle, first_up == second_up);
  });
  cut.vertex.resize(3 * triangles.size());
  for (std::uint32_t c = 0; c < cut.vertex.size(); ++c) {
    const std::uint32_t root = corners.find(c);
    if (root == c) {
      cut.vertex[c] = cut.vertices++;
      cut.corner_of.push_back(c);
    } else {
      cut.vertex[c] = cut.vertex[root];
    }
  }
  cut.turned.resize(triangles.size());
  cut.inconsistent.resize(triangles.size());
  cut.sheet.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    cut.sheet[t] = sheets.find(t, cut.turned[t]);
    cut.inconsistent[t] = sheets.bad(cut.sheet[t]);
  }
  return cut;
}

}  // namespace quench::parts
