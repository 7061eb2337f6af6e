// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "burning/domain.h"
#include "burning/window_queue.h"

namespace quench::burning {

/// Granularity of the blocked label-correcting queue. What fire reads of so many states is a megabyte. In wider
/// windows a block does more of its work at once, but repeats more of it when fire comes in from other blocks. The
/// order of time alone (one block, narrow windows) takes 1.9 times as long on a core of 10^5 nodes, 2.6 times on one of
/// 1.6 * 10^6.
struct BlockSchedule {
  std::uint64_t states_per_block = 4096;
  double window_width = 8;  ///< in spacings of nodes
};

/// The order in which labels are corrected.
using LabelQueue = WindowQueue;

/// An empty queue for the states of a domain.
LabelQueue make_label_queue(const BurnDomain& domain, const BlockSchedule& schedule);

}  // namespace quench::burning
