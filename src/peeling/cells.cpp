// SPDX-License-Identifier: Apache-2.0
#include "peeling/cells.h"

#include "lattice/polytopes.h"

namespace quench::peeling {

void Cells::reserve(std::size_t cells, std::size_t corners, std::size_t facets) {
  site_begin.reserve(cells + 1);
  hull.reserve(cells);
  neighbour_begin.reserve(cells + 1);
  sites.reserve(corners);
  neighbours.reserve(facets);
}

void Cells::append(const Cells& part, std::uint32_t shift) {
  const auto offset = [](std::vector<std::uint32_t>& begin, const std::vector<std::uint32_t>& more) {
    const std::uint32_t last = begin.back();
    lattice::check_index(std::size_t{last} + more.back());
    for (std::size_t i = 1; i < more.size(); ++i) begin.push_back(last + more[i]);
  };
  offset(site_begin, part.site_begin);
  offset(neighbour_begin, part.neighbour_begin);
  sites.insert(sites.end(), part.sites.begin(), part.sites.end());
  hull.insert(hull.end(), part.hull.begin(), part.hull.end());
  for (const std::uint32_t n : part.neighbours) neighbours.push_back(n < kBoundary ? n + shift : n);
}

}  // namespace quench::peeling
