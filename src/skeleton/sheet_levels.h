// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/complex.h"
#include "quench/skeleton.h"

namespace quench::skeleton {

/// The sheet levels of all cells of a refined axis: what complex::thin() gives where the curves have infinite values,
/// faces their thickness, and all other cells 0. The cells off the curves fall into parts that share no cell, trees of
/// the fire, and each part is thinned for itself, in parallel. O(n), with the logarithm of the size of a part; 8 bytes
/// per vertex and edge and 12 per face beside the result.
CellValues sheet_levels(const RefinedAxis& axis, Context* context);

}  // namespace quench::skeleton
