// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "base/csr.h"
#include "skeleton/burned_axis.h"

namespace quench::skeleton {

/// What of an axis stays on its medial curves as it is.
struct KeptNodes {
  std::vector<std::uint32_t> lone_edges;  ///< edges without polygon
  std::vector<std::uint32_t> isolated;    ///< vertices of nothing
  /// Per polygon: vertices that split their link, so that they are kept, with an edge to one region in every component
  /// without pocket: in this polygon, whose sector burned last there.
  base::Csr<std::uint32_t> spokes;
};

/// O(n). Throws Error(invariant) when the number of prime arcs at a node is not the number of cycles of its link.
KeptNodes kept_nodes(const BurnedAxis& axis);

}  // namespace quench::skeleton
