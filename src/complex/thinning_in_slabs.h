// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "complex/live_cells.h"

namespace quench::complex {

/// Removes the simple pairs of keys below a bound, which grows step by step, in ranges of indices ("slabs") at once,
/// one for each thread. The levels are those of thinning by one queue. Returns the last bound: no pair of a smaller key
/// is left.
///
/// Why the levels are the same. Let t be a bound, and let no pair be left of a key below the bound before it. The cells
/// of values below t, linked where one bounds the other, fall into components.
/// - A pair of key < t lies in one component. Whether it is simple depends on how many larger cells are live at its
///   cells; those of them that a removal of key < t takes away are in the component. So components do not see each
///   other: each loses the same pairs in the same order whether the others are there or not, and one queue gets to keys
///   >= t when all of them are done.
/// - A level is the running maximum of the keys. A pair P below that maximum was not to be had when the pair R that set
///   it was taken, or it would have come first; so a removal Q after R, at the same maximum, or R itself laid it free,
///   in the component of P. By induction from Q back, the maximum over the pairs of the component alone is the same.
/// Slabs find components among their own cells by union-find. A component that crosses slabs falls into pieces, each in
/// one slab and with a link to another one: so a slab knows its pieces of them without the other slabs. They are
/// thinned by one more queue, beside those of the slabs. Cells of t or more are shared by all queues, and only lose
/// cofaces.
///
/// `most_crossing`: share of pairs in components that cross slabs, above which a smaller bound is tried, and after some
/// tries none. `width`: of the buckets of queues. `step(pairs)` is called now and then on the thread that removed so
/// many pairs; false: stop. For each of some ten bounds O(n log n), and O(links between slabs) in every slab; 4 bytes
/// per vertex and edge for components, 16 per pair that is simple at a bound, up to 16 per link between slabs: for
/// complexes whose indices are near in space for cells that are near.
double thin_in_slabs(LiveCells& cells, std::size_t slabs, double most_crossing, double width,
                     const std::function<bool(std::size_t pairs)>& step);

}  // namespace quench::complex
