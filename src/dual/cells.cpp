// SPDX-License-Identifier: Apache-2.0
#include "dual/cells.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "quench/error.h"

namespace quench::dual {
namespace {

// Where the elements of a part go.
struct Place {
  std::size_t polytope, site, neighbour, unmatched, square;

  Place after(const CellsPart& part) const {
    return {polytope + part.cells.count(), site + part.cells.sites.size(), neighbour + part.cells.neighbours.size(),
            unmatched + part.unmatched.size(), square + part.squares.size()};
  }
};

// Zeros take time: the system hands out the pages meanwhile.
void resize(CellsPart& part, const Place& size) {
  Cells& cells = part.cells;
  tbb::parallel_invoke(
      [&] {
        cells.site_begin.resize(size.polytope + 1);
        cells.hull.resize(size.polytope);
        cells.neighbour_begin.resize(size.polytope + 1);
      },
      [&] { cells.sites.resize(size.site); }, [&] { cells.neighbours.resize(size.neighbour); },
      [&] {
        part.unmatched.resize(size.unmatched);
        part.squares.resize(size.square);
      });
}

void copy(const CellsPart& part, const Place& at, Numbers numbers, CellsPart& whole) {
  const Cells& from = part.cells;
  Cells& to = whole.cells;
  const auto polytopes = numbers == Numbers::per_part ? static_cast<std::uint32_t>(at.polytope) : 0;
  for (std::size_t p = 0; p < from.count(); ++p) {
    to.hull[at.polytope + p] = from.hull[p];
    to.site_begin[at.polytope + p + 1] = static_cast<std::uint32_t>(at.site) + from.site_begin[p + 1];
    to.neighbour_begin[at.polytope + p + 1] = static_cast<std::uint32_t>(at.neighbour) + from.neighbour_begin[p + 1];
  }
  std::ranges::copy(from.sites, to.sites.begin() + static_cast<std::ptrdiff_t>(at.site));
  std::ranges::transform(from.neighbours, to.neighbours.begin() + static_cast<std::ptrdiff_t>(at.neighbour),
                         [&](std::uint32_t n) { return n < kPruned ? n + polytopes : n; });
  std::ranges::transform(part.unmatched, whole.unmatched.begin() + static_cast<std::ptrdiff_t>(at.unmatched),
                         [&](UnmatchedFacet f) {
                           if (f.polytope == kNone)
                             f.facet += static_cast<std::uint32_t>(at.square);
                           else
                             f.polytope += polytopes;
                           return f;
                         });
  std::ranges::copy(part.squares, whole.squares.begin() + static_cast<std::ptrdiff_t>(at.square));
}

}  // namespace

void Cells::reserve_for(std::size_t site_count) {
  // Shapes have up to 1.3 polytopes per site, with 5 corners and facets each.
  site_begin.reserve(site_count * 4 / 3 + 1);
  hull.reserve(site_count * 4 / 3);
  neighbour_begin.reserve(site_count * 4 / 3 + 1);
  sites.reserve(site_count * 13 / 2);
  neighbours.reserve(site_count * 7);
}

void append(std::vector<CellsPart>& parts, Numbers numbers, CellsPart& whole) {
  std::vector<Place> places{Place{0, 0, 0, 0, 0}.after(whole)};
  for (const CellsPart& part : parts) places.push_back(places.back().after(part));
  const Place& end = places.back();
  base::check_index(std::max({end.polytope, end.site, end.neighbour, end.unmatched, end.square}));
  if (parts.size() == 1 && whole.cells.count() == 0 && whole.unmatched.empty()) {
    whole = std::exchange(parts[0], {});
    return;
  }
  resize(whole, end);
  tbb::parallel_for(std::size_t{0}, parts.size(),
                    [&](std::size_t p) { copy(std::exchange(parts[p], {}), places[p], numbers, whole); });
}

void match(CellsPart& part, std::size_t site_count, Context* context, std::string_view stage, double progress) {
  std::vector<UnmatchedFacet>& facets = part.unmatched;
  const bool shared = base::several_threads();
  std::vector<std::uint32_t> begin(site_count + 1, 0), order(facets.size());  // facets by their smallest sites
  base::for_indices(facets.size(), [&](std::size_t f) { base::fetch_add(begin[facets[f].key[0] + 1], 1u, shared); });
  base::prefix_sum(begin);
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    base::for_indices(facets.size(), [&](std::size_t f) {
      order[base::fetch_add(next[facets[f].key[0]], 1u, shared)] = static_cast<std::uint32_t>(f);
    });
  }
  const auto link = [&](const UnmatchedFacet& f, std::uint32_t across) {
    if (f.polytope != kNone) part.cells.neighbours_of(f.polytope)[f.facet] = across == kNone ? kBoundary : across;
  };
  const std::size_t chunks = base::chunks_for(site_count);
  base::for_chunks(chunks, context, stage, progress, progress, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(site_count, chunk, chunks);
    for (std::size_t s = first; s < last; ++s)
      for (std::uint32_t i = begin[s]; i < begin[s + 1]; ++i) {
        if (order[i] == kNone) continue;
        const UnmatchedFacet& f = facets[order[i]];
        for (std::uint32_t j = i + 1; j < begin[s + 1]; ++j) {
          if (order[j] == kNone || facets[order[j]].key != f.key) continue;
          link(f, facets[order[j]].polytope);
          link(facets[order[j]], f.polytope);
          order[i] = order[j] = kNone;
          break;
        }
      }
  });
  std::vector<UnmatchedFacet> left;
  for (const std::uint32_t f : order)
    if (f != kNone) left.push_back(facets[f]);
  facets = std::move(left);
}

void match_all(CellsPart& part, std::size_t site_count, Context* context, std::string_view stage, double progress) {
  match(part, site_count, context, stage, progress);
  if (part.unmatched.empty()) return;
  const FacetKey& key = part.unmatched[0].key;
  throw Error(ErrorCode::invariant, fmt::format("the facet with the sites {}, {}, {} of the voxel core's dual is not "
                                                "shared by two polytopes",
                                                key[0], key[1], key[2]));
}

}  // namespace quench::dual
