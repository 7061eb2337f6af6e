// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/skeleton.h"

namespace quench::skeleton {

/// The cells of K that a member of the family has.
struct Member {
  std::vector<char> vertex, edge, face;
};

/// `radii` and `tips` as ExtractOptions::theta1_radii and ::regrow_tips_above.
Member member_of(const SkeletonFamily& family, double theta2, double theta1, double radii, double tips);

inline std::uint32_t other_end(const RefinedAxis& k, std::uint32_t edge, std::uint32_t vertex) {
  const auto [a, b] = k.complex.edges[edge];
  return a == vertex ? b : a;
}

}  // namespace quench::skeleton
