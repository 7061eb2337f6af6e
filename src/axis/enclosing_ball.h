// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "quench/geometry.h"

namespace quench::axis {

/// Squared radius of the smallest ball that encloses the points (Welzl 1991, move to front). Expected linear time; the
/// points should be near the origin (coordinates exact in double). Relative error about 1e-14.
double enclosing_ball_squared_radius(std::span<Vec3> points);

}  // namespace quench::axis
