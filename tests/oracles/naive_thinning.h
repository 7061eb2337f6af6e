// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "complex/thinning.h"
#include "quench/complex.h"

namespace quench::testing_complexes {

/// Thinning as it is defined, without any clever structure: look at all pairs, take the first, start again.
class NaiveThinning {
 public:
  NaiveThinning(const CellComplex& complex, const CellValues& value) : complex_(complex), value_(value) {
    vertex.assign(complex_.vertex_count, kInfinity);
    edge.assign(complex_.edges.size(), kInfinity);
    face.assign(complex_.face_count(), kInfinity);
    double running = -kInfinity;
    while (const auto pair = first_pair()) {
      const auto& [key, dimension, small, large] = *pair;
      running = std::max(running, key);
      (dimension == 1 ? face : edge)[large] = running;
      (dimension == 1 ? edge : vertex)[small] = running;
      pairs.push_back({running, dimension, small, large});
    }
  }
  /// Level, dimension and index of the free face, index of the other cell; in the order in which they are collapsed.
  using Pair = std::tuple<double, int, std::uint32_t, std::uint32_t>;
  std::vector<Pair> pairs;
  std::vector<double> vertex, edge, face;

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // With its key in place of the level.
  std::optional<Pair> first_pair() const {
    std::vector<std::vector<std::uint32_t>> faces(edge.size()), edges(vertex.size());
    for (std::uint32_t f = 0; f < face.size(); ++f)
      if (face[f] == kInfinity)
        for (const std::uint32_t e : complex_.sides(f)) faces[e].push_back(f);
    for (std::uint32_t e = 0; e < edge.size(); ++e)
      if (edge[e] == kInfinity)
        for (const std::uint32_t v : complex_.edges[e]) edges[v].push_back(e);
    std::optional<Pair> first;
    const auto consider = [&first](const Pair& p) {
      if (std::get<0>(p) < kInfinity && (!first || p < *first)) first = p;
    };
    for (std::uint32_t e = 0; e < edge.size(); ++e)
      if (edge[e] == kInfinity && faces[e].size() == 1)
        consider({std::max(value_.edge[e], value_.face[faces[e][0]]), 1, e, faces[e][0]});
    for (std::uint32_t v = 0; v < vertex.size(); ++v)
      if (vertex[v] == kInfinity && edges[v].size() == 1 && faces[edges[v][0]].empty())
        consider({std::max(value_.vertex[v], value_.edge[edges[v][0]]), 0, v, edges[v][0]});
    return first;
  }
  const CellComplex& complex_;
  const CellValues& value_;
};

}  // namespace quench::testing_complexes
