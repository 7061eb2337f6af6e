// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dual/cells.h"
#include "dual/dual_complex.h"

namespace quench::dual {

/// The dual complex of all polytopes inside O. Its vertices are sorted by their site lists, edges by their ends, faces
/// by their sites: the numbering depends on the complex alone. Corners of a face run counter-clockwise around the
/// direction from its first to its second site, from the smallest corner. Throws Error(invariant) where a facet is
/// unmatched. Linear time up to small sorts, on all threads.
DualComplex assemble(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context);

}  // namespace quench::dual
