// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "quench/complex.h"
#include "quench/shape.h"

namespace quench::verification {

class Sites;

/// The boundary curves of a pixel shape, each walked along the unit edges between pixels inside and outside with the
/// inside on one side; where the shape touches itself in a corner, a curve stays with its pixel (the foreground is
/// 4-connected). O(sites log sites).
class BoundaryCurves {
 public:
  BoundaryCurves(const VoxelShape& shape, const Sites& sites);

  /// Every component has one curve around it, every hole one.
  Topology topology() const;
  /// The shorter way along the boundary between two sites in scaled units, infinite where they are on different curves.
  /// A site where the shape touches itself is on two: it is the one in the pixel towards the other site that counts.
  double shorter_way(std::uint32_t a, std::uint32_t b) const;

 private:
  struct Place {
    std::uint32_t curve = std::numeric_limits<std::uint32_t>::max();
    std::int64_t way = 0;  ///< from where the walk along the curve began
  };
  struct Step {
    std::uint32_t site;
    int direction;
  };
  void walk(Step first);
  Step next(const Step& step) const;
  std::uint32_t site_at(const LatticePoint& p) const;
  bool inside_left(const LatticePoint& p, int direction) const;
  bool inside_right(const LatticePoint& p, int direction) const;
  bool touches_itself(const LatticePoint& p) const;
  Place& place(std::uint32_t site, bool after) { return places_[2 * std::size_t{site} + (after ? 1 : 0)]; }
  const Place& place_towards(std::uint32_t site, std::uint32_t other) const;

  const VoxelShape& shape_;
  const Sites& sites_;
  std::vector<char> walked_;   // per site and direction: the unit edge from there
  std::vector<Place> places_;  // per site two: only where the shape touches itself the second differs, that of the
                               // pixel after it along x
  std::vector<std::int64_t> length_;  // per curve
  std::int64_t around_parts_ = 0, around_holes_ = 0;
};

}  // namespace quench::verification
