// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "quench/geometry.h"

namespace quench::surface {

/// A triangle of a welded surface.
struct Facet {
  std::array<Vec3, 3> at;
  std::array<std::uint32_t, 3> corner;  ///< equal where two triangles have a corner at the same place
  Vec3 normal = Vec3::Zero();           ///< of length 1
  double bend = 0;                      ///< bound of the error of the normal by rounding; large for thin triangles
  bool flat = false;                    ///< its height is within the tolerance: it has no normal

  Facet(const std::array<Vec3, 3>& at, const std::array<std::uint32_t, 3>& corner, double near);
  /// Signed distance of a point from the plane; 0 within `near` and the error of the normal.
  double height(const Vec3& p, double near) const;
};

/// What two triangles have in common.
struct Meeting {
  enum class Kind { none, segment, overlap };  ///< `overlap`: they lie in one plane
  Kind kind = Kind::none;
  std::array<Vec3, 2> ends{};  ///< of the segment
};

/// The common part of two triangles of a surface, none of them flat. Points alone, common edges of neighbours, and
/// edges where triangles of one plane touch are none. Errs towards a segment or an overlap, never towards none, by
/// rounding and where lengths are near `near`.
Meeting meeting(const Facet& s, const Facet& t, double near);

}  // namespace quench::surface
