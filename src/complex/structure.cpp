// SPDX-License-Identifier: Apache-2.0
#include "quench/structure.h"

#include "base/cofaces.h"
#include "base/union_find.h"

namespace quench {
namespace {

// Numbers the sets of the elements that are in some, in the order of their first ones; -1 for the others.
std::uint32_t number(base::UnionFind& sets, const std::vector<char>& in_some, std::vector<std::int32_t>& numbers) {
  std::int32_t next = 0;
  numbers.assign(in_some.size(), -1);
  for (std::uint32_t i = 0; i < in_some.size(); ++i)
    if (in_some[i]) numbers[i] = sets.find(i) == i ? next++ : numbers[sets.find(i)];
  return static_cast<std::uint32_t>(next);
}

// Unites the elements of every pair that is all there is at a place.
void unite_pairs(const std::vector<base::Cofaces>& at, std::uint32_t element, std::uint32_t place,
                 base::UnionFind& sets) {
  if (at[place].count() != 2) return;
  base::Cofaces other = at[place];
  other.remove(element);
  sets.unite(element, other.only());
}

}  // namespace

Structure structure_of(const CellComplex& complex) {
  Structure structure;
  const auto faces = static_cast<std::uint32_t>(complex.face_count());
  const auto edges = static_cast<std::uint32_t>(complex.edges.size());
  std::vector<base::Cofaces> faces_at(edges, base::Cofaces{});
  for (std::uint32_t f = 0; f < faces; ++f)
    for (const std::uint32_t e : complex.sides(f)) faces_at[e].add(f);
  base::UnionFind sheets(faces);
  for (std::uint32_t f = 0; f < faces; ++f)
    for (const std::uint32_t e : complex.sides(f)) unite_pairs(faces_at, f, e, sheets);
  structure.sheets = number(sheets, std::vector<char>(faces, 1), structure.face_sheet);

  std::vector<char> is_seam(edges);
  std::vector<base::Cofaces> seams_at(complex.vertex_count, base::Cofaces{});
  for (std::uint32_t e = 0; e < edges; ++e) {
    is_seam[e] = faces_at[e].count() > 2;
    if (!is_seam[e]) continue;
    for (const std::uint32_t v : complex.edges[e]) seams_at[v].add(e);
  }
  base::UnionFind seams(edges);
  for (std::uint32_t e = 0; e < edges; ++e) {
    if (!is_seam[e]) continue;
    for (const std::uint32_t v : complex.edges[e]) unite_pairs(seams_at, e, v, seams);
  }
  structure.seams = number(seams, is_seam, structure.edge_seam);
  structure.vertex_seam.assign(complex.vertex_count, -1);
  structure.junction.assign(complex.vertex_count, 0);
  for (std::uint32_t e = 0; e < edges; ++e) {
    if (!is_seam[e]) continue;
    for (const std::uint32_t v : complex.edges[e]) {
      if (seams_at[v].count() == 2)
        structure.vertex_seam[v] = structure.edge_seam[e];
      else
        structure.junction[v] = 1;
    }
  }
  return structure;
}

}  // namespace quench
