// SPDX-License-Identifier: Apache-2.0
#include "peeling/peeling.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "lattice/polytopes.h"
#include "peeling/dual_from_cells.h"
#include "peeling/remainder.h"
#include "peeling/slab.h"

namespace quench::peeling {
namespace {

// Joins the loose facets of all slabs by their names; those that find no partner stay open.
OpenFacets join(std::vector<SlabPart>& parts, const Hulls& hulls, std::size_t site_count, Cells& cells,
                Context* context) {
  struct Loose {
    std::uint32_t second, third, cell, facet, part;
  };
  const bool shared = base::several_threads();
  std::vector<std::uint32_t> begin(site_count + 1, 0);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    for (const LooseFacet& f : parts[p].loose) base::fetch_add(begin[f.name[0] + 1], 1u, shared);
  });
  lattice::prefix_sum(begin);
  std::vector<Loose> loose(begin.back());
  std::vector<Cells> found;
  std::vector<std::uint32_t> shift{0};
  for (SlabPart& part : parts) {
    shift.push_back(shift.back() + part.cells.count());
    found.push_back(std::move(part.cells));
  }
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
      for (const LooseFacet& f : parts[p].loose)
        loose[base::fetch_add(next[f.name[0]], 1u, shared)] = {
            f.name[1], f.name[2], f.cell == kNone ? kNone : f.cell + shift[p], f.facet, static_cast<std::uint32_t>(p)};
      std::vector<LooseFacet>().swap(parts[p].loose);
    });
  }
  if (parts.size() > 1) cells.reserve_for(site_count);
  cells.append(found, Cells::Numbers::per_part);

  const auto link = [&](const Loose& f, const Loose& other) {
    if (f.cell != kNone) cells.neighbours_of(f.cell)[f.facet] = other.cell == kNone ? kBoundary : other.cell;
  };
  const std::size_t chunks = base::chunks_for(site_count);
  std::vector<OpenFacets> open(chunks);
  base::for_chunks(chunks, context, "peel", 1, 1, [&](std::size_t chunk) {
    const auto [begin_site, end_site] = base::part_of(site_count, chunk, chunks);
    std::vector<std::uint32_t> corners;
    for (std::size_t s = begin_site; s < end_site; ++s) {
      const auto first = loose.begin() + begin[s], last = loose.begin() + begin[s + 1];
      for (auto f = first; f != last; ++f) {
        if (f->second == kNone) continue;  // has been a partner
        const auto partner = std::find_if(
            f + 1, last, [&](const Loose& other) { return other.second == f->second && other.third == f->third; });
        if (partner != last) {
          link(*f, *partner);
          link(*partner, *f);
          partner->second = kNone;
          continue;
        }
        if (f->cell == kNone) {
          open[chunk].add(parts[f->part].squares[f->facet], f->cell, f->facet);
        } else {
          const auto sites = cells.sites_of(f->cell);
          corners.clear();
          for (const std::uint32_t c : hulls[cells.hull[f->cell]].corners_of(f->facet)) corners.push_back(sites[c]);
          open[chunk].add(corners, f->cell, f->facet);
        }
      }
    }
  });
  return joined(open);
}

// The first layer of each slab, and the end of the last. `layers`: of a slab; 0: one slab for each thread, with about
// as many sites, since slabs overlap (with four for each, two threads had an eighth more to do, and one of them
// waited).
std::vector<std::int32_t> slab_limits(const Input& input, std::int32_t layers) {
  const auto& sites = input.sites;
  const std::int32_t end = sites.back()[2] + 1;
  std::vector<std::int32_t> limits{sites.front()[2]};
  const auto wanted = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  for (std::size_t slab = 1;; ++slab) {
    std::int32_t next = limits.back() + layers;
    if (layers == 0)
      next = slab < wanted ? std::max(limits.back() + 8 * input.layers(), sites[sites.size() / wanted * slab][2]) : end;
    if (next >= end || (layers == 0 && end - next < 8 * input.layers())) break;
    limits.push_back(next);
  }
  limits.push_back(end);
  return limits;
}

}  // namespace

lattice::DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                  const std::array<std::int64_t, 3>& spacing, const Options& options,
                                  Context* context) {
  const auto [least, largest] = std::minmax({spacing[0], spacing[1], spacing[2]});
  // With very different spacings a ball of a few of the largest holds too many sites to try them one by one.
  const double reach = largest <= 3 * least ? options.reach * static_cast<double>(largest) : 0;
  const std::int64_t extent = *std::ranges::max_element(shape.grid().dims) + 2;
  const auto triangulate_all = [&] {
    return lattice::dual_complex(shape, std::make_unique<lattice::Delaunay>(sites, spacing, context), sites, context);
  };
  if (SiteIndex::groups(shape.grid().dims) > 4 * sites.size() + options.spare_groups) return triangulate_all();
  Hulls hulls;
  Cells cells;
  OpenFacets open;
  {
    std::optional<SiteIndex> index(std::in_place, sites);
    const lattice::Predicates predicates(spacing, extent);
    const Input input{shape, sites, spacing, predicates, *index, reach, options.least_cubes};
    const std::vector<std::int32_t> limits = slab_limits(input, options.layers);
    std::vector<SlabPart> parts(limits.size() - 1);
    base::for_chunks(parts.size(), context, "peel", 0, 1,
                     [&](std::size_t slab) { parts[slab] = peel_slab(input, limits[slab], limits[slab + 1], hulls); });
    index.reset();
    std::size_t peeled = 0;
    for (const SlabPart& part : parts) peeled += part.cells.count();
    if (static_cast<double>(peeled) < options.least_cells * static_cast<double>(sites.size())) {
      parts.clear();
      return triangulate_all();
    }
    open = join(parts, hulls, sites.size(), cells, context);
  }
  add_remainder(sites, spacing, std::move(open), hulls, cells, context);
  return dual_from_cells(std::move(cells), hulls, sites.size(), context);
}

}  // namespace quench::peeling
