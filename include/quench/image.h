// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/volume.h"
#include "quench/voxel_shape.h"

namespace quench {

enum class SampleType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };

/// Samples that somebody else owns, in any order in memory: sample (x, y, z) is `strides[0]*x + strides[1]*y +
/// strides[2]*z` bytes after `data`. Strides may be negative or 0; samples need not be aligned. Nothing is copied.
struct ImageView {
  Grid grid;
  SampleType type = SampleType::uint8;
  const void* data = nullptr;
  std::array<std::int64_t, 3> strides{0, 0, 0};
};

/// The samples of a volume.
ImageView view_of(const Volume& volume);

/// As foreground() of a volume. The result does not depend on the order in memory. Memory beyond the shape: 8 bytes per
/// voxel of one slice where x is not the closest axis in memory, else nothing.
VoxelShape foreground(const ImageView& image, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr);

/// A label of an image and the box of its voxels.
struct LabelRuns {
  /// Voxels [begin, end) along x in scanline (y, z).
  struct Piece {
    std::int32_t z, y, begin, end;
    friend auto operator<=>(const Piece&, const Piece&) = default;
  };
  std::int64_t label = 0;
  std::vector<Piece> pieces;  ///< in no particular order
  /// The voxels of the label on a grid cut to their box: world coordinates are those of the whole image.
  VoxelShape shape(const Grid& image) const;
};

/// The voxels of every label that `wanted` takes (all but 0 without it), in one pass, by ascending label: 16 bytes per
/// run of equal values. Throws Error(input) for samples that are no integers.
std::vector<LabelRuns> label_runs(const ImageView& image, const std::function<bool(std::int64_t)>& wanted = nullptr,
                                  Context* context = nullptr);

}  // namespace quench
