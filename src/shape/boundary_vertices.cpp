// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "quench/voxel_shape.h"

namespace quench {

// A lattice point (x, y, z) touches the voxels x-1 and x of the scanlines (y-1, z-1), (y, z-1), (y-1, z), (y, z).
// Between two ends of runs the four scanlines have one 4-bit mask of foreground; the point is a site exactly when the
// masks left and right of it are not both empty or both full.
std::vector<LatticePoint> boundary_vertices(const VoxelShape& shape) {
  std::vector<LatticePoint> sites;
  const auto& dims = shape.grid().dims;
  std::vector<std::int32_t> events;  // x * 4 + scanline: each event toggles one bit of the mask
  for (std::int64_t z = 0; z <= dims[2]; ++z)
    for (std::int64_t y = 0; y <= dims[1]; ++y) {
      events.clear();
      for (int s = 0; s < 4; ++s)
        for (const Run& run : shape.row(y - 1 + (s & 1), z - 1 + (s >> 1))) {
          events.push_back(run.begin * 4 + s);
          events.push_back(run.end * 4 + s);
        }
      if (events.empty()) continue;
      std::sort(events.begin(), events.end());
      const auto site = [&](std::int32_t x) {
        sites.push_back({x, static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
      };
      unsigned mask = 0;
      std::int32_t next = events.front() / 4;  // first point not yet decided
      for (std::size_t e = 0; e < events.size();) {
        const std::int32_t x = events[e] / 4;
        if (mask != 0 && mask != 15)
          for (; next < x; ++next) site(next);
        unsigned change = 0;
        for (; e < events.size() && events[e] / 4 == x; ++e) change ^= 1u << (events[e] & 3);
        mask ^= change;
        if (change) site(x);
        next = x + 1;
      }
    }
  return sites;
}

}  // namespace quench
