// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "delaunay/predicates.h"
#include "dual/cells.h"
#include "dual/peel/site_index.h"

namespace quench::dual::peel {

/// Gift wrapping among the sites nearby: finds the polytope across a facet by shrinking a ball. One per thread.
class Wrapping {
 public:
  /// `reach`: largest radius of a ball that is looked for, in units of the integer spacing.
  Wrapping(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
           const delaunay::Predicates& predicates, const SiteIndex& index, double reach);

  /// `facet`: the sites of a facet of the Delaunay complex, counter-clockwise seen from the side that is asked for.
  /// Puts the sites of the polytope there into `found`, ascending, and returns true; false where its ball is larger
  /// than the reach, or most probably is. `behind`: another site of the polytope on this side of the facet; kNone where
  /// there is none. The facet has all sites of its plane, so the other sites of the polytope are those on its ball
  /// above the plane. O(sites in the box of a ball of radius `reach`).
  bool polytope_across(std::span<const std::uint32_t> facet, std::uint32_t behind, std::vector<std::uint32_t>& found);

 private:
  // The largest ball through a facet: its part above the facet's plane lies in the box.
  struct Limit {
    LatticePoint low, high;
    std::array<double, 3> centre;  // in units of the integer spacing, relative to the first corner
    bool level;                    // the plane is one of the lattice, and the box lies above it
  };
  bool limit(const delaunay::Point& a, const delaunay::Point& b, const delaunay::Point& c, std::uint32_t behind,
             Limit& limit) const;

  std::span<const LatticePoint> sites_;
  std::array<double, 3> spacing_;
  const delaunay::Predicates& predicates_;
  const SiteIndex& index_;
  double reach_, step_;
  std::vector<std::pair<delaunay::Point, SiteIndex::Entry>> candidates_;
};

}  // namespace quench::dual::peel
