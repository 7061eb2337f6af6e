// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "quench/error.h"
#include "quench/geometry.h"

/// Indices of 32 bits: half the memory of 64, and enough for all that fits the memory of one machine.
namespace quench::base {


/// Throws Error(failed) when a number of cells or corners outgrows 32-bit indices; the two largest have other meanings.
inline void check_index(std::size_t count) {
  if (count >= kNone - 1)
    throw Error(ErrorCode::failed, "the voxel core outgrows 32-bit indices; use a lower resolution");
}

/// Turns counts[i + 1] = size of bucket i into offsets; throws Error(failed) when they outgrow 32 bits.
inline void prefix_sum(std::vector<std::uint32_t>& counts) {
  std::uint64_t sum = 0;
  for (std::uint32_t& count : counts) {
    sum += count;
    check_index(sum);
    count = static_cast<std::uint32_t>(sum);
  }
}

}  // namespace quench::base
