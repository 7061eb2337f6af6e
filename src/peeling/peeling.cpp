// SPDX-License-Identifier: Apache-2.0
#include "peeling/peeling.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "lattice/polytopes.h"
#include "parallel.h"
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
  std::vector<std::uint32_t> begin(site_count + 1, 0);
  for (const SlabPart& part : parts)
    for (const LooseFacet& f : part.loose) ++begin[f.name[0] + 1];
  lattice::prefix_sum(begin);
  std::vector<Loose> loose(begin.back());
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    std::size_t count = 0, corners = 0, facets = 0;
    for (const SlabPart& part : parts) {
      count += part.cells.count();
      corners += part.cells.sites.size();
      facets += part.cells.neighbours.size();
    }
    // Room for the cells that are missing, too: shapes have up to 1.3 cells per site with 5 corners and facets each.
    cells.reserve(std::max(count, site_count * 4 / 3), std::max(corners, site_count * 13 / 2),
                  std::max(facets, site_count * 7));
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
      const std::uint32_t shift = cells.count();
      for (const LooseFacet& f : parts[p].loose)
        loose[next[f.name[0]]++] = {f.name[1], f.name[2], f.cell == kNone ? kNone : f.cell + shift, f.facet, p};
      std::vector<LooseFacet>().swap(parts[p].loose);
      cells.append(parts[p].cells, shift);
      parts[p].cells = {};
    }
  }
  const auto link = [&](const Loose& f, const Loose& other) {
    if (f.cell != kNone) cells.neighbours_of(f.cell)[f.facet] = other.cell == kNone ? kBoundary : other.cell;
  };
  OpenFacets open;
  for (std::size_t s = 0; s < site_count; ++s) {
    if ((s & 0xFFFFF) == 0) checkpoint(context, "peel", 1);
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
        const Square& square = parts[f->part].squares[f->facet];
        open.corners.insert(open.corners.end(), square.begin(), square.end());
      } else {
        const auto sites = cells.sites_of(f->cell);
        for (const std::uint32_t c : hulls[cells.hull[f->cell]].corners_of(f->facet)) open.corners.push_back(sites[c]);
      }
      open.begin.push_back(static_cast<std::uint32_t>(open.corners.size()));
      open.cell.push_back(f->cell);
      open.facet.push_back(f->facet);
    }
  }
  return open;
}

}  // namespace

lattice::DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                  const std::array<std::int64_t, 3>& spacing, const Options& options,
                                  Context* context) {
  const auto [least, largest] = std::minmax({spacing[0], spacing[1], spacing[2]});
  // With very different spacings a ball of a few of the largest holds too many sites to try them one by one.
  const double reach = largest <= 3 * least ? options.reach * static_cast<double>(largest) : 0;
  const std::int64_t extent = *std::ranges::max_element(shape.grid().dims) + 2;
  Hulls hulls;
  Cells cells;
  OpenFacets open;
  {
    std::optional<SiteIndex> index(std::in_place, sites);
    const lattice::Predicates predicates(spacing, extent);
    const Input input{shape, sites, spacing, predicates, *index, reach, options.least_cubes};
    const std::int32_t low = sites.front()[2], high = sites.back()[2] + 1;
    std::int32_t layers = options.layers;
    if (layers == 0) {
      // Slabs overlap; a few for each thread, but thick ones.
      const std::int32_t wanted = 4 * std::max(1, tbb::this_task_arena::max_concurrency());
      layers = std::max((high - low + wanted - 1) / wanted, 8 * input.layers());
    }
    const auto slabs = static_cast<std::size_t>((high - low + layers - 1) / layers);
    std::vector<SlabPart> parts(slabs);
    for_chunks(slabs, context, "peel", 0, 1, [&](std::size_t slab) {
      const auto begin = low + static_cast<std::int32_t>(slab) * layers;
      parts[slab] = peel_slab(input, begin, std::min(begin + layers, high), hulls);
    });
    index.reset();
    std::size_t peeled = 0;
    for (const SlabPart& part : parts) peeled += part.cells.count();
    if (static_cast<double>(peeled) < options.least_cells * static_cast<double>(sites.size())) {
      parts.clear();
      return lattice::dual_complex(shape, std::make_unique<lattice::Delaunay>(sites, spacing, context), sites, context);
    }
    open = join(parts, hulls, sites.size(), cells, context);
  }
  add_remainder(sites, spacing, std::move(open), hulls, cells, context);
  return dual_from_cells(std::move(cells), hulls, sites.size(), context);
}

}  // namespace quench::peeling
