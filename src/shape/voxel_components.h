// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "base/union_find.h"
#include "quench/context.h"
#include "quench/shape.h"

/// Components of a voxel shape and of its background on runs. A *gap* is the background between two runs of a scanline;
/// what lies before the first run and after the last one, and every empty scanline, is connected to the outside of the
/// grid. Near-linear in the runs, 4 bytes per run.
namespace quench::shape {

/// Calls visit(i, j) for all overlapping runs a[i], b[j] of two scanlines, in order of x.
template <class Visit>
void for_overlaps(std::span<const Run> a, std::span<const Run> b, const Visit& visit) {
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].begin < b[j].end && b[j].begin < a[i].end) visit(i, j);
    a[i].end < b[j].end ? ++i : ++j;
  }
}

/// Calls visit(i, j) for all runs a[i], b[j] of two scanlines that overlap or follow one another, in order of x.
template <class Visit>
void for_touching(std::span<const Run> a, std::span<const Run> b, const Visit& visit) {
  for (std::size_t i = 0, first = 0; i < a.size(); ++i) {
    while (first < b.size() && b[first].end < a[i].begin) ++first;
    for (std::size_t j = first; j < b.size() && b[j].begin <= a[i].end; ++j) visit(i, j);
  }
}

/// Index among all runs of the first run of a scanline; 0 for an empty one.
inline std::uint32_t first_index(const VoxelShape& shape, std::span<const Run> row) {
  return row.empty() ? 0 : static_cast<std::uint32_t>(row.data() - shape.runs().data());
}

/// Calls visit(y, z) for all scanlines, and checkpoint() once per slice.
template <class Visit>
void for_scanlines(const VoxelShape& shape, Context* context, std::string_view stage, const Visit& visit) {
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    checkpoint(context, stage, static_cast<double>(z) / static_cast<double>(dims[2]));
    for (std::int64_t y = 0; y < dims[1]; ++y) visit(y, z);
  }
  checkpoint(context, stage, 1);
}

/// The 6-connected (in a plane 4-connected) components of the foreground, as sets of runs.
base::UnionFind foreground_components(const VoxelShape& shape, Context* context = nullptr);

/// The 26-connected (in a plane 8-connected) ones.
base::UnionFind touching_components(const VoxelShape& shape, Context* context = nullptr);

/// The 26-connected (in a plane 8-connected) components of the background, as sets of gaps: the gap after run i is
/// element i. The outside is the last element, runs().size(), and what lies after the last run of a scanline is in its
/// set.
base::UnionFind background_components(const VoxelShape& shape, Context* context = nullptr);

}  // namespace quench::shape
