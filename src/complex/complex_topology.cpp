// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "base/csr.h"
#include "base/union_find.h"
#include "complex/pockets.h"
#include "quench/complex.h"
#include "quench/geometry.h"

namespace quench {
namespace {

// Dimension of the space of 0/1 vectors x over `unknowns` variables with, per equation, an even number of ones among
// the variables listed (each once). Equations of one or two variables fix or merge variables; Gauss does the rest.
std::int64_t solution_dimension(std::vector<std::vector<std::uint32_t>> equations, std::size_t unknowns) {
  base::UnionFind same(unknowns);
  std::vector<char> zero(unknowns, 0);
  const auto reduce = [&](std::vector<std::uint32_t>& equation) {
    for (std::uint32_t& x : equation) x = same.find(x);
    std::sort(equation.begin(), equation.end());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < equation.size();) {
      std::size_t j = i;
      while (j < equation.size() && equation[j] == equation[i]) ++j;
      if ((j - i) % 2 == 1 && !zero[equation[i]]) equation[kept++] = equation[i];
      i = j;
    }
    equation.resize(kept);
  };
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::vector<std::uint32_t>> rest;
    for (auto& equation : equations) {
      reduce(equation);
      if (equation.empty()) continue;
      if (equation.size() == 1) {
        zero[equation[0]] = 1;
        changed = true;
      } else if (equation.size() == 2) {
        same.unite(equation[0], equation[1]);
        changed = true;
      } else {
        rest.push_back(std::move(equation));
      }
    }
    std::sort(rest.begin(), rest.end());
    rest.erase(std::unique(rest.begin(), rest.end()), rest.end());
    equations.swap(rest);
  }
  std::int64_t dimension = 0;
  for (std::uint32_t x = 0; x < unknowns; ++x) dimension += same.find(x) == x && !zero[x];
  // Gauss over Z/2 on sorted sparse rows, pivot = largest variable.
  std::vector<std::int64_t> row_of_pivot(unknowns, -1);
  std::vector<std::uint32_t> sum;
  for (std::size_t r = 0; r < equations.size(); ++r) {
    auto& row = equations[r];
    while (!row.empty() && row_of_pivot[row.back()] >= 0) {
      const auto& pivot = equations[static_cast<std::size_t>(row_of_pivot[row.back()])];
      sum.clear();
      std::set_symmetric_difference(row.begin(), row.end(), pivot.begin(), pivot.end(), std::back_inserter(sum));
      row.swap(sum);
    }
    if (row.empty()) continue;
    row_of_pivot[row.back()] = static_cast<std::int64_t>(r);
    --dimension;
  }
  return dimension;
}

// b2 over Z/2: a 2-cycle has an even number of faces at every edge. Across an edge of two faces it has both or none, so
// the unknowns are the sheets between non-manifold edges, and each of those gives one equation.
std::int64_t second_betti(const CellComplex& complex) {
  const std::vector<char> alive = complex::faces_in_pockets(complex);
  const auto faces = base::Csr<std::uint32_t>::group(complex.edges.size(), [&](const auto& emit) {
    for (std::uint32_t f = 0; f < complex.face_count(); ++f)
      if (alive[f])
        for (const std::uint32_t e : complex.sides(f)) emit(e, f);
  });
  if (faces.items().empty()) return 0;

  base::UnionFind sheets(complex.face_count());
  for (std::size_t e = 0; e < faces.rows(); ++e)
    if (faces[e].size() == 2) sheets.unite(faces[e][0], faces[e][1]);
  std::vector<std::uint32_t> sheet_of(complex.face_count(), kNone);
  std::uint32_t count = 0;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    if (alive[f] && sheets.find(f) == f) sheet_of[f] = count++;
  std::vector<std::vector<std::uint32_t>> equations;
  for (std::size_t e = 0; e < faces.rows(); ++e) {
    if (faces[e].size() < 3) continue;
    std::vector<std::uint32_t> equation;
    for (const std::uint32_t f : faces[e]) equation.push_back(sheet_of[sheets.find(f)]);
    std::sort(equation.begin(), equation.end());
    equations.push_back(std::move(equation));
  }
  std::sort(equations.begin(), equations.end());
  equations.erase(std::unique(equations.begin(), equations.end()), equations.end());
  return solution_dimension(std::move(equations), count);
}

}  // namespace

Topology topology(const CellComplex& complex) {
  Topology t;
  t.euler = static_cast<std::int64_t>(complex.vertex_count) - static_cast<std::int64_t>(complex.edges.size()) +
            static_cast<std::int64_t>(complex.face_count());
  base::UnionFind components(complex.vertex_count);
  t.betti[0] = complex.vertex_count;
  for (const auto& e : complex.edges) t.betti[0] -= components.unite(e[0], e[1]);
  t.betti[2] = second_betti(complex);
  t.betti[1] = t.betti[0] + t.betti[2] - t.euler;
  return t;
}

}  // namespace quench
