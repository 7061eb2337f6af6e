// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "quench/geometry.h"

namespace quench::skeleton {

/// A step of a way along curves from a free end inwards: a vertex, and the other end of the last edge at it.
struct StepInwards {
  std::uint32_t vertex, to;
};

/// Per step: by how much the ball of its vertex x has to grow to contain those of all vertices y whose ways pass x,
/// max |x - y| + t_y - t_x with times as radii. That is what fire that came straight from y would be late at x. Steps
/// are in the order of the peeling, each vertex at most once, outer ones first. Branch and bound over boxes: about
/// O(n log n), at most the sum over steps of what is outside, where all balls outside stick out equally far.
std::vector<double> growth_to_contain(std::span<const StepInwards> steps, std::span<const Vec3> points,
                                      std::span<const double> times);

}  // namespace quench::skeleton
