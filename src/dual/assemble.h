// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dual/cells.h"
#include "dual/dual_complex.h"

namespace quench::dual {

/// The polytopes in the order of their site lists. Linear time up to small sorts, on all threads.
std::vector<std::uint32_t> order_of(const Cells& cells, std::size_t site_count, Context* context);
/// Polytope order[i] becomes polytope i.
Cells permuted(const Cells& cells, std::span<const std::uint32_t> order, Context* context);

/// The dual complex of all polytopes inside O. Its vertices are sorted by their site lists, edges by their ends, faces
/// by their sites: the numbering depends on the complex alone. Corners of a face run counter-clockwise around the
/// direction from its first to its second site, from the smallest corner. Throws Error(invariant) where a facet is
/// unmatched. Linear time up to small sorts, on all threads.
DualComplex assemble(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context);

/// The same of polytopes that are in order already and of which some are not known or pruned: of what is there. A face
/// is there where the star of polytopes around its sites closes.
DualComplex assemble_part(Cells cells, const Hulls& hulls, std::size_t site_count, Context* context);

}  // namespace quench::dual
