// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "surface/box_tree.h"
#include "surface/facet.h"

namespace quench::surface {

/// What a point of a triangle is to the boundary of the solid.
enum class Side : std::uint8_t {
  none,    ///< both sides are in the solid, or none is; or an earlier triangle is there already
  behind,  ///< the solid lies behind the triangle, as it should
  before   ///< the triangle faces the solid
};

/// The solid of a closed surface, by crossings along rays.
class Inside {
 public:
  /// `odd`: the winding number must be odd, whatever the orientation; else it must not be 0. `tree`: of the boxes of
  /// the facets. Both must outlive it.
  Inside(std::span<const Facet> facets, const BoxTree& tree, bool odd, double near)
      : facets_(facets), tree_(tree), odd_(odd), near_(near) {}

  /// At a point of a facet that is not flat, at least some 20 `near` away from all triangles that are not in its plane.
  /// O(log n + crossings).
  Side side(const Vec3& p, std::uint32_t facet) const;

 private:
  struct Ray;
  struct Count {
    std::int64_t beyond = 0;  ///< crossings beyond the point
    std::int64_t at = 0;      ///< of the triangles in the plane of the facet at the point, the facet among them
    bool first = true;        ///< the facet comes first among these
    bool doubtful = false;    ///< the ray passes an edge too near
  };
  Count count(const Ray& ray, std::uint32_t facet) const;
  void add(const Facet& facet, bool earlier, const Ray& ray, Count& count) const;
  bool in_solid(std::int64_t winding) const { return odd_ ? winding % 2 != 0 : winding != 0; }

  std::span<const Facet> facets_;
  const BoxTree& tree_;
  bool odd_;
  double near_;
};

}  // namespace quench::surface
