// SPDX-License-Identifier: Apache-2.0
#include "peeling/cells.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "lattice/polytopes.h"

namespace quench::peeling {

void Cells::reserve_for(std::size_t site_count) {
  // Shapes have up to 1.3 cells per site, with 5 corners and facets each.
  site_begin.reserve(site_count * 4 / 3 + 1);
  hull.reserve(site_count * 4 / 3);
  neighbour_begin.reserve(site_count * 4 / 3 + 1);
  sites.reserve(site_count * 13 / 2);
  neighbours.reserve(site_count * 7);
}

void Cells::append(std::vector<Cells>& parts, Numbers numbers) {
  if (count() == 0 && parts.size() == 1) {
    *this = std::move(parts[0]);
    parts[0] = {};
    return;
  }
  struct Place {
    std::size_t cell, site, neighbour;
  };
  std::vector<Place> places{{count(), sites.size(), neighbours.size()}};
  for (const Cells& part : parts) {
    const Place& last = places.back();
    places.push_back(
        {last.cell + part.count(), last.site + part.sites.size(), last.neighbour + part.neighbours.size()});
  }
  lattice::check_index(std::max({places.back().cell, places.back().site, places.back().neighbour}));
  // Zeros take time: the system hands out the pages meanwhile.
  tbb::parallel_invoke(
      [&] {
        site_begin.resize(places.back().cell + 1);
        hull.resize(places.back().cell);
        neighbour_begin.resize(places.back().cell + 1);
      },
      [&] { sites.resize(places.back().site); }, [&] { neighbours.resize(places.back().neighbour); });
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    const Cells part = std::move(parts[p]);
    parts[p] = {};
    const Place& at = places[p];
    for (std::size_t c = 0; c < part.count(); ++c) {
      hull[at.cell + c] = part.hull[c];
      site_begin[at.cell + c + 1] = static_cast<std::uint32_t>(at.site) + part.site_begin[c + 1];
      neighbour_begin[at.cell + c + 1] = static_cast<std::uint32_t>(at.neighbour) + part.neighbour_begin[c + 1];
    }
    std::ranges::copy(part.sites, sites.begin() + static_cast<std::ptrdiff_t>(at.site));
    const auto shift = numbers == Numbers::per_part ? static_cast<std::uint32_t>(at.cell) : 0;
    std::ranges::transform(part.neighbours, neighbours.begin() + static_cast<std::ptrdiff_t>(at.neighbour),
                           [shift](std::uint32_t n) { return n < kBoundary ? n + shift : n; });
  });
}

}  // namespace quench::peeling
