// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/tree.h"
#include "tree/repair_model.h"
#include "tree/repair_result.h"

namespace quench::tree {

/// Every plausible bridge between two components: from free ends and isolated nodes to free ends, to isolated nodes and
/// to the nearest place of other branches, within `reach` (0: some radii of the end). In a fixed order.
std::vector<Bridge> bridges_of(const Model& model, double reach, const GreyValues* grey, Context* context);

}  // namespace quench::tree
