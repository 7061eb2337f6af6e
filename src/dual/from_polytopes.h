// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "delaunay/polytopes.h"
#include "dual/cells.h"

namespace quench::dual {

/// Which polytopes of a triangulation are wanted, and what is known of them.
struct PolytopeSelection {
  /// Per site of the triangulation: its number among all sites, ascending. Empty: the same.
  std::span<const std::uint32_t> site;
  /// Per polytope: its number among those wanted, ascending, or kNone; empty: all are wanted.
  std::span<const std::uint32_t> number;
  /// Whether a facet that no wanted polytope is behind lies on the boundary of O, by three of its sites (of the
  /// triangulation). Called by many threads.
  std::function<bool(const std::array<std::uint32_t, 3>&)> on_boundary;
};

/// Appends polytopes of a triangulation to `whole`, with their facets: those between two of them are matched, the
/// others lie on the boundary of O or are unmatched. Linear time but for polytopes with hundreds of unmatched facets,
/// on all threads; frees `polytopes` early.
void append(delaunay::Polytopes polytopes, std::span<const LatticePoint> sites, const PolytopeSelection& selection,
            Hulls& hulls, CellsPart& whole, Context* context);

}  // namespace quench::dual
