// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "quench/error.h"
#include "tree/measured_tree.h"

namespace quench {

std::string unit_to_the(const std::string& unit, int power) {
  return unit.empty() || power == 1 ? unit : unit + "^" + std::to_string(power);
}

Traits traits_of(const Tree& tree, const TraitOptions& options) {
  if (!(options.sholl_step >= 0) || std::isinf(options.sholl_step))
    throw Error(ErrorCode::usage, "sholl_step must be a length, 0 or more", "sholl_step");
  if (options.depth_bins < 1) throw Error(ErrorCode::usage, "depth_bins must be 1 or more", "depth_bins");
  const tree::MeasuredTree measured(tree);
  Traits traits;
  traits.axes = tree::axes_table(measured);
  traits.branches = tree::branches_table(measured);
  traits.sholl = tree::sholl_table(measured, options.sholl_step);
  traits.depths = tree::depths_table(measured, options.depth_bins);
  traits.sample = tree::sample_table(measured, traits.axes, traits.branches, traits.sholl);
  return traits;
}

}  // namespace quench
