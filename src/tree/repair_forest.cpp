// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_forest.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "base/union_find.h"

namespace quench::tree {

std::vector<std::uint8_t> spanning_forest(std::uint32_t vertices, std::span<const ForestEdge> edges,
                                          std::span<const std::uint32_t> marked, std::span<const double> worth) {
  std::vector<std::uint32_t> order(edges.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, [&](std::uint32_t e, std::uint32_t f) { return edges[e].gain > edges[f].gain; });
  base::UnionFind trees(vertices);
  std::vector<char> is_marked(vertices, 0);
  for (const std::uint32_t v : marked) is_marked[v] = 1;
  std::vector<double> sum(worth.begin(), worth.end());
  std::vector<std::uint8_t> kept(edges.size(), 0);
  for (const std::uint32_t e : order) {
    const std::uint32_t a = trees.find(edges[e].a), b = trees.find(edges[e].b);
    if (a == b || (is_marked[a] && is_marked[b])) continue;
    if (edges[e].gain < 0 && !sum.empty()) {
      const auto pays = [&](std::uint32_t tree) { return is_marked[tree] || sum[tree] > -edges[e].gain; };
      if (!pays(a) || !pays(b)) continue;
    }
    kept[e] = 1;
    trees.unite(a, b);
    const std::uint32_t both = trees.find(a), other = both == a ? b : a;
    is_marked[both] = is_marked[a] || is_marked[b];
    if (!sum.empty()) sum[both] += sum[other];
  }
  return kept;
}

}  // namespace quench::tree
