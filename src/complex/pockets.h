// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quench/complex.h"

namespace quench::complex {

/// One flag per face: whether it is left after removing, repeatedly, every face with a free edge (an edge of no other
/// face). What is left is the maximal subcomplex without free edges (the 2-core): every 2-cycle lies in it, and fire
/// never reaches it. O(n).
std::vector<char> faces_in_pockets(const CellComplex& complex);

}  // namespace quench::complex
