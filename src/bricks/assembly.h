// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bricks/brick.h"
#include "lattice/cells.h"

namespace quench::bricks {

/// Puts the parts of all bricks together, in the numbering of lattice::DualComplex; frees them on the way. Throws
/// Error(invariant) when they do not fit, Error(failed) when the result outgrows 32-bit indices. Linear time up to
/// small sorts, on all threads.
lattice::DualComplex assemble(std::vector<BrickPart> parts, std::size_t site_count, Context* context);

}  // namespace quench::bricks
