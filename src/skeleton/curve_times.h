// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/skeleton.h"

namespace quench::skeleton {

/// Burns the medial curves, moves every region dual onto the neighbour it passed the fire to, and burns again: the
/// hairs of the network, which run beside the fire, are then no longer than what they stand for. Fills
/// `curve_burn_time`, `exit` and `medial_point`.
void burn_curve_network(RefinedAxis& axis, Context* context);

}  // namespace quench::skeleton
