// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/index.h"
#include "dual/hulls.h"
#include "quench/context.h"

/// Every way to the Delaunay complex inside O hands over the same value: polytopes and what lies across their facets.
/// Parts of it are found independently of each other; facets between them are matched by their sites.
namespace quench::dual {

inline constexpr std::uint32_t kUnmatched = kNone;     ///< it is not yet known what lies across the facet
inline constexpr std::uint32_t kBoundary = kNone - 1;  ///< the facet is a square of the boundary of O
inline constexpr std::uint32_t kPruned = kNone - 2;    ///< there was a link between two polytopes, which is pruned

/// Polytopes of the Delaunay complex inside O (maximal cospherical sets of sites) and what lies across their facets.
struct Cells {
  std::vector<std::uint32_t> site_begin{0}, sites;  ///< corners of each polytope, ascending site ids
  std::vector<std::uint32_t> hull;                  ///< in Hulls; its corners are ranks among the sites
  std::vector<std::uint32_t> neighbour_begin{0},
      neighbours;  ///< per facet of the hull: a polytope, or one of the three above

  std::uint32_t count() const { return static_cast<std::uint32_t>(hull.size()); }
  std::span<const std::uint32_t> sites_of(std::uint32_t polytope) const {
    return {sites.data() + site_begin[polytope], sites.data() + site_begin[polytope + 1]};
  }
  std::span<std::uint32_t> neighbours_of(std::uint32_t polytope) {
    return {neighbours.data() + neighbour_begin[polytope], neighbours.data() + neighbour_begin[polytope + 1]};
  }
  std::span<const std::uint32_t> neighbours_of(std::uint32_t polytope) const {
    return {neighbours.data() + neighbour_begin[polytope], neighbours.data() + neighbour_begin[polytope + 1]};
  }
  /// Appends a polytope with unmatched facets.
  std::uint32_t add(std::span<const std::uint32_t> corners, std::uint32_t its_hull, std::uint32_t facets) {
    sites.insert(sites.end(), corners.begin(), corners.end());
    site_begin.push_back(static_cast<std::uint32_t>(sites.size()));
    hull.push_back(its_hull);
    neighbours.resize(neighbours.size() + facets, kUnmatched);
    neighbour_begin.push_back(static_cast<std::uint32_t>(neighbours.size()));
    return count() - 1;
  }
  /// Room for all polytopes of a shape with so many sites. Memory that is not written costs nothing.
  void reserve_for(std::size_t site_count);
};

/// The three smallest sites of a facet, ascending: they uniquely identify it. Its sites lie on one circle, so no three
/// of them are on a line, and three fix its plane and the circle.
using FacetKey = std::array<std::uint32_t, 3>;

inline FacetKey key_of(const Hull& hull, std::uint32_t facet, std::span<const std::uint32_t> sites) {
  const auto& corners = hull.smallest[facet];
  return {sites[corners[0]], sites[corners[1]], sites[corners[2]]};
}

/// Four sites of a boundary square, counter-clockwise seen from inside O.
using Square = std::array<std::uint32_t, 4>;

/// A facet of a polytope, or a boundary square, whose polytope on the other side is not known.
struct UnmatchedFacet {
  FacetKey key;
  std::uint32_t polytope;  ///< kNone: a boundary square
  std::uint32_t facet;     ///< of the polytope's hull; the place of a square in CellsPart::squares
};

/// What one worker has found of the complex.
struct CellsPart {
  Cells cells;
  std::vector<UnmatchedFacet> unmatched;
  std::vector<Square> squares;  ///< those that unmatched facets refer to

  /// Corners of an unmatched facet, counter-clockwise seen from the unknown side.
  class Corners {
   public:
    Corners(std::span<const std::uint32_t> corners, const std::uint32_t* sites) : corners_(corners), sites_(sites) {}
    std::size_t size() const { return corners_.size(); }
    std::uint32_t operator[](std::size_t i) const { return sites_ ? sites_[corners_[i]] : corners_[i]; }

   private:
    std::span<const std::uint32_t> corners_;
    const std::uint32_t* sites_;  // null: the corners are sites themselves
  };
  Corners corners_of(const UnmatchedFacet& f, const Hulls& hulls) const {
    if (f.polytope == kNone) return {squares[f.facet], nullptr};
    return {hulls[cells.hull[f.polytope]].corners_of(f.facet), cells.sites_of(f.polytope).data()};
  }
};

/// How the polytopes of several parts are numbered: from 0 in each, or already as in the whole that they are appended
/// to.
enum class Numbers { per_part, final };

/// Appends all parts to `whole`; frees them on the way. Throws Error(failed) when indices outgrow 32 bits. Linear time,
/// on all threads.
void append(std::vector<CellsPart>& parts, Numbers numbers, CellsPart& whole);

/// Makes polytopes neighbours that have a facet with the same key; one with the key of a square gets kBoundary. What
/// has no partner stays unmatched. `stage` and `progress` are told to the context. Linear time, on all threads.
void match(CellsPart& part, std::size_t site_count, Context* context, std::string_view stage, double progress);

/// As match(), for the whole complex. Throws Error(invariant) when a facet has no partner: as each takes one, every
/// unmatched facet is closed exactly once then.
void match_all(CellsPart& part, std::size_t site_count, Context* context, std::string_view stage, double progress);

}  // namespace quench::dual
