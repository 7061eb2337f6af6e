// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dual/cells.h"

namespace quench::dual::peel {

/// Adds all polytopes that are still missing, and matches the unmatched facets and squares with theirs.
///
/// Sites without an unmatched facet are finished: around a site, O is a cone over regions of a small sphere. Each
/// region is cut by the polytopes into pieces joined by arcs and has boundary squares on its rim, since a site has a
/// voxel outside around it. So if neither a square nor a facet at the site is unmatched, all its polytopes are known.
/// The missing polytopes have unfinished sites only; their balls are empty and their spheres carry the same sites among
/// these, so they are polytopes of the Delaunay complex of the unfinished sites. They fill exactly what is enclosed by
/// the unmatched facets: from these, polytopes are followed through that complex. Other polytopes of that complex may
/// be spurious; they cannot be reached from unmatched facets.
///
/// Throws Error(invariant) where the walk leaves O or a facet is not closed by exactly one polytope. Memory: as
/// Delaunay for the unfinished sites.
void add_remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Hulls& hulls,
                   CellsPart& whole, Context* context);

}  // namespace quench::dual::peel
