// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/site_index.h"

#include "delaunay/bounds.h"

namespace quench::dual::peel {

SiteIndex::SiteIndex(std::span<const LatticePoint> sites) {
  last_ = delaunay::bounds_of(sites)[1];
  for (std::size_t a = 0; a < 3; ++a) dims_[a] = static_cast<std::size_t>(last_[a] / 16 + 1);
  groups_.assign(dims_[0] * dims_[1] * dims_[2], kEmpty);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto& [x, y, z] = sites[i];
    std::uint32_t& group =
        groups_[static_cast<std::size_t>(x >> 4) +
                dims_[0] * (static_cast<std::size_t>(y >> 4) + dims_[1] * static_cast<std::size_t>(z >> 4))];
    if (group == kEmpty) {
      group = static_cast<std::uint32_t>(slots_.size() / 64);
      slots_.resize(slots_.size() + 64, kEmpty);
    }
    std::uint32_t& block = slots_[64 * std::size_t{group} + slot(x >> 2, y >> 2, z >> 2)];
    if (block == kEmpty) {
      block = static_cast<std::uint32_t>(blocks_.size());
      blocks_.emplace_back();
    }
    const auto line = static_cast<std::size_t>((y & 3) | (z & 3) << 2);
    std::uint64_t& mask = blocks_[block].mask;
    if (!(mask >> (4 * line) & 15)) blocks_[block].first[line] = static_cast<std::uint32_t>(i);
    mask |= 1ull << (4 * line + static_cast<std::size_t>(x & 3));
  }
}

}  // namespace quench::dual::peel
