// SPDX-License-Identifier: Apache-2.0
#include "quench/complex.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "quench/error.h"

namespace quench {

void CellComplex::validate() const {
  const auto fail = [](const std::string& what) { throw Error(ErrorCode::invariant, "cell complex: " + what); };
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (edges[e][0] >= edges[e][1] || edges[e][1] >= vertex_count)
      fail(fmt::format("edge {} joins {} and {} of {} vertices", e, edges[e][0], edges[e][1], vertex_count));
  auto sorted = edges;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    fail(fmt::format("there are two edges between {} and {}", (*twice)[0], (*twice)[1]));
  if (face_offsets.empty() || face_offsets.front() != 0 || face_offsets.back() != face_vertices.size() ||
      face_edges.size() != face_vertices.size())
    fail("face offsets do not span the corners and sides");
  std::vector<std::vector<std::uint32_t>> corner_sets;
  for (std::size_t f = 0; f < face_count(); ++f) {
    if (face_offsets[f] + 3 > face_offsets[f + 1]) fail(fmt::format("face {} has fewer than three corners", f));
    const auto c = corners(f);
    const auto s = sides(f);
    for (std::size_t i = 0; i < c.size(); ++i) {
      const std::uint32_t u = c[i], v = c[(i + 1) % c.size()];
      if (s[i] >= edges.size() || edges[s[i]] != std::array<std::uint32_t, 2>{std::min(u, v), std::max(u, v)})
        fail(fmt::format("side {} of face {} does not join its corners", i, f));
    }
    std::vector<std::uint32_t> set(c.begin(), c.end());
    std::sort(set.begin(), set.end());
    if (std::adjacent_find(set.begin(), set.end()) != set.end()) fail(fmt::format("face {} repeats a corner", f));
    corner_sets.push_back(std::move(set));
  }
  std::sort(corner_sets.begin(), corner_sets.end());
  if (std::adjacent_find(corner_sets.begin(), corner_sets.end()) != corner_sets.end())
    fail("two faces have the same corners");
}

CellComplex make_complex(std::uint32_t vertex_count, std::span<const std::array<std::uint32_t, 2>> edges,
                         std::vector<std::uint32_t> face_offsets, std::vector<std::uint32_t> face_vertices) {
  CellComplex complex;
  complex.vertex_count = vertex_count;
  complex.face_offsets = std::move(face_offsets);
  complex.face_vertices = std::move(face_vertices);
  const auto check = [&](std::uint32_t v) {
    if (v >= vertex_count)
      throw Error(ErrorCode::input, fmt::format("a cell refers to vertex {} of {}", v, vertex_count));
  };
  const auto add = [&](std::uint32_t u, std::uint32_t v) {
    check(u);
    check(v);
    if (u == v) throw Error(ErrorCode::input, fmt::format("an edge joins vertex {} with itself", u));
    complex.edges.push_back({std::min(u, v), std::max(u, v)});
  };
  for (const auto& e : edges) add(e[0], e[1]);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto c = complex.corners(f);
    if (c.size() < 3) throw Error(ErrorCode::input, fmt::format("face {} has fewer than three corners", f));
    for (std::size_t i = 0; i < c.size(); ++i) add(c[i], c[(i + 1) % c.size()]);
  }
  std::sort(complex.edges.begin(), complex.edges.end());
  complex.edges.erase(std::unique(complex.edges.begin(), complex.edges.end()), complex.edges.end());
  complex.edges.shrink_to_fit();

  complex.face_edges.reserve(complex.face_vertices.size());
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto c = complex.corners(f);
    for (std::size_t i = 0; i < c.size(); ++i) {
      const std::uint32_t u = c[i], v = c[(i + 1) % c.size()];
      const std::array<std::uint32_t, 2> edge{std::min(u, v), std::max(u, v)};
      complex.face_edges.push_back(static_cast<std::uint32_t>(
          std::lower_bound(complex.edges.begin(), complex.edges.end(), edge) - complex.edges.begin()));
    }
  }
  return complex;
}

}  // namespace quench
