// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "peeling/cells.h"
#include "quench/context.h"

namespace quench::peeling {

/// Facets that cells were not found behind.
struct OpenFacets {
  std::vector<std::uint32_t> begin{0}, corners;  ///< sites, counter-clockwise seen from the side that is not known
  std::vector<std::uint32_t> cell, facet;        ///< whose facet it is; kNone: a boundary square

  std::uint32_t count() const { return static_cast<std::uint32_t>(cell.size()); }
  std::span<const std::uint32_t> operator[](std::uint32_t f) const {
    return {corners.data() + begin[f], corners.data() + begin[f + 1]};
  }
  void add(std::span<const std::uint32_t> its_corners, std::uint32_t its_cell, std::uint32_t its_facet) {
    corners.insert(corners.end(), its_corners.begin(), its_corners.end());
    begin.push_back(static_cast<std::uint32_t>(corners.size()));
    cell.push_back(its_cell);
    facet.push_back(its_facet);
  }
};

/// One list of many, which it consumes.
OpenFacets joined(std::vector<OpenFacets>& parts);

/// Adds all cells that are still missing, and closes the open facets.
///
/// Sites without an open facet are finished: around a site, O is a cone over regions of a small sphere. Each region is
/// cut by the cells into pieces joined by arcs and has boundary squares on its rim, since a site has a voxel outside
/// around it. So if neither a square nor a facet at the site is open, all its cells are known. The missing cells have
/// unfinished sites only; their balls are empty and their spheres carry the same sites among these, so they are cells
/// of the Delaunay complex of the unfinished sites. They fill exactly what is enclosed by the open facets: from these,
/// cells are followed through that complex. Other cells of it may be wrong, but nobody comes to them.
///
/// Consumes `open`. Throws Error(invariant) where the walk leaves O or a facet stays open. Memory: as Delaunay for the
/// unfinished sites.
void add_remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, OpenFacets open,
                   Hulls& hulls, Cells& cells, Context* context);

}  // namespace quench::peeling
