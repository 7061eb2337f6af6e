// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/geometry.h"

namespace quench::io {

/// Numbers points so that equal positions (0 equals -0) get one number, in order of first appearance. Amortised O(1)
/// per point; the coordinates must be finite.
class Weld {
 public:
  /// The number of `point` in `points`; appends it when it is new.
  std::uint32_t operator()(const Vec3& point, std::vector<Vec3>& points);

 private:
  void grow(const std::vector<Vec3>& points);

  std::vector<std::uint32_t> slots_;  ///< open addressing, linear probing; a power of two at most half full
};

}  // namespace quench::io
