// SPDX-License-Identifier: Apache-2.0
// What parts of a complex remove by themselves is what the thinning of the whole removes.
#include "complex/certain_thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "complex/thinning.h"
#include "naive_thinning.h"
#include "quench/axis.h"
#include "random_complexes.h"
#include "random_shapes.h"

namespace quench {
namespace certain_thinning_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Input {
  CellComplex complex;
  CellValues value;
};

CellValues thinned(const Input& input) {
  return complex::thin(input.complex, input.value.vertex, input.value.edge, input.value.face, nullptr, "");
}

// Some cells of a complex as a complex, with their numbers in the whole.
struct Selection {
  Input input;
  std::vector<std::uint32_t> vertex, edge, face;
};

Selection selected(const Input& from, const complex::CellFlags& which) {
  Selection s;
  std::vector<std::uint32_t> vertex(from.complex.vertex_count), edge(from.complex.edges.size());
  for (std::uint32_t v = 0; v < vertex.size(); ++v) {
    if (!which.vertex[v]) continue;
    vertex[v] = s.input.complex.vertex_count++;
    s.vertex.push_back(v);
    s.input.value.vertex.push_back(from.value.vertex[v]);
  }
  for (std::uint32_t e = 0; e < edge.size(); ++e) {
    if (!which.edge[e]) continue;
    const auto [a, b] = from.complex.edges[e];
    EXPECT_TRUE(which.vertex[a] && which.vertex[b]) << "not closed";
    edge[e] = static_cast<std::uint32_t>(s.edge.size());
    s.edge.push_back(e);
    s.input.complex.edges.push_back({vertex[a], vertex[b]});
    s.input.value.edge.push_back(from.value.edge[e]);
  }
  for (std::uint32_t f = 0; f < from.complex.face_count(); ++f) {
    if (!which.face[f]) continue;
    s.face.push_back(f);
    for (const std::uint32_t e : from.complex.sides(f)) {
      EXPECT_TRUE(which.edge[e]) << "not closed";
      s.input.complex.face_edges.push_back(edge[e]);
    }
    for (const std::uint32_t v : from.complex.corners(f)) s.input.complex.face_vertices.push_back(vertex[v]);
    s.input.complex.face_offsets.push_back(static_cast<std::uint32_t>(s.input.complex.face_edges.size()));
    s.input.value.face.push_back(from.value.face[f]);
  }
  return s;
}

complex::CellFlags flags(const CellComplex& complex, std::uint8_t value) {
  return {std::vector<std::uint8_t>(complex.vertex_count, value),
          std::vector<std::uint8_t>(complex.edges.size(), value),
          std::vector<std::uint8_t>(complex.face_count(), value)};
}

// A complex and what is left of it after parts of it have been thinned.
class InParts {
 public:
  InParts(Input input, double cutoff, std::uint64_t seed)
      : whole_(std::move(input)), cutoff_(cutoff), random_(seed), left_(flags(whole_.complex, 1)) {}

  // Parts of so many groups of vertices; one cell of `hidden` is not known to any.
  void thin_parts(std::uint32_t parts, std::uint32_t hidden, bool at_random) {
    std::vector<std::uint32_t> part(whole_.complex.vertex_count);
    for (std::uint32_t v = 0; v < part.size(); ++v)
      part[v] = at_random ? below(parts) : static_cast<std::uint32_t>(std::uint64_t{v} * parts / part.size());
    complex::CellFlags known = left_;
    const auto hide = [&](std::uint8_t& cell) { cell = cell && below(hidden) != 0; };
    for (std::uint8_t& v : known.vertex) hide(v);
    for (std::uint32_t e = 0; e < known.edge.size(); ++e) {
      hide(known.edge[e]);
      const auto [a, b] = whole_.complex.edges[e];
      if (!known.vertex[a] || !known.vertex[b] || part[a] != part[b]) known.edge[e] = 0;
    }
    for (std::uint32_t f = 0; f < known.face.size(); ++f) {
      hide(known.face[f]);
      for (const std::uint32_t e : whole_.complex.sides(f))
        if (!known.edge[e]) known.face[f] = 0;
    }
    const complex::CellFlags before = left_;
    for (std::uint32_t p = 0; p < parts; ++p) {
      complex::CellFlags its = known;
      for (std::uint32_t v = 0; v < part.size(); ++v) its.vertex[v] = known.vertex[v] && part[v] == p;
      for (std::uint32_t e = 0; e < its.edge.size(); ++e)
        its.edge[e] = known.edge[e] && its.vertex[whole_.complex.edges[e][0]];
      for (std::uint32_t f = 0; f < its.face.size(); ++f)
        its.face[f] =
            known.face[f] && std::ranges::all_of(whole_.complex.sides(f), [&](auto e) { return its.edge[e]; });
      thin_part(its, before);
    }
  }

  void check(const std::string& of) const {
    const CellValues expected = thinned(whole_);
    const Selection rest = selected(whole_, left_);
    const CellValues level = thinned(rest.input);
    const auto compare = [&](const std::vector<double>& whole, const std::vector<double>& part,
                             const std::vector<std::uint32_t>& number, const std::vector<std::uint8_t>& left) {
      for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_TRUE(left[i] || whole[i] < cutoff_) << of;
      for (std::size_t i = 0; i < part.size(); ++i) {
        if (whole[number[i]] >= cutoff_)
          ASSERT_EQ(part[i], whole[number[i]]) << of;
        else
          ASSERT_LT(part[i], cutoff_) << of;
      }
    };
    compare(expected.vertex, level.vertex, rest.vertex, left_.vertex);
    compare(expected.edge, level.edge, rest.edge, left_.edge);
    compare(expected.face, level.face, rest.face, left_.face);
  }
  // That those removed are pairs of the naive thinning of the whole, and that the others are collapsed in its order.
  void check_pairs() const {
    using Naive = testing_complexes::NaiveThinning;
    const Naive whole(whole_.complex, whole_.value);
    const Selection rest = selected(whole_, left_);
    const Naive naive_of_rest(rest.input.complex, rest.input.value);
    std::vector<std::array<std::uint32_t, 3>> expected, found;
    for (const auto& [level, dimension, small, large] : whole.pairs) {
      const bool small_is_left = (dimension == 1 ? left_.edge : left_.vertex)[small] != 0;
      const bool large_is_left = (dimension == 1 ? left_.face : left_.edge)[large] != 0;
      ASSERT_EQ(small_is_left, large_is_left);
      if (small_is_left) expected.push_back({static_cast<std::uint32_t>(dimension), small, large});
    }
    for (const auto& [level, dimension, small, large] : naive_of_rest.pairs)
      found.push_back({static_cast<std::uint32_t>(dimension), (dimension == 1 ? rest.edge : rest.vertex)[small],
                       (dimension == 1 ? rest.face : rest.edge)[large]});
    ASSERT_EQ(found, expected);
  }
  std::size_t removed() const {
    return static_cast<std::size_t>(std::ranges::count(left_.edge, 0) + std::ranges::count(left_.vertex, 0));
  }

 private:
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(random_() % n); }

  void thin_part(const complex::CellFlags& its, const complex::CellFlags& before) {
    Selection part = selected(whole_, its);
    std::vector<std::uint8_t> vertex(part.vertex.size(), 0), edge(part.edge.size(), 0);
    std::vector<std::uint8_t> open_vertex(before.vertex.size(), 0), open_edge(before.edge.size(), 0);
    for (std::uint32_t f = 0; f < before.face.size(); ++f)
      if (before.face[f] && !its.face[f])
        for (const std::uint32_t e : whole_.complex.sides(f)) open_edge[e] = 1;
    for (std::uint32_t e = 0; e < before.edge.size(); ++e)
      if (before.edge[e] && !its.edge[e])
        for (const std::uint32_t v : whole_.complex.edges[e]) open_vertex[v] = 1;
    for (std::size_t e = 0; e < edge.size(); ++e) edge[e] = open_edge[part.edge[e]];
    for (std::size_t v = 0; v < vertex.size(); ++v) vertex[v] = open_vertex[part.vertex[v]];
    Input& input = part.input;
    const auto lower = [&](double& value) {
      value = below(2) ? value : value < kInfinity ? value / (1 + below(4)) : 3;
    };
    for (std::size_t f = 0; f < part.face.size(); ++f) {
      if (below(40)) continue;
      lower(input.value.face[f]);
      for (const std::uint32_t e : input.complex.sides(f)) edge[e] = 1;
    }
    for (std::size_t e = 0; e < edge.size(); ++e)
      if ((edge[e] |= below(60) == 0)) lower(input.value.edge[e]);
    for (std::size_t v = 0; v < vertex.size(); ++v)
      if ((vertex[v] |= below(60) == 0)) lower(input.value.vertex[v]);
    const complex::CellFlags gone = complex::certainly_removed(
        {input.complex, input.value.vertex, input.value.edge, input.value.face, vertex, edge}, cutoff_, nullptr, "");
    for (std::size_t v = 0; v < vertex.size(); ++v)
      if (gone.vertex[v]) left_.vertex[part.vertex[v]] = 0;
    for (std::size_t e = 0; e < edge.size(); ++e)
      if (gone.edge[e]) left_.edge[part.edge[e]] = 0;
    for (std::size_t f = 0; f < part.face.size(); ++f)
      if (gone.face[f]) left_.face[part.face[f]] = 0;
  }

  Input whole_;
  double cutoff_;
  std::mt19937_64 random_;
  complex::CellFlags left_;
};

// As values of a measure are: no smaller of sides.
void spread(Input& input) {
  const CellComplex& complex = input.complex;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f))
      input.value.edge[e] = std::max(input.value.edge[e], input.value.face[f]);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    for (const std::uint32_t v : complex.edges[e])
      input.value.vertex[v] = std::max(input.value.vertex[v], input.value.edge[e]);
}

void give_values(Input& input, std::mt19937_64& random, std::uint64_t different, std::uint64_t infinite) {
  input.value.vertex.resize(input.complex.vertex_count);
  input.value.edge.resize(input.complex.edges.size());
  input.value.face.resize(input.complex.face_count());
  for (auto* values : {&input.value.vertex, &input.value.edge, &input.value.face})
    for (double& value : *values)
      value = random() % infinite == 0 ? kInfinity : static_cast<double>(random() % different);
}

// Rounds with fewer and fewer parts, as bricks are joined.
std::size_t expect_same(const Input& input, double cutoff, std::uint64_t seed, bool by_pairs) {
  InParts parts(input, cutoff, seed);
  const std::uint32_t hidden[] = {4, 20, 100, 1000};
  for (std::uint32_t count = 8; count > 0; count /= 2) {
    parts.thin_parts(count, hidden[(seed + count) % 4], seed % 2);
    parts.check(std::to_string(count));
    if (by_pairs && !testing::Test::HasFatalFailure()) parts.check_pairs();
    if (testing::Test::HasFatalFailure()) break;
  }
  return parts.removed();
}

TEST(CertainThinning, OfVoxelCores) {
  std::size_t removed = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    MedialAxis axis = voxel_core(testing_shapes::random_shape(seed, 6), {.rule = LambdaRule::coface});
    Input input{std::move(axis.complex), std::move(axis.measure().value)};
    if (seed % 4) {
      give_values(input, random, seed % 4 == 1 ? 3 : seed % 4 == 2 ? 12 : 1'000'000, 64);
      if (seed % 3) spread(input);
    }
    std::vector<double> values = input.value.face;
    values.push_back(1);
    std::ranges::sort(values);
    removed += expect_same(input, std::min(values[values.size() * 4 / 5], 1e6), seed, seed % 4 == 0);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(removed, 1000u);
}

TEST(CertainThinning, WhateverTheComplex) {
  std::size_t removed = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    Input input{testing_complexes::any_complex(random), {}};
    give_values(input, random, seed % 3 ? 6 : 1000, 16);
    if (seed % 5) spread(input);
    removed += expect_same(input, seed % 3 ? 5 : 800, seed, true);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(removed, 3000u);
}

}  // namespace certain_thinning_test
}  // namespace quench
