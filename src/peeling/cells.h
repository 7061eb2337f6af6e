// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/insertion.h"
#include "peeling/hulls.h"

namespace quench::peeling {

using lattice::kNone;

inline constexpr std::uint32_t kOpen = kNone;          ///< nobody knows yet what lies across the facet
inline constexpr std::uint32_t kBoundary = kNone - 1;  ///< the facet is a square of the boundary of O

/// Polytopes of the Delaunay complex inside O and what lies across their facets.
struct Cells {
  std::vector<std::uint32_t> site_begin{0}, sites;            ///< corners of each cell, ascending site ids
  std::vector<std::uint32_t> hull;                            ///< their hull: its corners are ranks in that list
  std::vector<std::uint32_t> neighbour_begin{0}, neighbours;  ///< per facet of the hull: a cell, kBoundary or kOpen

  std::uint32_t count() const { return static_cast<std::uint32_t>(hull.size()); }
  std::span<const std::uint32_t> sites_of(std::uint32_t cell) const {
    return {sites.data() + site_begin[cell], sites.data() + site_begin[cell + 1]};
  }
  std::span<std::uint32_t> neighbours_of(std::uint32_t cell) {
    return {neighbours.data() + neighbour_begin[cell], neighbours.data() + neighbour_begin[cell + 1]};
  }
  std::span<const std::uint32_t> neighbours_of(std::uint32_t cell) const {
    return {neighbours.data() + neighbour_begin[cell], neighbours.data() + neighbour_begin[cell + 1]};
  }
  /// A cell with open facets.
  std::uint32_t add(std::span<const std::uint32_t> corners, std::uint32_t number, std::uint32_t facets) {
    sites.insert(sites.end(), corners.begin(), corners.end());
    site_begin.push_back(static_cast<std::uint32_t>(sites.size()));
    hull.push_back(number);
    neighbours.resize(neighbours.size() + facets, kOpen);
    neighbour_begin.push_back(static_cast<std::uint32_t>(neighbours.size()));
    return count() - 1;
  }
  /// Room for all cells of a shape with so many sites. Memory that is not written costs nothing.
  void reserve_for(std::size_t site_count);
  /// Appends the cells of all parts, which it consumes. Neighbours are numbered per part, or already as they will be.
  enum class Numbers { per_part, final };
  void append(std::vector<Cells>& parts, Numbers numbers);
};

/// The three smallest sites of a facet tell it from all others: its sites lie on one circle, so no three of them on a
/// line, and they fix its plane and the circle.
using FacetName = std::array<std::uint32_t, 3>;

/// Four sites of a boundary square, counter-clockwise seen from inside O.
using Square = std::array<std::uint32_t, 4>;

}  // namespace quench::peeling
