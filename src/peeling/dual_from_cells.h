// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lattice/cells.h"
#include "peeling/cells.h"
#include "quench/context.h"

namespace quench::peeling {

/// The dual complex of all cells inside O, sorted as DualComplex says. Throws Error(invariant) where a facet is open.
/// Linear time up to small sorts, on all threads.
lattice::DualComplex dual_from_cells(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context);

}  // namespace quench::peeling
