// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/graph.h"

namespace quench::graph {

/// Fills length, radii and tortuosity of a branch from its points.
void measure(CurveGraph::Branch& branch);

}  // namespace quench::graph
