// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "quench/geometry.h"

namespace quench::graph {

/// Least distance of two segments a0 a1 and b0 b1, of length zero allowed.
double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// A segment whose end points are identified by `ends`, not by position: two segments with an end in common may meet
/// there and nowhere else.
struct NamedSegment {
  Vec3 a, b;
  std::array<std::uint64_t, 2> ends;
};

/// Whether two segments touch elsewhere than at common ends, up to `tolerance`.
bool in_contact(const NamedSegment& s, const NamedSegment& t, double tolerance);

/// Calls `found(i, j)` at least once for every two segments i < j in contact for which `wanted(i, j)`. Deterministic.
/// Uses a grid of cells as large as a mean segment: O(n) where segments are of similar length and not crowded.
void for_each_contact(const std::vector<NamedSegment>& segments, double tolerance,
                      const std::function<bool(std::uint32_t, std::uint32_t)>& wanted,
                      const std::function<void(std::uint32_t, std::uint32_t)>& found);

}  // namespace quench::graph
