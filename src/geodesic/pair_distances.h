// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geodesic/voxel_surface.h"
#include "quench/context.h"

namespace quench::geodesic {

/// What pair_distances() did, for benchmarks.
struct PairCounts {
  std::size_t near = 0, far = 0, landmarks = 0;
  std::int64_t windows = 0;
};

/// The lengths of the shortest ways between pairs of points of a surface, exact up to rounding, in units of the
/// surface; infinite between components. Results do not depend on the number of threads.
///
/// Ways to points nearby are searched for with the straight distance as the least that is left. For others there are
/// landmarks, points with their distances from all others: |d(a, x) - d(a, q)| <= d(x, q), nearly equal where the
/// landmark a is behind q. A search in which ways that are longer than a limit with these bounds are left out is exact
/// when it gets there within the limit; else the limit grows.
///
/// Memory: that of a WindowSearch per thread, and 4 bytes per point and landmark (of which there are as many as
/// `landmark_bytes` allow). Stage of progress: "geodesics".
std::vector<double> pair_distances(const VoxelSurface& surface, std::span<const std::array<std::uint32_t, 2>> pairs,
                                   std::int64_t landmark_bytes, Context* context, PairCounts* counts = nullptr);

}  // namespace quench::geodesic
