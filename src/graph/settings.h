// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/skeleton.h"

namespace quench::graph {

/// How a skeleton was made, for one that is made of it.
inline void copy_settings(const Skeleton& from, Skeleton& to) {
  to.theta2 = from.theta2;
  to.theta1 = from.theta1;
  to.theta1_radii = from.theta1_radii;
  to.full_tips = from.full_tips;
  to.rims_above = from.rims_above;
  to.smooth = from.smooth;
  to.plane = from.plane;
  to.main_axes = from.main_axes;
}

}  // namespace quench::graph
