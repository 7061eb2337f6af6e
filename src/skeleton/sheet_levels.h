// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/complex.h"
#include "quench/skeleton.h"

namespace quench::skeleton {

/// The sheet levels of all cells of a refined axis: what complex::thin() gives where the curves have infinite values,
/// faces their thickness, and all other cells 0. The cells off the curves fall into parts that share no cell, trees of
/// the fire, and each part is thinned for itself, in parallel. O(n), with the logarithm of the size of a part; 8 bytes
/// per vertex, 12 per edge and face beside the result.
///
/// `corners`: RefinedAxis::corner_thickness, which becomes SkeletonFamily::corner_sheet_level. Where the thinning comes
/// to a face over an edge at some level, no corner of it has a smaller one: water that rises from the rims fills what
/// lies behind a ridge at once.
CellValues sheet_levels(const RefinedAxis& axis, std::vector<float>& corners, Context* context);

}  // namespace quench::skeleton
