// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_bridges.h"
namespace quench::tree {
std::vector<Bridge> bridges_of(const Model&, double, const GreyValues*, Context*) { return {}; }
}  // namespace quench::tree
