// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lattice/predicates.h"
#include "peeling/cells.h"
#include "peeling/site_index.h"

namespace quench::peeling {

/// Gift wrapping among the sites nearby: finds the cell across a facet by shrinking a ball. One per thread.
class Wrapping {
 public:
  /// `reach`: largest radius of a ball that is looked for, in units of the integer spacing.
  Wrapping(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
           const lattice::Predicates& predicates, const SiteIndex& index, double reach);

  /// `facet`: the sites of a facet of the Delaunay complex, counter-clockwise seen from the side that is asked for.
  /// Puts the sites of the cell there into `cell`, ascending, and returns true; false where its ball is larger than
  /// the reach, or will be all but certainly. `behind`: another site of the cell on this side of the facet; kNone where
  /// there is none. The sites of a facet all lie on the plane of the cell, so those on its ball and above the plane are
  /// the others. O(sites in the box of a ball of radius `reach`).
  bool cell_across(std::span<const std::uint32_t> facet, std::uint32_t behind, std::vector<std::uint32_t>& cell);

 private:
  // The largest ball through a facet: its part above the facet's plane lies in the box.
  struct Limit {
    LatticePoint low, high;
    std::array<double, 3> centre;  // in units of the integer spacing, relative to the first corner
    bool level;                    // the plane is one of the lattice, and the box lies above it
  };
  bool limit(const lattice::Point& a, const lattice::Point& b, const lattice::Point& c, std::uint32_t behind,
             Limit& limit) const;

  std::span<const LatticePoint> sites_;
  std::array<double, 3> spacing_;
  const lattice::Predicates& predicates_;
  const SiteIndex& index_;
  double reach_, step_;
  std::vector<std::pair<lattice::Point, SiteIndex::Name>> candidates_;
};

}  // namespace quench::peeling
