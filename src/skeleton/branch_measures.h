// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/curve_graph.h"

namespace quench {

/// Fills length, radii and tortuosity of a branch from its points.
void measure(CurveGraph::Branch& branch);

}  // namespace quench
